"""People with a phone or headphones: they look up late, and judge until then by what they saw on arrival.

Of observed crossers 19 % wore headphones, 8 % texted and 5 % talked on a phone (PMC5762430). In a
meta-analysis (Simmons et al., 2020) distracted people looked less, started later and had more close calls, but took no
longer to cross. So they walk as fast as others here.
"""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, Key

from jaxwalk.interfaces import View
from jaxwalk.policies.diffusion import THRESHOLD, Apparent, Diffusion, Gathered, acceleration, gather
from jaxwalk.policies.kerb_gap import KERB_VIEW, Column, drawn, kerb_gap
from jaxwalk.policies.world_numbers import from_world

SHORTEST, LONGEST = 1.0, 2.0
"""For how long people don't look after they have arrived at a kerb [s]: uniform between these; our assumption."""


class Unaware(NamedTuple):
    """What distracted people remember; arrays ``(ped, *batch)``."""

    gathered: Gathered
    """As other people's."""
    left: Column
    """For how long they don't look yet [s]."""
    ahead: Column
    """The car's distance when they last looked [m]."""
    speed: Column
    """Its speed then [m/s]."""


class Distracted(eqx.Module):
    """Decides like `Diffusion`, but looks up only 1 to 2 s after it has arrived at a kerb, and doesn't start before.

    Until then, evidence comes from the gap on arrival. So people start later, into a gap that has become shorter.
    """

    dt: float = from_world("dt")
    """Duration of a step [s]."""
    view: View = eqx.field(static=True, default=KERB_VIEW)
    """What it sees."""

    @property
    def sample(self) -> bool:
        """Always True: evidence is noisy."""
        return True

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Unaware:
        """Return a memory without evidence; the rest is set at the first step, since nobody begins at a kerb."""
        nothing = jnp.zeros((*agents, *batch))
        return Unaware(Diffusion().init(agents, batch), nothing, nothing, nothing)

    def act(
        self, key: Key[Array, "*batch"], memory: Unaware, observation: Float[Array, "feature ped *batch"]
    ) -> tuple[Int[Array, "ped *batch"], Unaware]:
        """Return who goes, and what people remember."""
        gap, before = kerb_gap(observation), memory.gathered
        own_key = drawn(key, lambda one: jax.random.fold_in(one, 1))
        absent = drawn(own_key, lambda one: jax.random.uniform(one, (len(gap.ahead),), minval=SHORTEST, maxval=LONGEST))
        left = jnp.where(gap.deciding, memory.left - self.dt, absent)
        unaware = gap.deciding & (left > 0)
        ahead = jnp.where(unaware, memory.ahead, gap.ahead)
        speed = jnp.where(unaware, memory.speed, gap.speed)
        slowing = jnp.where(unaware, 0, acceleration(before, gap.speed, self.dt))
        gathered = gather(key, before.evidence, Apparent(ahead, speed, slowing), self.dt)
        evidence = jnp.where(gap.deciding, gathered, 0)
        go = ~gap.deciding | (~unaware & (evidence >= THRESHOLD))
        return go.astype(jnp.int32), Unaware(Gathered(evidence, gap.speed), left, ahead, speed)
