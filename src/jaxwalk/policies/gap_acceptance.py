"""People who wait at the kerb for a gap that they accept."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, Key

from jaxwalk.interfaces import View
from jaxwalk.policies.kerb_gap import KERB_VIEW, STANDS, Column, drawn, kerb_gap

INTERCEPT, PER_SECOND = 6.2064, 0.9420
"""P(accept) = 1 / (1 + exp(6.2064 - 0.9420 gap)), gap in s (Brewer et al., 2006): one half at 6.6 s."""


class GapAccepting(eqx.Module):
    """Goes if the car is far enough away in time, and waits at the kerb otherwise.

    A gap is the time until the car, at its present speed, is where the pedestrian is. Each approach to a kerb has a
    critical gap of its own, drawn so that a gap is accepted as often as Brewer et al. observed. People also go once the
    car has passed, stands, or is more than 40 m away (67 m in the world ``town``), and always on the roadway.
    """

    intercept: float = eqx.field(static=True, default=INTERCEPT)
    """P(accept) = 1 / (1 + exp(intercept - per_second x gap))."""
    per_second: float = eqx.field(static=True, default=PER_SECOND)
    """How fast gaps become more acceptable [1/s]."""
    view: View = eqx.field(static=True, default=KERB_VIEW)
    """What it sees."""

    @property
    def sample(self) -> bool:
        """Always True: it draws critical gaps."""
        return True

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Column:
        """Return critical gaps [s] that are drawn anew at the first step, since nobody begins at a kerb."""
        return jnp.full((*agents, *batch), self.intercept / self.per_second)

    def act(
        self, key: Key[Array, "*batch"], memory: Column, observation: Float[Array, "feature ped *batch"]
    ) -> tuple[Int[Array, "ped *batch"], Column]:
        """Return who goes, and the critical gaps [s]: kept while somebody decides, else drawn anew."""
        gap = kerb_gap(observation)
        fresh = critical_gaps(key, len(memory), self.intercept, self.per_second)
        critical = jnp.where(gap.deciding, memory, fresh)
        go = ~gap.deciding | (gap.speed < STANDS) | (gap.ahead < 0) | (gap.ahead >= critical * gap.speed)
        return go.astype(jnp.int32), critical


def critical_gaps(key: Key[Array, "*batch"], people: int, intercept: float, per_second: float) -> Column:
    """Return a critical gap for everybody [s], each episode's from its own key."""
    return drawn(key, lambda one: (intercept + jax.random.logistic(one, (people,))) / per_second)
