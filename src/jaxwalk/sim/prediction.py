"""Predict how close the car would come to people if it braked, held its speed or accelerated."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.interfaces import Moment
from jaxwalk.sim import pedestrian
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.events import distance
from jaxwalk.sim.everybody import for_everybody, with_index
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.sim_config import ContactRule
from jaxwalk.sim.state import Foresight, Motion, PedestrianState, State, VehicleState
from jaxwalk.sim.world import World

T = TypeVar("T")

MANOEUVRES = BRAKE, HOLD, ACCELERATE = 0, 1, 2
"""The three manoeuvres that are predicted."""
NEIGHBOURS = 6
"""The car sees this many people, the nearest ones."""
ABSENT = 60.0
"""A neighbour that isn't there stands this far ahead [m]."""
MOMENTS, MOMENT = 8, 0.375
"""The prediction covers 8 moments, 0.375 s apart: 3 s ahead."""
CONFLICT: dict[ContactRule, float] = {"disc": 2.5, "footprint": 1.0}
"""A conflict is a predicted clearance below this [m]: a contact, or almost one."""
SHORTEST = 1e-3
"""The direction of a piece of the route is unknown where it is shorter than this share of its length."""
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

    The predictions are the smallest clearance for each manoeuvre, at most 10 m, and the time until a conflict, at most
    3 s; clearances are those of the world's contact. The car follows its route, straight from each shown point to the
    next, and people keep their velocity. One pedestrian after the other is compared with all moments, so that no large
    array is stored.
    """
    route = to_frame(car.course.ahead_x - car.x, car.course.ahead_y - car.y, car.cos, car.sin)
    contact = world.rules.contact
    squared = _squared_clearance(world, car, route, contact)
    motion = relative_people(world, scenario, car, people)
    on_crosswalk = people.on_roadway & (people.crossing == CROSSWALK)
    jaywalking = people.on_roadway & (people.crossing == JAYWALK)

    def compare(one: tuple[Motion, Array, Array], found: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        closest, crosswalk_user, jaywalker = found
        person, uses_crosswalk, jaywalks = one
        away = squared(person)
        ahead = (person.ahead > 0) & (person.ahead < CAUTION_AHEAD) & (jnp.abs(person.left) < CAUTION_ASIDE)
        return (
            jnp.where(away < closest, away, closest),
            crosswalk_user | (ahead & uses_crosswalk),
            jaywalker | (ahead & jaywalks),
        )

    nobody = jnp.zeros((1, *car.x.shape), bool)
    nothing = (_far(car), nobody, nobody)
    closest, crosswalk_user, jaywalker = for_everybody((motion, on_crosswalk, jaywalking), compare, nothing)
    clearance, conflict = _clearance(world, closest, contact)
    return Foresight(
        people=motion,
        nearest=nearest_people(motion),
        route_x=route[0],
        route_y=route[1],
        clearance=clearance,
        conflict=conflict,
        crosswalk_user=crosswalk_user[0],
        jaywalker=jaywalker[0],
    )


def clearance_by(moment: Moment, contact: ContactRule) -> tuple[Array, Array]:
    """Return ``clearance`` and ``conflict`` of a `Foresight` by this kind of contact, whatever the world's is."""
    world, car, seen = moment.world, moment.state.vehicle, moment.state.foresight
    if contact == world.rules.contact:
        return seen.clearance, seen.conflict
    squared = _squared_clearance(world, car, (seen.route_x, seen.route_y), contact)
    closest = for_everybody(seen.people, lambda person, found: jnp.minimum(squared(person), found), _far(car))
    return _clearance(world, closest, contact)


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


def _far(car: VehicleState) -> Array:
    """Return the largest squared clearance, ``(moment, manoeuvre, *batch)``."""
    return jnp.full((MOMENTS, len(MANOEUVRES), *car.speed.shape), FAR**2)


def _squared_clearance(
    world: World, car: VehicleState, route: tuple[Array, Array], contact: ContactRule
) -> Callable[[Motion], Array]:
    """Return a function that gives somebody's predicted distances, squared; ``(moment, manoeuvre, *batch)``.

    They are distances from the person's centre to the car's centre, or to its rectangle.
    """
    time = (jnp.arange(1, MOMENTS + 1) * MOMENT).reshape(-1, 1, *(1,) * car.x.ndim)
    (car_x, cos), (car_y, sin) = _predicted_car(world, car, route)
    half_length, half_width = world.rules.car_length / 2, world.rules.car_width / 2
    norm = jax.lax.rsqrt(jnp.maximum(cos**2 + sin**2, SHORTEST**2))

    def squared(person: Motion) -> Array:
        x, y = person.ahead + person.ahead_speed * time, person.left + person.left_speed * time
        dx, dy = x - car_x, y - car_y
        if contact == "disc":
            return dx**2 + dy**2
        ahead, left = to_frame(dx, dy, cos * norm, sin * norm)
        return jnp.maximum(jnp.abs(ahead) - half_length, 0) ** 2 + jnp.maximum(jnp.abs(left) - half_width, 0) ** 2

    return squared


def _clearance(world: World, closest: Array, contact: ContactRule) -> tuple[Array, Array]:
    """Return the clearance of each manoeuvre [m] and the time until a conflict [s] from squared distances."""
    body = 0 if contact == "disc" else world.rules.body_radius
    time = (jnp.arange(1, MOMENTS + 1) * MOMENT).reshape(-1, *(1,) * (closest.ndim - 2))
    conflict = jnp.where(closest[:, HOLD] < (CONFLICT[contact] + body) ** 2, time, MOMENTS * MOMENT).min(axis=0)
    return jnp.maximum(jnp.sqrt(closest.min(axis=0)) - body, 0), conflict


def _predicted_car(
    world: World, car: VehicleState, route: tuple[Array, Array]
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return x and its slope, y and its slope, where each manoeuvre would bring the car, in its present frame [m].

    Arrays are ``(moment, manoeuvre, *batch)``; the slopes are the direction of the route, almost a unit vector.
    """
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
    x, y = (_along(of_route, travelled, beyond) for of_route in route)
    return x, y


def _along(route: Float[Array, "point *batch"], travelled: Array, beyond: list[Array]) -> tuple[Array, Array]:
    """Return a coordinate of the place ``travelled`` metres along the straight pieces between the route's points.

    Also return its slope there. Each is a sum: the first piece, continued, and the change of slope at each point, from
    there on. Beyond the last point the last piece continues. ``beyond`` holds how far the place is beyond each point
    but the last [m].
    """
    points = jnp.unstack(route)
    lengths = [POINT_SPACING * (to - at) for at, to in pairwise((0, *POINTS))]
    slopes = [(to - at) / length for at, to, length in zip((0, *points[:-1]), points, lengths, strict=True)]
    bends = [new - old for old, new in pairwise(slopes)]
    turned = (bend * metres for bend, metres in zip(bends, beyond, strict=True))
    steeper = (jnp.where(metres > 0, bend, 0) for bend, metres in zip(bends, beyond, strict=True))
    return sum(turned, start=slopes[0] * travelled), sum(steeper, start=slopes[0])
