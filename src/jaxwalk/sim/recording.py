"""Record a moment: the columns of a `jaxwalk.sim.trajectory.Trajectory` that have a frame axis."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from jaxwalk.sim import pedestrian, prediction
from jaxwalk.sim.perceived import Perceived
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import PedestrianState, State
from jaxwalk.sim.world import World

Frame = dict[str, Array]
"""One frame of each column, by its name: arrays ``(*batch)`` or ``(ped, *batch)``."""


def frame(world: World, scenario: Scenario, state: State) -> Frame:
    """Return what a `Trajectory` records of a moment."""
    car, people = state.vehicle, state.pedestrian
    known = {} if state.perceived is None else _frame_of_sightings(state.perceived)
    return {
        "car_x": car.x,
        "car_y": car.y,
        "car_cos": car.cos,
        "car_sin": car.sin,
        "car_speed": car.speed,
        "car_acceleration": car.acceleration,
        **frame_of_people(world, scenario, people),
        "decisions": people.decisions.astype(jnp.int16),
        "at_kerb": pedestrian.at_kerb(world, people),
        "enters_roadway": pedestrian.enters_roadway(people),
        "going": people.going,
        "predicted_miss": prediction.predicted_miss(world, scenario, state)[0],
        **known,
    }


def _frame_of_sightings(known: Perceived) -> Frame:
    return {
        "perceived": known.now.seen,
        "last_seen_x": known.last.x,
        "last_seen_y": known.last.y,
        "last_seen_age": known.age,
    }


def parked_boxes(world: World, scenarios: Scenario) -> Float[np.ndarray, "episode slot column"] | None:
    """Return what a `Trajectory` records of parked vehicles; None where nobody ever parks."""
    found = []
    if scenarios.parked is not None:
        boxes = np.asarray(world.maps.slots)[np.asarray(scenarios.map)]
        found.append(np.where(np.asarray(scenarios.parked).T[..., None], boxes, np.float32("nan")))
    if scenarios.script is not None:
        boxes = np.moveaxis(np.asarray(scenarios.script.boxes), -1, 0)
        found.append(np.where(boxes[..., 4:5] > 0, boxes, np.float32("nan")))
    return np.concatenate(found, axis=1) if found else None


def frame_of_people(world: World, scenario: Scenario, people: PedestrianState) -> Frame:
    """Return what `Ghosts` record of a moment: where people are, how they move, and how they cross."""
    velocity_x, velocity_y = pedestrian.velocity(world, scenario, people)
    return {
        "ped_x": people.x,
        "ped_y": people.y,
        "ped_vx": velocity_x,
        "ped_vy": velocity_y,
        "on_roadway": people.on_roadway,
        "on_crosswalk": people.on_crosswalk,
        "crossing": people.crossing.astype(jnp.int8),
    }
