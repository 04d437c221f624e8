"""What agents see: named observation sets, each a list of parts. Lengths are scaled to about 1.

The car sees positions and velocities of people only; never a trait, a decision, a route, a goal or the go/wait output.
The exceptions are the sets in `HIDDEN`, for drivers that show what it would be worth to know more.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.interfaces import Moment
from jaxwalk.sim import belief, future, pedestrian, prediction, vehicle
from jaxwalk.sim.crossing_kind import JAYWALK, LegKind
from jaxwalk.sim.events import distance
from jaxwalk.sim.everybody import for_everybody, index_of, with_index
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.lookup import of_map
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.prediction import ABSENT, NEIGHBOURS
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import State
from jaxwalk.sim.world import World

KERB_CAR_DISTANCE = 40.0
"""A pedestrian at the kerb decides whether to wait only with the car within this distance [m] ..."""
PASSED = 2.5
"""... and not yet this far past [m]: a car does not come back."""
LONG = 8.0
"""Times are capped here [s]."""
MARGINS = (1.0, 2.0, 3.0)
"""Where the metres begin in which the car sees predicted clearances in detail [m]."""
SPEED = 8.33
"""Speeds are scaled by this [m/s], distances by `ABSENT`."""
PRIVILEGED = "privileged"
"""The driver's set that shows where people are going to be."""
TOLD = "route-told"
"""The driver's set that shows the jaywalking tendencies of the nearest people."""
BELIEF = "route-belief"
"""The driver's set that shows what could be inferred about them (`jaxwalk.sim.belief`): nothing hidden."""
HIDDEN = frozenset({PRIVILEGED, TOLD})
"""Sets that no real car could have."""

PARTS_AT_ONCE = 8
"""Up to so many parts XLA's CPU backend writes where they belong; of more, each by itself, and then copies them all."""

Parts = list[Array]


@dataclass(frozen=True)
class Observation:
    """A named observation set of a role, as a view. Raises ValueError for an unknown name."""

    role: str
    name: str

    def __post_init__(self) -> None:
        """Refuse a set that doesn't exist."""
        if self.name not in OBSERVATIONS[self.role]:
            known = ", ".join(OBSERVATIONS[self.role])
            raise ValueError(f"no observation set '{self.name}' for the {self.role}; there are: {known}")

    def __call__(self, moment: Moment) -> Float[Array, "feature ..."]:
        """Return the features, ``(feature, *agents, *batch)``."""
        return _joined(OBSERVATIONS[self.role][self.name](moment))


def _joined(parts: Parts) -> Float[Array, "feature ..."]:
    """Parts with one feature each, ``(*agents, *batch)``, or several, ``(feature, *agents, *batch)``, as one array."""
    axes = min(part.ndim for part in parts)
    several = [part if part.ndim > axes else part[None] for part in parts]
    shape = jnp.broadcast_shapes(*(part.shape[1:] for part in several))
    rows = [jnp.broadcast_to(x, (x.shape[0], *shape)).astype(jnp.float32) for x in several]
    groups = [jnp.concatenate(rows[i : i + PARTS_AT_ONCE]) for i in range(0, len(rows), PARTS_AT_ONCE)]
    return jnp.concatenate(jax.lax.optimization_barrier(groups))  # else the compiler makes one of many parts again


def global_state(world: World, scenario: Scenario, state: State) -> Float[Array, "feature *batch"]:
    """What the paper's critic sees (section III-B), 4 numbers a pedestrian and 10: 58 for 12 people."""
    car, people = state.vehicle, state.pedestrian
    width, height = of_map(world.maps.width, scenario.map), of_map(world.maps.height, scenario.map)
    vx, vy = pedestrian.velocity(world, scenario, people)
    of_people = [people.x / width, people.y / height, distance(vx, vy) / 2, scenario.jaywalking_tendency]
    goal_x, goal_y = vehicle.goal(world, scenario)
    return _joined([
        *of_people,
        car.x / width, car.y / height, car.cos, car.sin, car.speed / SPEED, car.steering / world.rules.max_steering,
        goal_x / width, goal_y / height, distance(goal_x - car.x, goal_y - car.y) / ABSENT,
        1 - state.step / world.rules.horizon,
    ])  # fmt: skip


def _driver_paper(moment: Moment) -> Parts:
    """The paper's 34: own state and goal 8, lane 2, nearest 6 people x (relative position 2, velocity 2)."""
    world, scenario, state = moment.world, moment.scenario, moment.state
    maps = world.maps
    car = state.vehicle
    goal_x, goal_y = vehicle.goal(world, scenario)
    ahead, left = to_frame(goal_x - car.x, goal_y - car.y, car.cos, car.sin)
    lateral, heading_cos, heading_sin = vehicle.route_frame(car)
    return [
        car.x / of_map(maps.width, scenario.map), car.y / of_map(maps.height, scenario.map), car.cos, car.sin,
        car.speed / SPEED, ahead / ABSENT, left / ABSENT, distance(ahead, left) / ABSENT, lateral / 4,
        jnp.arctan2(heading_sin, heading_cos) / jnp.pi, _nearest_people(state),
    ]  # fmt: skip


def _driver_route(moment: Moment) -> Parts:
    """The car in the frame of its route: lane keeping 6, route ahead 16, predicted clearances 13, nearest people 24.

    Clearances come once more as shares of the metres from 1 to 4, one by one: there a touch is decided, and the whole
    range in one number is too coarse for a network to learn that soon.
    """
    clearance, conflict = moment.state.foresight.clearance, moment.state.foresight.conflict
    margin = jnp.concatenate([jnp.clip(clearance - metre, 0, 1) for metre in MARGINS])
    longest = prediction.MOMENTS * prediction.MOMENT
    ahead = [clearance / prediction.FAR, margin, conflict / longest]
    return [*_on_route(moment), *ahead, _nearest_people(moment.state)]


def _driver_told(moment: Moment) -> Parts:
    """As `_driver_route`, and the jaywalking tendency of each of the nearest people 6."""
    return [*_driver_route(moment), _of_nearest(moment.state, moment.scenario.jaywalking_tendency)]


def _driver_belief(moment: Moment) -> Parts:
    """As `_driver_route`, and the posterior mean of the jaywalking tendency of each of the nearest people 6."""
    expected = belief.expected_tendency(moment.world, moment.scenario, moment.state.pedestrian)
    return [*_driver_route(moment), _of_nearest(moment.state, expected)]


def _of_nearest(state: State, tendency: Float[Array, "ped *batch"]) -> Float[Array, "neighbour *batch"]:
    """The tendencies of the nearest people, nearest first; of one who isn't there, nothing is known."""
    unknown = jnp.full((NEIGHBOURS, *state.step.shape), belief.PRIOR_MEAN)
    return prediction.of_nearest(state.foresight.people, tendency, unknown)


def _driver_privileged(moment: Moment) -> Parts:
    """The car in the frame of its route 22, and how near people will be to the places ahead if everybody goes 7728."""
    nearest = future.clearances(moment.world, moment.scenario, moment.state) / prediction.FAR
    return [*_on_route(moment), nearest.reshape(-1, *moment.state.step.shape)]


def _on_route(moment: Moment) -> Parts:
    """Lane keeping 6, route ahead 16."""
    world, scenario, state = moment.world, moment.scenario, moment.state
    car = state.vehicle
    lateral, heading_cos, heading_sin = vehicle.route_frame(car)
    to_go = vehicle.route_length(world, scenario) - car.along
    away = (jnp.array(POINTS) * POINT_SPACING).reshape(-1, 1, *(1,) * car.x.ndim)
    route = jnp.stack([state.foresight.route_x, state.foresight.route_y], axis=1) / away
    return [
        car.speed / SPEED, car.steering / world.rules.max_steering, lateral / 2, heading_cos, heading_sin,
        jnp.minimum(to_go / ABSENT, 2), route.reshape(-1, *car.x.shape),
    ]  # fmt: skip


def _nearest_people(state: State) -> Float[Array, "feature *batch"]:
    """Relative position and velocity of the nearest people in the car's frame, 4 for each, nearest first."""
    seen = state.foresight.nearest
    rows = jnp.stack([seen.ahead / ABSENT, seen.left / ABSENT, seen.ahead_speed / SPEED, seen.left_speed / SPEED], 1)
    return rows.reshape(-1, *rows.shape[2:])


def _pedestrian_paper(moment: Moment) -> Parts:
    """The paper's 20: own position 2, velocity 2, traits 4, next waypoint 2, surface 3, on a jaywalk 1, the car's
    relative position 2 and velocity 2, nearest other pedestrian 2. Relative means in the map's axes, from oneself."""
    world, scenario, state = moment.world, moment.scenario, moment.state
    maps = world.maps
    car, people = state.vehicle, state.pedestrian
    vx, vy = pedestrian.velocity(world, scenario, people)
    other_x, other_y = _nearest_other(people.x, people.y)
    return [
        people.x / of_map(maps.width, scenario.map), people.y / of_map(maps.height, scenario.map), vx / 2, vy / 2,
        scenario.traits, (people.leg.end_x - people.x) / ABSENT, (people.leg.end_y - people.y) / ABSENT,
        ~people.on_roadway, people.on_roadway & people.on_crosswalk, people.on_roadway & ~people.on_crosswalk,
        people.leg.kind == LegKind.ACROSS,
        (car.x[None] - people.x) / ABSENT, (car.y[None] - people.y) / ABSENT,
        (car.speed * car.cos)[None] / SPEED, (car.speed * car.sin)[None] / SPEED,
        other_x / ABSENT, other_y / ABSENT,
    ]  # fmt: skip


def _pedestrian_kerb(moment: Moment) -> Parts:
    """What bears on stepping into the road: whether there is anything to decide 1, the car as it comes 7, the times at
    which both would be where their ways cross 3, how close they would come if one goes now 2, oneself 6.

    There is something to decide on the last metre before the roadway, with the car within 40 m and not yet past.
    Vectors are in the car's frame.
    """
    world, scenario, state = moment.world, moment.scenario, moment.state
    car, people = state.vehicle, state.pedestrian
    ahead, left = state.foresight.people.ahead, state.foresight.people.left
    along, across = to_frame(people.leg.cos, people.leg.sin, car.cos[None], car.sin[None])
    pace, speed = scenario.walking_speed(world), jnp.broadcast_to(car.speed[None], ahead.shape)
    close = (ahead * ahead + left * left < KERB_CAR_DISTANCE**2) & (ahead > -PASSED)
    decides = pedestrian.at_kerb(world, people) & pedestrian.enters_roadway(people) & close

    crossing_speed = pace * across
    toward = left * crossing_speed < 0
    own_time = jnp.where(toward, -left / jnp.where(toward, crossing_speed, 1), LONG)
    car_time = ahead / jnp.maximum(speed, 0.5)
    miss, closest = prediction.predicted_miss(world, scenario, state)
    return [
        decides, ahead / KERB_CAR_DISTANCE, left / KERB_CAR_DISTANCE, speed / SPEED,
        (car.acceleration / world.rules.max_acceleration)[None], (car.steering / world.rules.max_steering)[None],
        along, across,
        jnp.clip(car_time, -LONG, LONG) / LONG, jnp.minimum(own_time, LONG) / LONG,
        jnp.clip(car_time - own_time, -LONG, LONG) / LONG, jnp.minimum(miss, 10) / 10,
        jnp.minimum(closest, LONG) / LONG, pace / 2,
        scenario.traits[0], scenario.traits[2], scenario.traits[3], people.crossing == JAYWALK,
        jnp.clip(people.to_kerb, -1, world.rules.kerb_distance),
    ]  # fmt: skip


def _nearest_other(x: Float[Array, "ped *batch"], y: Float[Array, "ped *batch"]) -> tuple[Array, Array]:
    """Vector from each pedestrian to the nearest other one [m]; 60 m ahead where nobody is nearer."""
    people, order = x.shape[0], jnp.arange(x.shape[0]).reshape((-1,) + (1,) * (x.ndim - 1))

    def compare(other: tuple[Array, Array, Array], nearest: Array) -> Array:
        other_x, other_y, index = other
        key = with_index((other_x - x) ** 2 + (other_y - y) ** 2, index, people)
        return jnp.where((key < nearest) & (index != order), key, nearest)

    nobody = jnp.broadcast_to(with_index(jnp.float32(ABSENT**2), jnp.int32(people), people), x.shape)
    key = for_everybody((x, y, order), compare, nobody)

    def pick(other: tuple[Array, Array, Array], found: tuple[Array, Array]) -> tuple[Array, Array]:
        other_x, other_y, index = other
        chosen = index_of(key, people) == index
        return jnp.where(chosen, other_x - x, found[0]), jnp.where(chosen, other_y - y, found[1])

    return for_everybody((x, y, order), pick, (jnp.full_like(x, ABSENT), jnp.zeros_like(x)))


OBSERVATIONS: dict[str, dict[str, Callable[[Moment], Parts]]] = {
    "driver": {
        "paper": _driver_paper,
        "route": _driver_route,
        TOLD: _driver_told,
        BELIEF: _driver_belief,
        PRIVILEGED: _driver_privileged,
    },
    "pedestrian": {"paper": _pedestrian_paper, "kerb": _pedestrian_kerb},
}
"""The named observation sets of each role."""

_ROUTE = {
    "speed": 1, "steering": 1, "lateral": 1, "heading": 2, "to_go": 1, "route": 2 * len(POINTS),
    "clearance": 3, "margin": 3 * len(MARGINS), "conflict": 1, "people": 4 * NEIGHBOURS,
}  # fmt: skip
LAYOUTS: dict[str, dict[str, dict[str, int]]] = {
    "driver": {
        "paper": {
            "position": 2, "heading": 2, "speed": 1, "goal": 2, "goal_distance": 1, "lateral": 1, "heading_error": 1,
            "people": 4 * NEIGHBOURS,
        },
        "route": _ROUTE,
        TOLD: {**_ROUTE, "tendencies": NEIGHBOURS},
        BELIEF: {**_ROUTE, "tendencies": NEIGHBOURS},
        PRIVILEGED: {
            "speed": 1, "steering": 1, "lateral": 1, "heading": 2, "to_go": 1, "route": 2 * len(POINTS),
            "clearances": future.MOMENTS * future.PLACES,
        },
    },
    "pedestrian": {
        "paper": {
            "position": 2, "velocity": 2, "traits": 4, "next_waypoint": 2, "surface": 3, "on_jaywalk": 1,
            "car_position": 2, "car_velocity": 2, "nearest_other": 2,
        },
        "kerb": {
            "decides": 1, "place": 2, "car_motion": 3, "direction": 2, "times": 3, "miss": 2, "pace": 1, "traits": 3,
            "jaywalk": 1, "to_kerb": 1,
        },
    },
}  # fmt: skip
"""For whoever writes a rule: the parts of each set, in their order, and how many features each has."""


def part(role: str, name: str, which: str) -> slice:
    """Where a part stands in an observation set; raises KeyError for one that doesn't exist."""
    layout = LAYOUTS[role][name]
    size = layout[which]
    names = list(layout)
    begin = sum(layout[before] for before in names[: names.index(which)])
    return slice(begin, begin + size)


def size(role: str, name: str) -> int:
    """How many features an observation set has; raises KeyError for one that doesn't exist."""
    return sum(LAYOUTS[role][name].values())
