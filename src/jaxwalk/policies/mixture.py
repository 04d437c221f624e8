"""A population of several kinds of people in stated proportions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Key

from jaxwalk.acting import role_key
from jaxwalk.interfaces import Moment, Policy, View

KIND = slice(2, 4)
"""The traits by which a person is of a kind. They are drawn with the scenario; the simulator takes them only as a
source of chance (`jaxwalk.sim.perception.chance`)."""


def kind_draw(traits: Float[Array, "trait ..."]) -> Float[Array, "..."]:
    """Return the number in [0, 1) by which a person is of a kind: the fractional part of the sum of the two traits.

    It is uniform, and independent of each of the two alone. Learned people see both: by one of them, those in a mixture
    would be an odd part of all learned people.
    """
    return traits[KIND].sum(axis=0) % 1


@dataclass(frozen=True)
class Beside:
    """What every kind sees, and the number that says who is of which."""

    views: tuple[View, ...]

    @property
    def name(self) -> str:
        """The names of the views, each once."""
        return "+".join(dict.fromkeys(view.name for view in self.views))

    def __call__(self, moment: Moment) -> tuple[Float[Array, "ped *batch"], tuple[Any, ...]]:
        """Return that number and the views."""
        return kind_draw(moment.scenario.traits), tuple(view(moment) for view in self.views)


class Mixture(eqx.Module):
    """Each person is of one kind throughout, by the scenario: whoever plays it again meets the same people."""

    kinds: tuple[Policy, ...]
    """The policies of the kinds."""
    shares: tuple[float, ...] = eqx.field(static=True)
    """The share of each kind; together 1."""

    @property
    def view(self) -> View:
        """What it sees."""
        return Beside(tuple(kind.view for kind in self.kinds))

    @property
    def sample(self) -> bool:
        """Whether any kind draws its actions at random."""
        return any(getattr(kind, "sample", False) for kind in self.kinds)

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> tuple[Any, ...]:
        """Return the memories of all kinds."""
        return tuple(kind.init(agents, batch) for kind in self.kinds)

    def act(
        self, key: Key[Array, "*batch"], memory: tuple[Any, ...],
        seen: tuple[Float[Array, "ped *batch"], tuple[Any, ...]],
    ) -> tuple[Int[Array, "ped *batch"], tuple[Any, ...]]:  # fmt: skip
        """Return who goes, and the next memories. Every kind decides for everybody, and one decision counts."""
        draw, views = seen
        kind = kinds_of(draw, self.shares)
        action, after = jnp.zeros(draw.shape, jnp.int32), []
        for number, policy in enumerate(self.kinds):
            own, memories = policy.act(role_key(key, number), memory[number], views[number])
            action = jnp.where(kind == number, own, action)
            after.append(memories)
        return action, tuple(after)


def kinds_of(draw: Float[Array, "..."], shares: tuple[float, ...]) -> Int[Array, "..."]:
    """Return the number of the kind that each person is of. ``draw``: uniform in [0, 1]."""
    bounds = np.cumsum(shares)[:-1].astype(np.float32)
    return sum((draw >= bound for bound in bounds), jnp.zeros(draw.shape, jnp.int32))
