"""What the car sees of people, and how close it would come to them if it braked, held its speed or accelerated."""

from __future__ import annotations

from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array

from jaxwalk.interfaces import Moment
from jaxwalk.sim import pedestrian
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.events import distance
from jaxwalk.sim.everybody import for_everybody, with_index
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.manoeuvres import Walk, clearance_and_conflict, far, squared_clearance
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.sim_config import ContactRule
from jaxwalk.sim.state import Foresight, Motion, PedestrianState, State, VehicleState
from jaxwalk.sim.world import World

T = TypeVar("T")

NEIGHBOURS = 6
"""The car sees this many people, the nearest ones."""
ABSENT = 60.0
"""A neighbour that isn't there stands this far ahead [m]."""
CAUTION_AHEAD, CAUTION_ASIDE = 15.0, 6.0
"""The car should be cautious with people on the roadway up to this far ahead of it, and to either side [m]."""


def relative_people(world: World, scenario: Scenario, car: VehicleState, people: PedestrianState) -> Motion:
    """Return people in the car's frame; arrays ``(ped, *batch)``."""
    ahead, left = to_frame(people.x - car.x[None], people.y - car.y[None], car.cos[None], car.sin[None])
    vx, vy = pedestrian.velocity(world, scenario, people)
    return Motion(ahead, left, *to_frame(vx, vy, car.cos[None], car.sin[None]))


def foresee(world: World, scenario: Scenario, car: VehicleState, people: PedestrianState) -> Foresight:
    """Return people as the car sees them, the route ahead, and what is predicted from now on.

    The predictions are the smallest clearance for each manoeuvre, at most 10 m, and the time until its first conflict,
    at most 3 s (`jaxwalk.sim.manoeuvres`), by the world's contact; people keep their velocity. One pedestrian after
    the other is compared with all moments, so that no large array is stored.
    """
    route = to_frame(car.course.ahead_x - car.x, car.course.ahead_y - car.y, car.cos, car.sin)
    contact = world.rules.contact
    squared = squared_clearance(world, car, route, contact)
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
    nothing = (far(car, contact), nobody, nobody)
    closest, crosswalk_user, jaywalker = for_everybody((motion, on_crosswalk, jaywalking), compare, nothing)
    clearance, conflict = clearance_and_conflict(world, closest, contact)
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
    seen = moment.state.foresight
    if contact == moment.world.rules.contact:
        return seen.clearance, seen.conflict
    return predict(moment, seen.people, contact)


def predict(moment: Moment, people: Walk, contact: ContactRule) -> tuple[Array, Array]:
    """Return ``clearance`` and ``conflict`` of a `Foresight` if people, a pytree of ``(ped, *batch)``, walk so."""
    world, car, seen = moment.world, moment.state.vehicle, moment.state.foresight
    squared = squared_clearance(world, car, (seen.route_x, seen.route_y), contact)
    closest = for_everybody(people, lambda person, found: jnp.minimum(squared(person), found), far(car, contact))
    return clearance_and_conflict(world, closest, contact)


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
