"""Plans of speed along a route: one acceleration for a while, then another one."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

PEDALS = (1.0, 0.0, -0.4, -1.0)
"""What a plan begins with, as shares of the car's acceleration or braking."""
THEN = (1.0, 0.0, -1.0)
"""What it goes on with."""
LASTS = (0.4, 1.0, 2.0)
"""How long the beginning lasts [s]."""
PLANS = np.array(
    [(pedal, lasts, then) for pedal, lasts, then in product(PEDALS, LASTS, THEN) if pedal != then or lasts == LASTS[0]]
)
"""Pedal at first, how long it lasts, and the pedal from then on: a row for each plan, the fastest beginnings first."""
AT_ONCE = 1e-6
"""Accelerations smaller than this change no speed [m/s2]."""


def driven(
    speed: Float[Array, "..."], acceleration: Float[Array, "..."], time: Float[Array, "..."], top: Float[Array, "..."]
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """Return the way of a car after some time [m], and its speed then [m/s]: it stands at 0, and holds its top speed.

    Args:
        speed: the speed at first [m/s].
        acceleration: the constant acceleration [m/s2].
        time: 0 or more [s].
        top: the top speed [m/s].
    """
    bound = jnp.where(acceleration > 0, top, 0)
    holds = jnp.abs(acceleration) < AT_ONCE
    until = jnp.maximum((bound - speed) / jnp.where(holds, 1, acceleration), 0)
    changing = jnp.where(holds, 0, jnp.minimum(time, until))
    after = speed + acceleration * changing
    return (speed + after) / 2 * changing + after * (time - changing), after


class SpeedPlans(NamedTuple):
    """What all plans would do from a moment on; arrays ``(plan, *batch)``."""

    speed: Float[Array, "*batch"]
    """The speed now [m/s]."""
    top: Float[Array, "*batch"]
    """The top speed [m/s]."""
    first: Float[Array, "plan *one"]
    """The acceleration at first [m/s2]."""
    lasts: Float[Array, "plan *one"]
    """How long it lasts [s]."""
    then: Float[Array, "plan *one"]
    """The acceleration from then on [m/s2]."""
    middle_way: Float[Array, "plan *batch"]
    """The way until then [m]."""
    middle_speed: Float[Array, "plan *batch"]
    """The speed then [m/s]."""

    def at(self, time: Float[Array, "..."]) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
        """Return every plan's way after some time [m], and its speed then [m/s]."""
        way, speed = driven(self.speed, self.first, jnp.minimum(time, self.lasts), self.top)
        more, later = driven(self.middle_speed, self.then, jnp.maximum(time - self.lasts, 0), self.top)
        changed = time > self.lasts
        return jnp.where(changed, self.middle_way + more, way), jnp.where(changed, later, speed)


def speed_plans(
    speed: Float[Array, "*batch"], top: Float[Array, "*batch"], max_acceleration: float, max_braking: float
) -> SpeedPlans:
    """Return the plans `PLANS` of a car with a speed, a top speed [m/s] and the largest changes of speed [m/s2]."""
    pedal, lasts, then = (jnp.asarray(column, jnp.float32).reshape(-1, *(1,) * speed.ndim) for column in PLANS.T)
    first, later = (x * jnp.where(x < 0, max_braking, max_acceleration) for x in (pedal, then))
    return SpeedPlans(speed, top, first, lasts, later, *driven(speed, first, lasts, top))
