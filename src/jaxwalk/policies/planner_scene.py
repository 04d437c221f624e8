"""What the belief planner sees: people in the frame of the car's route, and places where somebody may be hidden."""

from __future__ import annotations

from dataclasses import dataclass, replace

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from jaxwalk.interfaces import Moment
from jaxwalk.sim import belief, vehicle
from jaxwalk.sim.corridor import BESIDE, NEARING, on_route, way_to_crosswalk
from jaxwalk.sim.events import distance
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.prediction import DISTANCE, of_lowest, perceived_people
from jaxwalk.sim.unseen_features import HIDDEN_SIDES, beside_the_route
from jaxwalk.sim.what_if import walkers

WATCHED = 12
"""The planner looks at this many people: the first ones along its route."""
ALONGSIDE = 3.0
"""People are looked at until they are this far behind the car's centre [m]."""
COVERED = POINT_SPACING * np.diff((0, *POINTS))
"""How much of the kerb each place beside the route stands for [m]."""


class PeopleAhead(eqx.Module):
    """People in the frame of the route, by what the car knows; arrays ``(person, *batch)``.

    Who isn't there stands `jaxwalk.sim.prediction.DISTANCE` ahead, `jaxwalk.sim.corridor.BESIDE` beside the route.
    """

    along: Float[Array, "person *batch"]
    """Way along the route from the car's centre [m]."""
    left: Float[Array, "person *batch"]
    """Distance to the left of the route [m]."""
    along_speed: Float[Array, "person *batch"]
    """Speed along the route [m/s]."""
    left_speed: Float[Array, "person *batch"]
    """Speed to the left [m/s]."""
    to_crosswalk: Float[Array, "person *batch"]
    """Way to a crosswalk over the route [m]; `jaxwalk.sim.corridor.NEARING` without one."""
    jaywalks: Float[Array, "person *batch"]
    """Probability that the next crossing is a jaywalk, by the crossings that were seen; 0 of who isn't there."""
    on_roadway: Bool[Array, "person *batch"]
    """Whether they are between the kerbs."""
    lost: Bool[Array, "person *batch"]
    """Whether they are hidden now: they are taken to have walked on since they were last seen."""


class HiddenPlaces(eqx.Module):
    """Places just beyond the kerbs, right and left of the route; arrays ``(place, *batch)``."""

    along: Float[Array, "place *batch"]
    """Way along the route from the car's centre [m]."""
    away: Float[Array, "place *batch"]
    """Distance from the route [m]."""
    expected: Float[Array, "place *batch"]
    """How many metres of kerb are hidden there, times the probability that somebody's next crossing is a jaywalk."""


class PlannerScene(eqx.Module):
    """What the car knows of itself, its street and people."""

    speed: Float[Array, "*batch"]
    """The car's speed [m/s]."""
    top: Float[Array, "*batch"]
    """Its top speed here [m/s]."""
    route: Float[Array, "coordinate *batch"]
    """x and y of each point of the route ahead, divided by its distance (`jaxwalk.policies.pursuit.pursue`)."""
    people: PeopleAhead
    places: HiddenPlaces | None
    """None where everybody sees everybody."""


@dataclass(frozen=True)
class ForPlanning:
    """The view of the belief planner. Nothing in it depends on people who have not been perceived."""

    name: str = "planning"

    def __call__(self, moment: Moment) -> PlannerScene:
        """Return what the car knows."""
        state = moment.state
        away = POINT_SPACING * jnp.array(POINTS).reshape(-1, 1, *(1,) * state.step.ndim)
        route = jnp.stack([state.foresight.route_x, state.foresight.route_y], axis=1) / away
        return PlannerScene(
            speed=state.vehicle.speed,
            top=vehicle.top_speed(moment.world, state.vehicle),
            route=route.reshape(-1, *state.step.shape),
            people=_people(moment),
            places=None if state.perceived is None else _places(moment),
        )


def _people(moment: Moment) -> PeopleAhead:
    """Return the first people along the route, also those who were perceived a moment ago."""
    known, lost = _as_remembered(moment)
    along, left, cos, sin = on_route(known)
    seen = known.state.foresight.people
    speeds = to_frame(seen.ahead_speed, seen.left_speed, cos, sin)
    columns = (along, left, *speeds, way_to_crosswalk(known, left, cos, sin), _jaywalks(moment))
    near = (along > -ALONGSIDE) & (along < DISTANCE) & (jnp.abs(left) < BESIDE)
    nobody = (DISTANCE, BESIDE, 0.0, 0.0, NEARING, 0.0)
    shown = tuple(jnp.where(near, column, away) for column, away in zip(columns, nobody, strict=True))
    flags = (near & walkers(known).on_roadway, near & lost)
    batch = moment.state.step.shape
    absent = tuple(jnp.full((WATCHED, *batch), away) for away in (*nobody, False, False))
    return PeopleAhead(*of_lowest((shown[0] + ALONGSIDE) ** 2, (*shown, *flags), absent))


def _as_remembered(moment: Moment) -> tuple[Moment, Bool[Array, "ped *batch"]]:
    """Return the moment as if people who are out of sight now had walked on, and who these are."""
    state = moment.state
    knows = state.perceived
    if knows is None:
        return moment, jnp.zeros(state.pedestrian.x.shape, bool)
    last, age = knows.last, knows.age
    now = replace(last, x=last.x + age * last.velocity_x, y=last.y + age * last.velocity_y)
    people = perceived_people(state.vehicle, now, now.seen)
    foresight, perceived = replace(state.foresight, people=people), replace(knows, now=now)
    known = replace(moment, state=replace(state, foresight=foresight, perceived=perceived))
    return known, last.seen & ~knows.now.seen


def _jaywalks(moment: Moment) -> Float[Array, "ped *batch"]:
    """Return the probability that everybody's next crossing is a jaywalk, by the crossings that the car has seen."""
    world, scenario, state = moment.world, moment.scenario, moment.state
    if state.perceived is None:
        tendency = belief.expected_tendency(world, scenario, state.pedestrian)
    else:
        seen = state.perceived.crossings
        tendency = belief.expected_after(world, scenario, seen.jaywalks, seen.crosswalks)
    return jnp.minimum(1, world.rules.jaywalk_multiplier * tendency)


def _places(moment: Moment) -> HiddenPlaces:
    """Return the places beyond the kerbs: the nearest point of the route first, its right side before its left one."""
    world, course, axes = moment.world, moment.state.vehicle.course, (1,) * moment.state.step.ndim
    right_x, right_y, left_x, left_y, _ = beside_the_route(moment)[:, 1:]
    right = distance(right_x - course.ahead_x, right_y - course.ahead_y)
    left = distance(left_x - course.ahead_x, left_y - course.ahead_y)
    (hidden,) = HIDDEN_SIDES.compute(moment)
    along, covered = (np.repeat(x, 2).reshape(-1, *axes) for x in (POINT_SPACING * np.array(POINTS), COVERED))
    jaywalk = jnp.minimum(1, world.rules.jaywalk_multiplier * belief.prior_mean(world))
    away = jnp.stack([right, left], axis=1).reshape(hidden.shape)
    return HiddenPlaces(jnp.broadcast_to(along, hidden.shape), away, hidden * covered * jaywalk)
