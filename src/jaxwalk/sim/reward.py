"""Rewards: a table of named terms for each role. A recipe gives weights to some of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.sim import pedestrian, prediction, vehicle
from jaxwalk.sim.events import Events, distance
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import State
from jaxwalk.sim.world import World

NEAR_WAIT = 8.0
"""Waiting is rewarded only while the car is within this distance [m], with the pedestrian ahead of it."""
FAST_CAR = 2.0
"""Waiting is rewarded only while the car is faster than this [m/s]."""
CAUTIOUS_SPEED = 3.0
"""Speed above which the car pays while people are on the roadway close ahead (`jaxwalk.sim.prediction`) [m/s]."""
COMFORTABLE = {"disc": 3.0, "footprint": 1.5}
"""The car pays for predicted clearances below this, by the world's contact [m]."""

LARGEST_WEIGHT = 1e6
"""Largest weight of a reward term."""


class Transition(NamedTuple):
    """One step: the arguments of all reward terms."""

    world: World
    scenario: Scenario
    before: State
    after: State
    events: Events


def reward(
    table: Mapping[str, Callable[[Transition], Array]], weights: Mapping[str, Float[Array, ""]], transition: Transition
) -> dict[str, Array]:
    """Return the weighted terms of a role; an agent's reward is their sum."""
    return {name: weight * table[name](transition) for name, weight in weights.items()}


def _crow_progress(t: Transition) -> Array:
    """Return the metres gained towards the goal, as the crow flies."""
    goal_x, goal_y = vehicle.goal(t.world, t.scenario)
    before, after = t.before.vehicle, t.after.vehicle
    return distance(goal_x - before.x, goal_y - before.y) - distance(goal_x - after.x, goal_y - after.y)


def _speeding(t: Transition, somebody: Array) -> Array:
    """Return the share of top speed above 3 m/s, with somebody on the roadway close ahead of the car."""
    return jnp.where(somebody, jnp.maximum(t.after.vehicle.speed - CAUTIOUS_SPEED, 0) / t.world.rules.max_speed, 0)


def _off_lane(t: Transition) -> Array:
    """Return the offset from the lane centre, squared, at most 4 [m2]."""
    lateral, _, _ = vehicle.route_frame(t.after.vehicle)
    return jnp.minimum(lateral**2, 4)


def _misaligned(t: Transition) -> Array:
    """Return one minus the cosine of the heading error."""
    _, cos, _ = vehicle.route_frame(t.after.vehicle)
    return 1 - cos


def _closeness(t: Transition) -> Array:
    """Return how far the clearance predicted at held speed falls short, in [0, 1], times the share of top speed."""
    comfortable = COMFORTABLE[t.world.rules.contact]
    clearance = prediction.clearance_at_held_speed(t.world, t.scenario, t.after)
    shortfall = jnp.maximum(1 - clearance / comfortable, 0)
    return shortfall * t.after.vehicle.speed / t.world.rules.max_speed


def _waiting_anywhere(t: Transition) -> Array:
    """Return which pedestrians wait while the car, within 8 m and faster than 2 m/s, has them ahead."""
    car, seen = t.before.vehicle, prediction.motion_of_people(t.world, t.scenario, t.before)
    near = (seen.ahead**2 + seen.left**2 < NEAR_WAIT**2) & (seen.ahead > 0) & (car.speed > FAST_CAR)
    return near & ~t.after.pedestrian.going


def _walked(t: Transition) -> Array:
    """Return the metres walked along the committed path."""
    pace = pedestrian.pace(t.world, t.scenario, t.before.pedestrian)
    return jnp.where(t.after.pedestrian.going, pace * t.world.rules.dt, 0)


DRIVER_TERMS: dict[str, Callable[[Transition], Array]] = {
    "goal": lambda t: t.events.goal,
    "collision": lambda t: t.events.collision,
    "crow_progress": _crow_progress,
    "progress": lambda t: t.after.vehicle.along - t.before.vehicle.along,
    "crosswalk_speeding": lambda t: _speeding(t, prediction.people_ahead(t.world, t.scenario, t.after)[0]),
    "jaywalker_speeding": lambda t: _speeding(t, prediction.people_ahead(t.world, t.scenario, t.after)[1]),
    "off_lane": _off_lane,
    "misaligned": _misaligned,
    "closeness": _closeness,
    "time": lambda t: jnp.ones(t.events.goal.shape),
}
"""The terms of the driver's reward, for each step; ``progress`` is metres along the route."""

PEDESTRIAN_TERMS: dict[str, Callable[[Transition], Array]] = {
    "collision": lambda t: t.events.touched,
    "walked": _walked,
    "arrival": lambda t: t.after.pedestrian.arrivals > t.before.pedestrian.arrivals,
    "waiting": lambda t: _waiting_anywhere(t) & pedestrian.at_kerb(t.world, t.before.pedestrian),
    "waiting_anywhere": _waiting_anywhere,
    "waited": lambda t: ~t.after.pedestrian.going,
}
"""The terms of a pedestrian's reward, for each step; ``waited`` is 1 for a step not walked, ``waiting`` one at the kerb
before a near, fast car."""


def check_weights(driver: Mapping[str, float], people: Mapping[str, float]) -> None:
    """Raise ValueError for a weight without a term, or one that isn't a number up to `LARGEST_WEIGHT`."""
    for role, weights, table in (("driver", driver, DRIVER_TERMS), ("pedestrian", people, PEDESTRIAN_TERMS)):
        for name, weight in weights.items():
            if name not in table:
                raise ValueError(f"rewards.{role}.{name} is no reward term; there are: {', '.join(table)}")
            if not abs(weight) <= LARGEST_WEIGHT:
                raise ValueError(f"rewards.{role}.{name} must be a number up to {LARGEST_WEIGHT:g}, not {weight}")
