"""A careful and competent human driver, in the style of UN R157, with and without automatic emergency braking."""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Key

from jaxwalk.policies.corridor_driver import STANDING, Ahead, CorridorDriver, hold_emergency
from jaxwalk.safety.stopping import ramp

IDLE = -1.0
"""The time since a reaction began while there is none [s]."""
ROUNDING = 1e-3
"""Sums of steps reach a time if they are no more than this below it [s]."""


class Attention(NamedTuple):
    """The driver's memory; arrays ``(*batch)``."""

    noticed: Float[Array, "*batch"]
    """Time for which somebody has been on course [s]."""
    since: Float[Array, "*batch"]
    """Time since the reaction began [s]; `IDLE` without one."""
    emergency: Float[Array, "*batch"]
    """1 while the automatic emergency braking brakes."""


class CarefulHuman(CorridorDriver):
    """Needs time to see a risk and to react, then brakes hard until it stands; drives on when the way is clear.

    Somebody on course is a risk once they have been so for 0.4 s. Below a time to collision of 2.0 s the driver reacts:
    0.75 s without throttle or brake, then a braking that rises within 0.6 s to 7.59 m/s2 (0.774 g) or to the car's
    limit, until standstill. These are the numbers of UN R157, annex 4, appendix 3, for a car that cuts in. That people
    are on course by the lateral check of the fuzzy safety model (`jaxwalk.safety.fuzzy.comes_into_the_way`) follows its
    authors. Ours is the rest: full throttle until it reacts, and how it sets out. (esmini's form of the regulation
    coasts at 0.4 m/s2 during the 0.75 s.)
    """

    perceives_after: float = eqx.field(static=True, default=0.4)
    """Time to perceive a risk [s]."""
    reaction: float = eqx.field(static=True, default=0.75)
    """Time from the decision to brake until braking begins [s]."""
    rise: float = eqx.field(static=True, default=0.6)
    """Time until the braking is full [s]."""
    hardest: float = eqx.field(static=True, default=7.59)
    """The full braking [m/s2]; the car's limit may be lower."""
    critical: float = eqx.field(static=True, default=2.0)
    """It reacts below this time to collision [s]."""
    clear: float = eqx.field(static=True, default=10.0)
    """It sets out when nobody is on course this far ahead [m]: ours."""
    emergency_below: float = eqx.field(static=True, default=0.0)
    """Below this time to collision, automatic emergency braking brakes as hard as the car can [s]; 0: there is none."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Attention:
        """Return the memory of a driver who has noticed nobody."""
        nothing = jnp.zeros((*agents, *batch))
        return Attention(nothing, nothing + IDLE, nothing)

    def act(
        self, key: Key[Array, "*batch"], memory: Attention, observation: Float[Array, "feature *batch"]
    ) -> tuple[Float[Array, "2 *batch"], Attention]:
        """Return full throttle, none, or the braking of this moment, and the steering along the route."""
        ahead = self.look(observation)
        time, stands = ahead.time_to_collision(), ahead.speed < STANDING
        risk = ahead.on_course.any(axis=0)
        noticed = jnp.where(risk, memory.noticed, 0)
        reacts = (noticed > self.perceives_after - ROUNDING) & (time < self.critical)
        since = jnp.where((memory.since < 0) & reacts, 0, memory.since)
        blocked = self._blocked(ahead)
        since = jnp.where(stands & ~blocked, IDLE, since)
        emergency = hold_emergency(memory.emergency, ahead, (time < self.emergency_below) & ~stands)
        acceleration = jnp.where(
            since >= 0, -self._braking(since), jnp.where(stands & blocked, 0.0, self.max_acceleration)
        )
        acceleration = jnp.where(emergency > 0, -self.max_braking, acceleration)
        later = jnp.where(since >= 0, since + self.dt, IDLE)
        return self.act_with(acceleration, observation), Attention(noticed + self.dt * risk, later, emergency)

    def _braking(self, since: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
        """Return the braking in the middle of a step that begins this long after the reaction [m/s2]."""
        return ramp(since + self.dt / 2 - self.reaction, min(self.hardest, self.max_braking), self.rise)

    def _blocked(self, ahead: Ahead) -> Array:
        """Return whether somebody near is on course, so that a car that stands doesn't set out."""
        return (ahead.on_course & (ahead.gap < self.clear)).any(axis=0)


def careful_human_with_aeb() -> CarefulHuman:
    """Return the careful human in a car that brakes by itself below a time to collision of 1.5 s."""
    return CarefulHuman(emergency_below=1.5)
