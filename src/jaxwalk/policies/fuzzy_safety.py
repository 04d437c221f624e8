"""The driver of the fuzzy safety model: it brakes early and gently, or late and hard."""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float, Key

from jaxwalk.policies.corridor_driver import CorridorDriver
from jaxwalk.safety.fuzzy import FuzzyLimits, critical_fuzzy_safety, fuzzy_braking, proactive_fuzzy_safety

ROUNDING = 1e-3
"""Sums of steps reach a time if they are no more than this below it [s]."""
UNKNOWN = -1.0
"""The speed one step ago, before the first one [m/s]."""


class FuzzyMemory(NamedTuple):
    """The driver's memory; arrays ``(*batch)``."""

    wanted: Float[Array, "*batch"]
    """Time for which it has wanted to brake [s]."""
    speed: Float[Array, "*batch"]
    """The car's speed one step ago [m/s]; `UNKNOWN` at first."""
    deceleration: Float[Array, "*batch"]
    """How hard it brakes [m/s2]."""


class FuzzySafety(CorridorDriver):
    """Brakes as hard as the fuzzy safety model says, after its reaction time, for the worst of the people on course.

    PFS and CFS, their parameters, the lateral check, the reaction time of 0.75 s without braking and the jerk of
    12.65 m/s3 with which braking builds up are those of Mattas et al. (2020) and their program
    (github.com/ec-jrc/JRC-FSM), where others are cars that cut in: here they are people. Ours: full throttle whenever
    nothing is unsafe, a reaction time that begins anew when nothing was, and the cap of 7.59 m/s2 of `careful-human`.
    The model takes for granted a car that can brake with 6 m/s2.
    """

    limits: FuzzyLimits = eqx.field(static=True, default=FuzzyLimits())
    """The model's parameters."""
    jerk: float = eqx.field(static=True, default=12.65)
    """How fast braking builds up [m/s3]."""
    hardest: float = eqx.field(static=True, default=7.59)
    """It never brakes harder than this [m/s2]; the car's limit may be lower."""

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> FuzzyMemory:
        """Return the memory of a driver who brakes for nobody."""
        nothing = jnp.zeros((*agents, *batch))
        return FuzzyMemory(nothing, nothing + UNKNOWN, nothing)

    def act(
        self, key: Key[Array, "*batch"], memory: FuzzyMemory, observation: Float[Array, "feature *batch"]
    ) -> tuple[Float[Array, "2 *batch"], FuzzyMemory]:
        """Return full throttle, none while it reacts, or the model's braking; and the steering along the route."""
        ahead = self.look(observation)
        proactive = proactive_fuzzy_safety(ahead.gap, ahead.speed, ahead.along_speed, self.limits)
        gained = jnp.where(memory.speed < 0, 0.0, (ahead.speed - memory.speed) / self.dt)
        critical = critical_fuzzy_safety(ahead.gap, ahead.speed, ahead.along_speed, gained, self.limits)
        wanted = jnp.where(ahead.on_course, fuzzy_braking(proactive, critical, self.limits), 0.0).max(axis=0)
        reacts = memory.wanted > self.limits.reaction - ROUNDING
        built_up = jnp.minimum(memory.deceleration + self.jerk * self.dt, min(self.hardest, self.max_braking))
        deceleration = jnp.where(reacts, jnp.minimum(built_up, wanted), 0.0)
        acceleration = jnp.where(wanted > 0, -deceleration, self.max_acceleration)
        lasted = jnp.where(wanted > 0, memory.wanted + self.dt, 0.0)
        return self.act_with(acceleration, observation), FuzzyMemory(lasted, ahead.speed, deceleration)
