"""Where people are for the car now, and how close it would come to them if it braked, held its speed or accelerated."""

from __future__ import annotations

from dataclasses import replace
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
from jaxwalk.sim.manoeuvres import HOLD, Walk, clearance_and_conflict, far, squared_clearance
from jaxwalk.sim.perceived import Perceived, Sighting
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.sim_config import ContactRule
from jaxwalk.sim.state import Foresight, Motion, PedestrianState, State, VehicleState
from jaxwalk.sim.world import World

T = TypeVar("T")

NEIGHBOURS = 6
"""A view shows this many people, the nearest ones. How close the car would come counts everybody that it perceives."""
DISTANCE = 60.0
"""Distances in views are divided by this [m]; a neighbour that isn't there stands this far ahead."""
AWAY = 1e4
"""People that the car doesn't perceive are this far ahead of it [m], standing: too far for every prediction."""
CAUTION_AHEAD, CAUTION_ASIDE = 15.0, 6.0
"""The car should be cautious with people on the roadway up to this far ahead of it, and to either side [m]."""


def unhidden(moment: Moment) -> Moment:
    """Return the moment as if nothing hid anybody: people as they are, and all that is predicted from them."""
    world, scenario, state = moment.world, moment.scenario, moment.state
    if state.perceived is None:
        return moment
    foresight = foresee(world, scenario, state.vehicle, state.pedestrian)
    return replace(moment, state=replace(state, foresight=foresight, perceived=None))


def relative_people(world: World, scenario: Scenario, car: VehicleState, people: PedestrianState) -> Motion:
    """Return people in the car's frame; arrays ``(ped, *batch)``. Who isn't there stands `AWAY`."""
    ahead, left = to_frame(people.x - car.x[None], people.y - car.y[None], car.cos[None], car.sin[None])
    vx, vy = pedestrian.velocity(world, scenario, people)
    motion = Motion(ahead, left, *to_frame(vx, vy, car.cos[None], car.sin[None]))
    if scenario.absent is None:
        return motion
    columns = zip(jax.tree.leaves(motion), (AWAY, 0, 0, 0), strict=True)
    return Motion(*(jnp.where(scenario.absent, away, column) for column, away in columns))


def motion_of_people(world: World, scenario: Scenario, state: State) -> Motion:
    """Return people in the car's frame as they are, whether the car perceives them or not; arrays ``(ped, *batch)``."""
    if state.perceived is None:
        return state.foresight.people
    return relative_people(world, scenario, state.vehicle, state.pedestrian)


def clearance_at_held_speed(world: World, scenario: Scenario, state: State) -> Array:
    """Return the clearance predicted if the car holds its speed [m], from people as they are: ``(*batch)``."""
    return _predicted_from_truth(world, scenario, state)[0][HOLD]


def conflict_at_held_speed(world: World, scenario: Scenario, state: State) -> Array:
    """Return the time until the first conflict if the car holds its speed [s], from people as they are: ``(*batch)``.

    It is at most `jaxwalk.sim.manoeuvres.AHEAD`.
    """
    return _predicted_from_truth(world, scenario, state)[1][HOLD]


def _predicted_from_truth(world: World, scenario: Scenario, state: State) -> tuple[Array, Array]:
    """Return ``clearance`` and ``conflict`` of a `Foresight` from people as they are."""
    if state.perceived is None:
        return state.foresight.clearance, state.foresight.conflict
    moment = Moment(world, scenario, state)
    return predict(moment, motion_of_people(world, scenario, state), world.rules.contact)


def people_ahead(world: World, scenario: Scenario, state: State) -> tuple[Array, Array]:
    """Return ``crosswalk_user`` and ``jaywalker`` of a `Foresight` from people as they are."""
    if state.perceived is None:
        return state.foresight.crosswalk_user, state.foresight.jaywalker
    people, motion = state.pedestrian, motion_of_people(world, scenario, state)
    on_roadway = people.on_roadway & _close_ahead(motion)
    crosswalk_user, jaywalker = ((on_roadway & (people.crossing == kind)).any(axis=0) for kind in (CROSSWALK, JAYWALK))
    return crosswalk_user, jaywalker


def _close_ahead(person: Motion) -> Array:
    return (person.ahead > 0) & (person.ahead < CAUTION_AHEAD) & (jnp.abs(person.left) < CAUTION_ASIDE)


def perceived_people(car: VehicleState, sighting: Sighting, chosen: Array) -> Motion:
    """Return the chosen people in the car's frame as they were seen; others stand `AWAY`. Arrays ``(ped, *batch)``."""
    cos, sin = car.cos[None], car.sin[None]
    place = to_frame(sighting.x - car.x[None], sighting.y - car.y[None], cos, sin)
    columns = (*place, *to_frame(sighting.velocity_x, sighting.velocity_y, cos, sin))
    return Motion(*(jnp.where(chosen, column, away) for column, away in zip(columns, (AWAY, 0, 0, 0), strict=True)))


def foresee(
    world: World, scenario: Scenario, car: VehicleState, people: PedestrianState, perceived: Perceived | None = None
) -> Foresight:
    """Return people as the car sees them, the route ahead, and what is predicted from now on.

    The predictions are the smallest clearance for each manoeuvre, at most 10 m, and the time until its first conflict,
    at most 3 s (`jaxwalk.sim.manoeuvres`), by the world's contact; people keep their velocity. With ``perceived``,
    everything is computed from what the car perceives. People are compared with all moments one after the other, so
    that no large array is stored.
    """
    route = to_frame(car.course.ahead_x - car.x, car.course.ahead_y - car.y, car.cos, car.sin)
    contact = world.rules.contact
    squared = squared_clearance(world, car, route, contact)
    known = people if perceived is None else perceived.now
    if perceived is None:
        motion = relative_people(world, scenario, car, people)
    else:
        motion = perceived_people(car, perceived.now, perceived.now.seen)
    on_crosswalk = known.on_roadway & (known.crossing == CROSSWALK)
    jaywalking = known.on_roadway & (known.crossing == JAYWALK)

    def compare(one: tuple[Motion, Array, Array], found: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        closest, crosswalk_user, jaywalker = found
        person, uses_crosswalk, jaywalks = one
        away = squared(person)
        ahead = _close_ahead(person)
        return (
            jnp.where(away < closest, away, closest),
            crosswalk_user | (ahead & uses_crosswalk),
            jaywalker | (ahead & jaywalks),
        )

    no = jnp.zeros((1, *car.x.shape), bool)
    nothing = (far(car, contact), no, no)
    closest, crosswalk_user, jaywalker = for_everybody((motion, on_crosswalk, jaywalking), compare, nothing)
    clearance, conflict = clearance_and_conflict(world, closest, contact)
    nearest = nearest_people(motion)
    return Foresight(
        people=motion,
        nearest=nearest if perceived is None and scenario.absent is None else _present(nearest),
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
    car, people, motion = state.vehicle, state.pedestrian, motion_of_people(world, scenario, state)
    along, across = to_frame(people.leg.cos, people.leg.sin, car.cos[None], car.sin[None])
    pace = pedestrian.pace(world, scenario, people)
    vx, vy = pace * along - car.speed[None], pace * across
    when = -(motion.ahead * vx + motion.left * vy) / jnp.maximum(vx * vx + vy * vy, 1e-6)
    when = jnp.maximum(when, 0)
    return distance(motion.ahead + vx * when, motion.left + vy * when), when


def nearest_people(motion: Motion) -> Motion:
    """Return the nearest `NEIGHBOURS` people, nearest first; one that isn't there stands far ahead."""
    return of_nearest(motion, motion, nobody(motion.ahead.shape[1:]))


def nearest_and(motion: Motion, of_all: Float[Array, "ped *batch"]) -> tuple[Motion, Float[Array, "neighbour *batch"]]:
    """Return the nearest people as `nearest_people` does, but nobody who is `AWAY`, and their part of ``of_all``."""
    absent = nobody(motion.ahead.shape[1:])
    nearest, values = of_nearest(motion, (motion, of_all), (absent, jnp.zeros_like(absent.ahead)))
    return _present(nearest), values


def nobody(batch: tuple[int, ...]) -> Motion:
    """Return neighbours who aren't there: arrays ``(neighbour, *batch)``."""
    return Motion(*(jnp.full((NEIGHBOURS, *batch), default) for default in (DISTANCE, 0.0, 0.0, 0.0)))


def _present(nearest: Motion) -> Motion:
    """Return the nearest people; those who aren't perceived count as absent."""
    return Motion(jnp.where(nearest.ahead == AWAY, DISTANCE, nearest.ahead), *jax.tree.leaves(nearest)[1:])


def of_nearest(motion: Motion, of_all: T, absent: T) -> T:
    """Return values of the nearest `NEIGHBOURS` people, nearest first: arrays ``(neighbour, *batch)``.

    Args:
        motion: everybody, ``(ped, *batch)``.
        of_all: a pytree with a value of everybody, arrays ``(ped, *batch)``.
        absent: the values of neighbours who aren't there, arrays ``(neighbour, *batch)``.
    """
    return of_lowest(motion.ahead**2 + motion.left**2, of_all, absent)


def of_lowest(rank_by: Float[Array, "ped *batch"], of_all: T, absent: T) -> T:
    """Return values of the people with the lowest numbers, lowest first, as many as ``absent`` has of them.

    It ranks people by counting who is lower, because a sort is slow in this layout.

    Args:
        rank_by: a finite number of 0 or more for everybody.
        of_all: a pytree with a value of everybody, arrays ``(ped, *batch)``.
        absent: the values where there are fewer people, arrays ``(chosen, *batch)``.
    """
    people, *batch = rank_by.shape
    keys = with_index(rank_by, jnp.arange(people).reshape(-1, *(1,) * len(batch)), people)
    place = jnp.arange(len(jax.tree.leaves(absent)[0])).reshape(-1, *(1,) * len(batch))

    def count(key: Array, rank: Array) -> Array:
        return rank + (key < keys)

    ranks = for_everybody(keys, count, jnp.zeros(rank_by.shape, jnp.int32))

    def pick(one: tuple[Array, T], found: T) -> T:
        rank, person = one
        return jax.tree.map(lambda new, kept: jnp.where(rank == place, new, kept), person, found)

    return for_everybody((ranks, of_all), pick, absent)
