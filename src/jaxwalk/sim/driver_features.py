"""What a driver can see: features in the car's frame, arrays ``(number, *batch)``."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.interfaces import Moment
from jaxwalk.sim import future, prediction, vehicle, what_if
from jaxwalk.sim.events import distance
from jaxwalk.sim.features import (
    COSINE,
    OF_MAP,
    SPEED,
    Bound,
    Feature,
    Limits,
    both,
    on_map,
    share,
    signed,
    within_diagonals,
)
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.manoeuvres import AHEAD, FAR, HOLD, MANOEUVRES
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.prediction import DISTANCE, NEIGHBOURS
from jaxwalk.sim.sim_config import ContactRule
from jaxwalk.sim.state import Motion

MARGINS: dict[ContactRule, tuple[float, ...]] = {"disc": (1.0, 2.0, 3.0), "footprint": (0.0, 0.5, 1.0, 1.5)}
"""Lower ends of the intervals in which the car sees predicted clearances in detail [m] ..."""
MARGIN: dict[ContactRule, float] = {"disc": 1.0, "footprint": 0.5}
"""... and their length [m]."""
METRES, SPEEDS = f"{DISTANCE:g} m", f"{SPEED:g} m/s"
"""Units of distances and of speeds."""
PERSON_UNITS = (METRES, METRES, SPEEDS, SPEEDS)
"""Units of `person_rows`."""


def _goal(moment: Moment) -> tuple[Array, Array]:
    """Return the goal ahead and to the left [m]."""
    car = moment.state.vehicle
    x, y = vehicle.goal(moment.world, moment.scenario)
    return to_frame(x - car.x, y - car.y, car.cos, car.sin)


def _goal_distance(moment: Moment) -> Sequence[Array]:
    return (distance(*_goal(moment)) / DISTANCE,)


def _heading_error(moment: Moment) -> Sequence[Array]:
    """Return the angle between the car's heading and its route's, over pi."""
    _, cos, sin = vehicle.route_frame(moment.state.vehicle)
    return (jnp.arctan2(sin, cos) / jnp.pi,)


def _people(moment: Moment) -> Sequence[Array]:
    """Return position and velocity of the nearest people, 4 numbers each, nearest first."""
    rows = person_rows(moment.state.foresight.nearest)
    return (rows.reshape(-1, *rows.shape[2:]),)


def person_rows(seen: Motion) -> Float[Array, "neighbour 4 *batch"]:
    """Return position and velocity of people in the car's frame, as a network sees them."""
    return jnp.stack(
        [seen.ahead / DISTANCE, seen.left / DISTANCE, seen.ahead_speed / SPEED, seen.left_speed / SPEED], 1
    )


def person_bounds(limits: Limits) -> Sequence[Bound]:
    """Return the bounds of these 4 numbers."""
    near, walk = both(max(limits.diagonal, DISTANCE) / DISTANCE), both(limits.config.fastest / SPEED)
    return [near, near, walk, walk]


def _to_go(moment: Moment) -> Sequence[Array]:
    """Return the distance to the goal along the route."""
    to_go = vehicle.route_length(moment.world, moment.scenario) - moment.state.vehicle.along
    return (jnp.minimum(to_go / DISTANCE, 2),)


def _to_go_bounds(limits: Limits) -> Sequence[Bound]:
    lowest, highest = limits.to_go
    return [(lowest / DISTANCE, min(highest / DISTANCE, 2.0))]


def _route(moment: Moment) -> Sequence[Array]:
    """Return the points of the route ahead, each over its distance along the route."""
    state = moment.state
    away = (jnp.array(POINTS) * POINT_SPACING).reshape(-1, 1, *(1,) * state.step.ndim)
    route = jnp.stack([state.foresight.route_x, state.foresight.route_y], axis=1) / away
    return (route.reshape(-1, *state.step.shape),)


def _margins(clearance: Array, rule: ContactRule) -> Array:
    """Return how far each predicted clearance reaches into each interval of `MARGINS`, in [0, 1].

    Whether the car touches somebody depends on these metres. A network learns it sooner from a number for each of them
    than from one number for the whole range.
    """
    return jnp.concatenate([jnp.clip((clearance - at) / MARGIN[rule], 0, 1) for at in MARGINS[rule]])


def _predictions(rule: ContactRule, conflicts_of: slice) -> tuple[Feature, ...]:
    """Return the features of what is predicted, with clearances by this rule and conflicts of these manoeuvres."""

    def clearance(moment: Moment) -> Sequence[Array]:
        return (prediction.clearance_by(moment, rule)[0] / FAR,)

    def margin(moment: Moment) -> Sequence[Array]:
        return (_margins(prediction.clearance_by(moment, rule)[0], rule),)

    def conflict(moment: Moment) -> Sequence[Array]:
        return (prediction.clearance_by(moment, rule)[1][conflicts_of] / AHEAD,)

    return (
        Feature("clearance", len(MANOEUVRES), share, clearance, (f"{FAR:g} m",)),
        Feature("margin", len(MANOEUVRES) * len(MARGINS[rule]), share, margin, (f"{MARGIN[rule]:g} m",)),
        Feature("conflict", len(MANOEUVRES[conflicts_of]), share, conflict, (f"{AHEAD:g} s",)),
    )


def _what_if(name: str, predict: Callable[[Moment, ContactRule], tuple[Array, Array]]) -> Feature:
    """Return the feature of clearances, margins and conflicts by footprint if people did what is predicted."""

    def predicted(moment: Moment) -> Sequence[Array]:
        clearance, conflict = predict(moment, "footprint")
        return clearance / FAR, _margins(clearance, "footprint"), conflict / AHEAD

    count, margins = len(MANOEUVRES), len(MARGINS["footprint"])
    units = (f"{FAR:g} m",) * count + (f"{MARGIN['footprint']:g} m",) * (count * margins) + (f"{AHEAD:g} s",) * count
    return Feature(name, count * (2 + margins), share, predicted, units)


def _future_clearances(moment: Moment) -> Sequence[Array]:
    """Return how near people will be to the places ahead if everybody goes."""
    nearest = future.clearances(moment.world, moment.scenario, moment.state) / FAR
    return (nearest.reshape(-1, *moment.state.step.shape),)


def _limits(moment: Moment) -> Sequence[Array]:
    """Return the car's top speed at the places ahead."""
    return (future.limits(moment.world, moment.scenario, moment.state) / SPEED,)


SPEED_OF_CAR = Feature(
    "speed",
    1,
    lambda limits: [(0.0, limits.config.max_speed / SPEED)],
    lambda m: (m.state.vehicle.speed / SPEED,),
    (SPEEDS,),
)
STEERING = Feature(
    "steering",
    1,
    signed,
    lambda m: (m.state.vehicle.steering / m.world.rules.max_steering,),
    ("largest steering angle",),
)
TO_GO = Feature("to_go", 1, _to_go_bounds, _to_go, (METRES,))
PEOPLE = Feature("people", 4 * NEIGHBOURS, person_bounds, _people, PERSON_UNITS)

PAPER = (
    Feature("position", 2, share, lambda m: on_map(m, m.state.vehicle.x, m.state.vehicle.y), OF_MAP),
    Feature("heading", 2, signed, lambda m: (m.state.vehicle.cos, m.state.vehicle.sin), COSINE),
    SPEED_OF_CAR,
    Feature("goal", 2, within_diagonals(DISTANCE), lambda m: [metres / DISTANCE for metres in _goal(m)], (METRES,)),
    Feature("goal_distance", 1, lambda limits: [(0.0, limits.diagonal / DISTANCE)], _goal_distance, (METRES,)),
    Feature("lateral", 1, within_diagonals(2.0), lambda m: (vehicle.route_frame(m.state.vehicle)[0] / 4,), ("4 m",)),
    Feature("heading_error", 1, signed, _heading_error, ("pi rad",)),
    PEOPLE,
)
"""The paper's 34: own state and goal 8, lane 2, nearest 6 people x (relative position 2, velocity 2)."""

ON_ROUTE = (
    SPEED_OF_CAR,
    STEERING,
    Feature("lateral", 1, within_diagonals(2.0), lambda m: (vehicle.route_frame(m.state.vehicle)[0] / 2,), ("2 m",)),
    Feature("heading", 2, signed, lambda m: vehicle.route_frame(m.state.vehicle)[1:], COSINE),
    TO_GO,
    Feature(
        "route",
        2 * len(POINTS),
        lambda limits: [both(limits.diagonal / (POINT_SPACING * point)) for point in POINTS for _ in "xy"],
        _route,
        ("the point's distance along the route",),
    ),
)
"""The car in the frame of its route: lane keeping 6, route ahead 16."""

ROUTE = (*ON_ROUTE, *_predictions("disc", slice(HOLD, HOLD + 1)), PEOPLE)
"""The car in the frame of its route 22, predicted clearances between centres 13, nearest people 24."""

ROUTE_FOOTPRINT = (
    *ON_ROUTE,
    *_predictions("footprint", slice(None)),
    _what_if("if_they_turn", what_if.clearance_if_they_turn),
    _what_if("if_they_cross", what_if.clearance_if_they_cross),
    PEOPLE,
)
"""As `ROUTE`, but with clearances between the car's rectangle and people's bodies: 18 numbers if people walk on as they
do, 18 if everybody beside the roadway turned to the car's route now, 18 if all who walk to a crosswalk took it."""

FUTURE_CLEARANCES = Feature("clearances", future.MOMENTS * future.PLACES, share, _future_clearances, (f"{FAR:g} m",))
"""How near people will be to the places ahead, at each moment. Nobody can know this."""

LIMITS = Feature("limits", future.PLACES, lambda limits: [(0.0, limits.config.max_speed / SPEED)], _limits, (SPEEDS,))
"""The car's top speed at these places."""
