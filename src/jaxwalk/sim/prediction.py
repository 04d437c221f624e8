"""Predict how close the car would come to people if it braked, held its speed or accelerated."""

from __future__ import annotations

from itertools import pairwise
from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.sim import pedestrian
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.events import distance
from jaxwalk.sim.everybody import for_everybody, with_index
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import Foresight, Motion, PedestrianState, State, VehicleState
from jaxwalk.sim.world import World

T = TypeVar("T")

BRAKE, HOLD, ACCELERATE = 0, 1, 2
"""The three manoeuvres that are predicted."""
NEIGHBOURS = 6
"""The car sees this many people, the nearest ones."""
ABSENT = 60.0
"""A neighbour that isn't there stands this far ahead [m]."""
MOMENTS, MOMENT = 8, 0.375
"""The prediction covers 8 moments, 0.375 s apart: 3 s ahead."""
CONFLICT = 2.5
"""A conflict is a predicted distance of the centres below this [m]."""
FAR = 10.0
"""Clearances are capped here [m]."""
CAUTION_AHEAD, CAUTION_ASIDE = 15.0, 6.0
"""The car should be cautious with people on the roadway up to this far ahead of it, and to either side [m]."""


def relative_people(world: World, scenario: Scenario, car: VehicleState, people: PedestrianState) -> Motion:
    """Return people in the car's frame; arrays ``(ped, *batch)``."""
    ahead, left = to_frame(people.x - car.x[None], people.y - car.y[None], car.cos[None], car.sin[None])
    vx, vy = pedestrian.velocity(world, scenario, people)
    return Motion(ahead, left, *to_frame(vx, vy, car.cos[None], car.sin[None]))


def foresee(world: World, scenario: Scenario, car: VehicleState, people: PedestrianState) -> Foresight:
    """Return people as the car sees them, the route ahead, and what is predicted from now on.

    The predictions are the smallest distance to anybody for each manoeuvre, at most 10 m, and the time until a
    conflict, at most 3 s. The car follows its route, straight from each shown point to the next, and people keep their
    velocity. One pedestrian after the other is compared with all moments, so that no large array is stored.
    """
    route_x, route_y = to_frame(car.course.ahead_x - car.x, car.course.ahead_y - car.y, car.cos, car.sin)
    car_x, car_y = _predicted_car(world, car, route_x, route_y)
    time = (jnp.arange(1, MOMENTS + 1) * MOMENT).reshape(-1, 1, *(1,) * car.x.ndim)
    motion = relative_people(world, scenario, car, people)
    on_crosswalk = people.on_roadway & (people.crossing == CROSSWALK)
    jaywalking = people.on_roadway & (people.crossing == JAYWALK)

    def compare(one: tuple[Motion, Array, Array], found: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        closest, crosswalk_user, jaywalker = found
        person, uses_crosswalk, jaywalks = one
        x, y = person.ahead + person.ahead_speed * time, person.left + person.left_speed * time
        away = (x - car_x) ** 2 + (y - car_y) ** 2
        ahead = (person.ahead > 0) & (person.ahead < CAUTION_AHEAD) & (jnp.abs(person.left) < CAUTION_ASIDE)
        return (
            jnp.where(away < closest, away, closest),
            crosswalk_user | (ahead & uses_crosswalk),
            jaywalker | (ahead & jaywalks),
        )

    nobody = jnp.zeros((1, *car.x.shape), bool)
    nothing = (jnp.full(car_x.shape, FAR**2), nobody, nobody)
    closest, crosswalk_user, jaywalker = for_everybody((motion, on_crosswalk, jaywalking), compare, nothing)
    conflict = jnp.where(closest[:, HOLD] < CONFLICT**2, time[:, 0], MOMENTS * MOMENT).min(axis=0)
    return Foresight(
        people=motion,
        nearest=nearest_people(motion),
        route_x=route_x,
        route_y=route_y,
        clearance=jnp.sqrt(closest.min(axis=0)),
        conflict=conflict,
        crosswalk_user=crosswalk_user[0],
        jaywalker=jaywalker[0],
    )


def predicted_miss(world: World, scenario: Scenario, state: State) -> tuple[Array, Array]:
    """Return how close each pedestrian's centre and the car's would come [m], and when [s]; ``(ped, *batch)``.

    The pedestrian walks on along its leg from now, and the car keeps its velocity. If they move apart, it is now.
    """
    car, people, motion = state.vehicle, state.pedestrian, state.foresight.people
    along, across = to_frame(people.leg.cos, people.leg.sin, car.cos[None], car.sin[None])
    pace = scenario.walking_speed(world)
    vx, vy = pace * along - car.speed[None], pace * across
    when = -(motion.ahead * vx + motion.left * vy) / jnp.maximum(vx * vx + vy * vy, 1e-6)
    when = jnp.maximum(when, 0)
    return distance(motion.ahead + vx * when, motion.left + vy * when), when


def nearest_people(motion: Motion) -> Motion:
    """Return the nearest `NEIGHBOURS` people, nearest first; one that isn't there stands far ahead."""
    shape = (NEIGHBOURS, *motion.ahead.shape[1:])
    return of_nearest(motion, motion, Motion(*(jnp.full(shape, default) for default in (ABSENT, 0.0, 0.0, 0.0))))


def of_nearest(motion: Motion, of_all: T, absent: T) -> T:
    """Return values of the nearest `NEIGHBOURS` people, nearest first: arrays ``(neighbour, *batch)``.

    It ranks people by counting who is nearer, because a sort is slow in this layout.

    Args:
        motion: everybody, ``(ped, *batch)``.
        of_all: a pytree with a value of everybody, arrays ``(ped, *batch)``.
        absent: the values of neighbours who aren't there, arrays ``(neighbour, *batch)``.
    """
    squared = motion.ahead**2 + motion.left**2
    people, *batch = squared.shape
    keys = with_index(squared, jnp.arange(people).reshape(-1, *(1,) * len(batch)), people)
    place = jnp.arange(NEIGHBOURS).reshape(-1, *(1,) * len(batch))

    def count(key: Array, rank: Array) -> Array:
        return rank + (key < keys)

    ranks = for_everybody(keys, count, jnp.zeros(squared.shape, jnp.int32))

    def pick(one: tuple[Array, T], found: T) -> T:
        rank, person = one
        return jax.tree.map(lambda new, kept: jnp.where(rank == place, new, kept), person, found)

    return for_everybody((ranks, of_all), pick, absent)


def _predicted_car(world: World, car: VehicleState, route_x: Array, route_y: Array) -> tuple[Array, Array]:
    """Return where each manoeuvre would bring the car, in its present frame [m]; ``(moment, manoeuvre, *batch)``."""
    batch = (1,) * car.speed.ndim
    time = (jnp.arange(1, MOMENTS + 1) * MOMENT).reshape(-1, *batch)
    rules, acceleration = world.rules, world.rules.max_acceleration
    braking = jnp.minimum(time, car.speed / acceleration)
    accelerating = jnp.minimum(time, (rules.max_speed - car.speed) / acceleration)
    travelled = jnp.stack(
        [
            car.speed * braking - 0.5 * acceleration * braking**2,
            car.speed * time,
            car.speed * accelerating + 0.5 * acceleration * accelerating**2 + rules.max_speed * (time - accelerating),
        ],
        axis=1,
    )
    beyond = [jnp.maximum(travelled - POINT_SPACING * point, 0) for point in POINTS[:-1]]
    return _along(route_x, travelled, beyond), _along(route_y, travelled, beyond)


def _along(route: Float[Array, "point *batch"], travelled: Array, beyond: list[Array]) -> Array:
    """Return a coordinate of the place ``travelled`` metres along the straight pieces between the route's points.

    It is a sum: the first piece, continued, and the change of slope at each point, from there on. Beyond the last point
    the last piece continues. ``beyond`` holds how far the place is beyond each point but the last [m].
    """
    points = jnp.unstack(route)
    lengths = [POINT_SPACING * (to - at) for at, to in pairwise((0, *POINTS))]
    slopes = [(to - at) / length for at, to, length in zip((0, *points[:-1]), points, lengths, strict=True)]
    bends = [new - old for old, new in pairwise(slopes)]
    turned = (bend * metres for bend, metres in zip(bends, beyond, strict=True))
    return sum(turned, start=slopes[0] * travelled)
