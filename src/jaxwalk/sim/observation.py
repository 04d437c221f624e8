"""What agents see: named observation sets, each a tuple of features. Lengths are scaled to about 1.

The car sees positions and velocities of people only; never a trait, a decision, a route, a goal or the go/wait output.
The exceptions are the sets in `PRIVILEGED_SETS`. A driver with one of them shows what it would be worth to know more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Array, Float

from jaxwalk.interfaces import Moment
from jaxwalk.sim import driver_features, intent_features, pedestrian, pedestrian_features, vehicle
from jaxwalk.sim.corridor import CORRIDOR as ON_CORRIDOR
from jaxwalk.sim.events import distance
from jaxwalk.sim.features import SPEED, Bound, Feature, Limits, joined, on_map
from jaxwalk.sim.prediction import DISTANCE, unhidden
from jaxwalk.sim.surroundings import SURROUNDINGS
from jaxwalk.sim.unseen_features import HIDDEN_SIDES, LAST_SEEN, NEXT_CROSSWALK
from jaxwalk.sim.world import World

PRIVILEGED = "privileged"
"""The driver's set that shows where people will be."""
FOOTPRINT = "route-footprint"
"""The driver's set that recipe ``fast`` learns from."""
TOLD = f"{FOOTPRINT}-told"
"""The same, and the jaywalking tendencies of the nearest people."""
BELIEF = f"{FOOTPRINT}-belief"
"""The same, and what can be inferred about these tendencies (`jaxwalk.sim.belief`): nothing hidden."""
DECIDED = f"{FOOTPRINT}-decided"
"""The same, and who of the nearest people has decided to jaywalk, and where."""
PLACEBO = f"{FOOTPRINT}-placebo"
"""The same, and as many numbers as in `TOLD` that say nothing, for comparisons."""
MEMORY = f"{FOOTPRINT}-memory"
"""The same, and who was last seen."""
AWARE = f"{FOOTPRINT}-aware"
"""The same, who was last seen, which sides of the car's way are hidden, and how far the next crosswalk is."""
X_RAY = f"{FOOTPRINT}-x-ray"
"""The same, but of everybody as they are, also of people who are not perceived."""
CORRIDOR = "corridor"
"""The driver's set of the reference drivers: people in the frame of the route."""
SEEING_THROUGH = frozenset({X_RAY})
"""Sets that are computed as if nothing hid anybody."""
PRIVILEGED_SETS = frozenset({PRIVILEGED, TOLD, DECIDED, PLACEBO, "route-told"}) | SEEING_THROUGH
"""Sets that no real car could have: they show what nothing could perceive, or see through what hides people."""
INFERRED = frozenset({BELIEF, "route-belief"})
"""Sets that show what only an observer could infer who knows how often people jaywalk; it has seen what its car has."""
ROUNDING = 1e-3
"""Bounds are this much wider than derived: single precision rounds."""

OBSERVATIONS: dict[str, dict[str, tuple[Feature, ...]]] = {
    "driver": {
        "paper": driver_features.PAPER,
        "route": driver_features.ROUTE,
        "route-told": (*driver_features.ROUTE, intent_features.TOLD_TENDENCIES),
        "route-belief": (*driver_features.ROUTE, intent_features.EXPECTED_TENDENCIES),
        FOOTPRINT: driver_features.ROUTE_FOOTPRINT,
        TOLD: (*driver_features.ROUTE_FOOTPRINT, intent_features.TOLD_TENDENCIES),
        BELIEF: (*driver_features.ROUTE_FOOTPRINT, intent_features.EXPECTED_TENDENCIES),
        DECIDED: (*driver_features.ROUTE_FOOTPRINT, intent_features.TOLD_DECISIONS),
        PLACEBO: (*driver_features.ROUTE_FOOTPRINT, intent_features.PLACEBO),
        MEMORY: (*driver_features.ROUTE_FOOTPRINT, LAST_SEEN),
        AWARE: (*driver_features.ROUTE_FOOTPRINT, LAST_SEEN, HIDDEN_SIDES, NEXT_CROSSWALK),
        X_RAY: driver_features.ROUTE_FOOTPRINT,
        "surroundings": SURROUNDINGS,
        CORRIDOR: ON_CORRIDOR,
        PRIVILEGED: (*driver_features.ON_ROUTE, driver_features.FUTURE_CLEARANCES, driver_features.LIMITS),
    },
    "pedestrian": {"paper": pedestrian_features.PAPER, "kerb": pedestrian_features.KERB},
}
"""The named observation sets of each role."""


@dataclass(frozen=True)
class Observation:
    """A named observation set of a role, as a view. Raise ValueError for an unknown role or name."""

    role: str
    name: str

    def __post_init__(self) -> None:
        """Refuse a set that doesn't exist."""
        _check(self.role, self.name)

    def __call__(self, moment: Moment) -> Float[Array, "feature ..."]:
        """Return the features, ``(feature, *agents, *batch)``."""
        features = OBSERVATIONS[self.role][self.name]
        if self.name in SEEING_THROUGH:
            moment = unhidden(moment)
        return joined([row for feature in features for row in feature.compute(moment)])


def part(role: str, name: str, which: str) -> slice:
    """Return the position of a feature in an observation set. Raise KeyError if it has no feature of that name."""
    begin = 0
    for feature in OBSERVATIONS[role][name]:
        if feature.name == which:
            return slice(begin, begin + feature.size)
        begin += feature.size
    raise KeyError(which)


def size(role: str, name: str) -> int:
    """Return how many numbers an observation set has. Raise KeyError for one that doesn't exist."""
    return sum(feature.size for feature in OBSERVATIONS[role][name])


def bounds(world: World, role: str, name: str) -> tuple[Float[np.ndarray, " feature"], Float[np.ndarray, " feature"]]:
    """Return the lowest and highest values of an observation set, from the map and the rules.

    Raise ValueError for an unknown set.
    """
    _check(role, name)
    limits, rows = Limits.of(world), list[Bound]()
    for feature in OBSERVATIONS[role][name]:
        pattern = feature.bounds(limits)
        rows += list(pattern) * (feature.size // len(pattern))
    low, high = np.array(rows, np.float32).T
    return low - np.float32(ROUNDING), high + np.float32(ROUNDING)


def global_state(moment: Moment) -> Float[Array, "feature *batch"]:
    """Return what the paper's critic sees (section III-B): 4 numbers a pedestrian and 10, so 58 for 12 people."""
    world, scenario, state = moment.world, moment.scenario, moment.state
    car, people = state.vehicle, state.pedestrian
    vx, vy = pedestrian.velocity(world, scenario, people)
    goal_x, goal_y = vehicle.goal(world, scenario)
    return joined([
        *on_map(moment, people.x, people.y), distance(vx, vy) / 2, scenario.jaywalking_tendency(world),
        *on_map(moment, car.x, car.y), car.cos, car.sin, car.speed / SPEED, car.steering / world.rules.max_steering,
        *on_map(moment, goal_x, goal_y), distance(goal_x - car.x, goal_y - car.y) / DISTANCE,
        1 - state.step / world.rules.horizon,
    ])  # fmt: skip


def _check(role: str, name: str) -> None:
    """Raise ValueError for a role or a set that doesn't exist."""
    if role not in OBSERVATIONS:
        raise ValueError(f"no role '{role}'; there are: {', '.join(OBSERVATIONS)}")
    if name not in OBSERVATIONS[role]:
        known = ", ".join(OBSERVATIONS[role])
        raise ValueError(f"no observation set '{name}' for the {role}; there are: {known}")
