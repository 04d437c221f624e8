"""Groups of two or three people who walk together, and their leaders.

Three neighbouring numbers of people are together by chance: all three are a group, or the first two, or nobody. The
first one is the leader; the others walk its way at its pace, one behind the other.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

LARGEST = 3
"""Most people in a group."""
BEHIND = 0.7
"""How far behind the one before it each member of a group walks [m]: our choice."""


def groups_drawn(people: int) -> int:
    """Return how many uniform numbers decide about groups: one for each three people, and for the rest."""
    return -(-people // LARGEST)


def chances(grouped: float) -> tuple[float, float]:
    """Return the probabilities that three people are one group, and that two of them are one.

    They are equal as long as they can be, and ``grouped`` is the share of people in groups: three + two x 2 / 3.
    """
    three = max(0.6 * grouped, 3 * grouped - 2)
    return three, 1.5 * (grouped - three)


def leaders(draws: Float[Array, " group"], people: int, grouped: float) -> Int[Array, " ped"]:
    """Return the number of the leader of each person's group; of somebody who walks alone its own.

    Of two people who are left over, both walk together with probability ``grouped``; a single one walks alone.
    """
    three, two = (np.full(groups_drawn(people), chance) for chance in chances(grouped))
    if people % LARGEST:
        three[-1], two[-1] = 0.0, grouped if people % LARGEST == 2 else 0.0
    of_three, together = draws < three, draws < three + two
    group, place = np.divmod(np.arange(people), LARGEST)
    size = 1 + together.astype(jnp.int32) + of_three
    return jnp.where(place < size[group], LARGEST * group, np.arange(people))


def behind(leader: Int[Array, "ped *batch"]) -> Float[Array, "ped *batch"]:
    """Return how far behind its leader each person walks [m]."""
    own = jnp.arange(len(leader)).reshape(-1, *(1,) * (leader.ndim - 1))
    return BEHIND * (own - leader)
