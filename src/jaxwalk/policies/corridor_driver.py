"""What the reference drivers share: the car's limits, its way, and who is in it or comes into it."""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from jaxwalk.interfaces import View
from jaxwalk.policies.pursuit import pursue
from jaxwalk.policies.world_numbers import from_world
from jaxwalk.safety.fuzzy import comes_into_the_way
from jaxwalk.safety.stopping import time_to_collision
from jaxwalk.sim.corridor import NEARING, PER_PERSON, WATCHED
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.observation import CORRIDOR, Observation, part
from jaxwalk.sim.prediction import DISTANCE

WANDERING = 0.375
"""The car's way is wider than the car by this on each side [m]: the wandering of vehicles in UN R157."""
CRAWL = 2.0
"""A slower car is taken to drive this fast, when it is asked who comes into its way before it is past [m/s]."""
STANDING = 0.05
"""A car slower than this stands [m/s]."""


class Ahead(NamedTuple):
    """What a driver sees ahead. Arrays of people are ``(person, *batch)``, the nearest first; others ``(*batch)``."""

    speed: Float[Array, "*batch"]
    """The car's speed [m/s]."""
    top: Float[Array, "*batch"]
    """The car's top speed here [m/s]."""
    gap: Float[Array, "person *batch"]
    """Way along the route from the car's front to the person's body [m]."""
    aside: Float[Array, "person *batch"]
    """Distance of the person's body to the car's way [m]; negative in it."""
    along_speed: Float[Array, "person *batch"]
    """The person's speed along the route [m/s]."""
    approach: Float[Array, "person *batch"]
    """How fast the person comes nearer to the route's middle [m/s]."""
    to_crosswalk: Float[Array, "person *batch"]
    """Way of the person to a crosswalk over the route [m]: 0 at it, `jaxwalk.sim.corridor.NEARING` without one."""
    on_course: Bool[Array, "person *batch"]
    """Whether the person is in the car's way ahead of it, or comes into it before the car is past."""

    def time_to_collision(self) -> Float[Array, "*batch"]:
        """Return the shortest time until the car reaches somebody on course, if all keep their speeds [s]; inf."""
        times = time_to_collision(self.gap, self.speed - self.along_speed)
        return jnp.where(self.on_course, times, jnp.inf).min(axis=0)


class CorridorDriver(eqx.Module):
    """A driver that follows its route by pure pursuit and sees people in the route's frame; its speed is another's."""

    max_acceleration: float = from_world("max_acceleration")
    """The car's largest acceleration [m/s2]."""
    max_braking: float = from_world("max_braking")
    """Its largest braking [m/s2]."""
    max_steering: float = from_world("max_steering")
    """Its largest steering angle [rad]."""
    wheelbase: float = from_world("wheelbase")
    """Distance between its axles [m]."""
    car_length: float = from_world("car_length")
    """Its length [m]."""
    car_width: float = from_world("car_width")
    """Its width [m]."""
    body_radius: float = from_world("body_radius")
    """Radius of a pedestrian's body [m]."""
    dt: float = from_world("dt")
    """Time between two decisions [s]."""
    view: View = eqx.field(static=True, default=Observation("driver", CORRIDOR))
    """What it sees."""

    def look(self, observation: Float[Array, "feature *batch"]) -> Ahead:
        """Return what is ahead, in metres and seconds."""
        speed, top = (observation[part("driver", CORRIDOR, name)][0] * SPEED for name in ("speed", "top_speed"))
        rows = observation[part("driver", CORRIDOR, "watched")].reshape(WATCHED, PER_PERSON, *speed.shape)
        along, left, along_speed, left_speed, to_crosswalk = (
            rows[:, column] * scale for column, scale in enumerate((DISTANCE, DISTANCE, SPEED, SPEED, NEARING))
        )
        gap = along - self.car_length / 2 - self.body_radius
        aside = jnp.abs(left) - self.car_width / 2 - self.body_radius - WANDERING
        approach = -jnp.sign(left) * left_speed
        passing = jnp.maximum(gap, 0) + self.car_length + 2 * self.body_radius
        closing = jnp.maximum(speed - along_speed, CRAWL)
        in_front = along > self.car_length / 2
        on_course = in_front & comes_into_the_way(aside, approach, passing, closing)
        return Ahead(speed, top, gap, aside, along_speed, approach, to_crosswalk, on_course)

    def act_with(
        self, acceleration: Float[Array, "*batch"], observation: Float[Array, "feature *batch"]
    ) -> Float[Array, "2 *batch"]:
        """Return the action: an acceleration [m/s2] within the car's limits, and the steering along the route."""
        limit = jnp.where(acceleration < 0, self.max_braking, self.max_acceleration)
        steering = pursue(
            observation[part("driver", CORRIDOR, "route")], wheelbase=self.wheelbase, max_steering=self.max_steering
        )
        return jnp.stack([jnp.clip(acceleration / limit, -1, 1), steering])


def hold_emergency(
    before: Float[Array, "*batch"], ahead: Ahead, begins: Bool[Array, "*batch"]
) -> Float[Array, "*batch"]:
    """Return 1 where an automatic emergency braking begins or goes on: until the car stands, or nobody is on course."""
    goes_on = (before > 0) & (ahead.speed > STANDING) & ahead.on_course.any(axis=0)
    return (begins | goes_on).astype(jnp.float32)
