"""People whose chance to cross is a product of factors: PedSUMO (Colley et al., 2024, doi 10.1145/3610977.3637478).

The numbers are those of the authors' program (MIT licence), who call some of them educated guesses. Of its factors we
have those that our street shows: time to collision, group, phone and waiting. Age, gender, sight, street width, and the
car's size and display are left out.
"""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, Key

from jaxwalk.interfaces import View
from jaxwalk.policies.kerb_gap import KERB_VIEW, STANDS, Column, KerbGap, drawn, kerb_gap
from jaxwalk.policies.world_numbers import from_world
from jaxwalk.sim.everybody import for_everybody

USUAL = 0.4
"""Chance to cross in front of an automated car, before all factors."""
EXTREME, SHORT, LONG = 1.0, 3.0, 6.0
"""Times to collision between which the factor changes [s]."""
AT_EXTREME, AT_SHORT, ABOVE_LONG = 0.01, 0.1, 3.0
"""Factors up to 1 s, up to 3 s, and from 6 s."""
FROM, TO = 0.2, 2.0
"""The factor grows evenly from 3 to 6 s."""
FEW, MANY = 1.2, 1.4
"""Factors of a group of two or three, and of a larger one."""
PHONE = 1.5
"""Factor of people on the phone."""
PHONES = 0.08
"""Share of people on the phone: those who were seen to text (PMC5762430). PedSUMO's goes by age."""
PATIENCE, IMPATIENCE = 28.0, 0.0494
"""After waiting this long [s], the factor grows by this much a second [1/s]."""
AGAIN = 1.0
"""People draw anew whether they cross after this time [s]: a step of PedSUMO."""
NEAR = 3.0
"""Who waits this close is of the group [m]: an assumption of ours. In PedSUMO it is who waits for the same crossing."""


class Undecided(NamedTuple):
    """What people remember; arrays ``(ped, *batch)``."""

    waited: Column
    """Time at the kerb [s]; 0 elsewhere."""
    go: Bool[Array, "ped *batch"]
    """Decided to cross."""
    phone: Bool[Array, "ped *batch"]
    """On the phone, since before it arrived at the kerb."""


class PedSumo(eqx.Module):
    """Draws on arrival at a kerb, and again each second, whether it crosses; the chance is a product of factors.

    Who has decided to cross goes. A car that stands or has passed is in nobody's way: people go.
    """

    dt: float = from_world("dt")
    """Duration of a step [s]."""
    view: View = eqx.field(static=True, default=KERB_VIEW)
    """What it sees."""

    @property
    def sample(self) -> bool:
        """Always True: it draws."""
        return True

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Undecided:
        """Return a memory of nothing; phones are drawn at the first step, since nobody begins at a kerb."""
        no = jnp.zeros((*agents, *batch), bool)
        return Undecided(jnp.zeros((*agents, *batch)), no, no)

    def act(
        self, key: Key[Array, "*batch"], memory: Undecided, observation: Float[Array, "feature ped *batch"]
    ) -> tuple[Int[Array, "ped *batch"], Undecided]:
        """Return who goes, and what people remember."""
        gap = kerb_gap(observation)
        draw, calls = drawn(key, lambda one: jax.random.uniform(one, (2, len(memory.waited))))
        phone = jnp.where(gap.deciding, memory.phone, calls < PHONES)
        free = (gap.speed < STANDS) | (gap.ahead < 0)
        turns = jnp.floor((memory.waited + self.dt / 2) / AGAIN) > jnp.floor((memory.waited - self.dt / 2) / AGAIN)
        crosses = turns & (draw < chance(gap, group_sizes(gap), phone, memory.waited))
        go = gap.deciding & (memory.go | free | crosses)
        waited = jnp.where(gap.deciding, memory.waited + self.dt, 0)
        return (go | ~gap.deciding).astype(jnp.int32), Undecided(waited, go, phone)


def chance(gap: KerbGap, group: Column, phone: Bool[Array, "ped *batch"], waited: Column) -> Column:
    """Return the chance of crossing; above 1 for those who surely do."""
    time = gap.ahead / jnp.maximum(gap.speed, STANDS)
    grows = FROM + (TO - FROM) * (time - SHORT) / (LONG - SHORT)
    by_time = jnp.select([time <= EXTREME, time <= SHORT, time < LONG], [AT_EXTREME, AT_SHORT, grows], ABOVE_LONG)
    by_group = jnp.select([group < 2, group <= 3], [1.0, FEW], MANY)
    by_waiting = 1 + IMPATIENCE * jnp.maximum(waited - PATIENCE, 0)
    return USUAL * by_time * by_group * jnp.where(phone, PHONE, 1.0) * by_waiting


def group_sizes(gap: KerbGap) -> Column:
    """Return how many people, including oneself, decide within `NEAR` of each pedestrian."""

    def count(other: KerbGap, found: Column) -> Column:
        away = (other.ahead - gap.ahead) ** 2 + (other.left - gap.left) ** 2
        return found + (other.deciding & (away < NEAR**2))

    return for_everybody(gap, count, jnp.zeros_like(gap.ahead))
