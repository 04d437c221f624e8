"""The simulator's output: episodes as plain arrays in the order time, episode, pedestrian.

A column's annotation declares its axes, and `AXES` is read from it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeVar, get_args, get_type_hints

import equinox as eqx
import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from jaxwalk.maps.parking_slots import SLOT_COLUMNS


class Walks(eqx.Module):
    """How people walk, frame by frame."""

    ped_x: Float[np.ndarray, "frame episode ped"]
    """Position [m]."""
    ped_y: Float[np.ndarray, "frame episode ped"]
    ped_vx: Float[np.ndarray, "frame episode ped"]
    """Velocity [m/s], along the leg that is being walked; 0 after a step of waiting."""
    ped_vy: Float[np.ndarray, "frame episode ped"]
    on_roadway: Bool[np.ndarray, "frame episode ped"]
    """Whether the pedestrian is between the kerbs, on a crosswalk or off it."""
    on_crosswalk: Bool[np.ndarray, "frame episode ped"]
    """Inside a crosswalk's rectangle."""
    crossing: Int[np.ndarray, "frame episode ped"]
    """The `jaxwalk.sim.crossing_kind.CrossingKind` decided for the next or current crossing."""


class Ghosts(Walks):
    """People that no car can see or touch, recorded beside a `Trajectory` in its frames and episodes."""


class Trajectory(Walks):
    """Recorded episodes. Frame 0 is the start, frame k the world after k steps; frames after ``length`` are padding."""

    dt: float = eqx.field(static=True)
    """Duration of a step [s]."""
    scenario: Int[np.ndarray, "episode"]
    """Which scenario of the set each episode played."""
    length: Int[np.ndarray, "episode"]
    """Steps played; the last real frame."""
    goal: Bool[np.ndarray, "episode"]
    """The episode ended with the car at its goal."""
    collision: Bool[np.ndarray, "episode"]
    """The episode ended with a collision. Neither goal nor collision: a timeout."""
    touched: Bool[np.ndarray, "episode ped"]
    """The pedestrians that the car hit, in the last frame."""

    goal_x: Float[np.ndarray, "episode"]
    """Position of the car's goal [m]."""
    goal_y: Float[np.ndarray, "episode"]
    car_x: Float[np.ndarray, "frame episode"]
    """Centre of the car [m]."""
    car_y: Float[np.ndarray, "frame episode"]
    car_cos: Float[np.ndarray, "frame episode"]
    """Heading of the car, as its cosine and sine."""
    car_sin: Float[np.ndarray, "frame episode"]
    car_speed: Float[np.ndarray, "frame episode"]
    """Speed of the car [m/s]."""
    car_acceleration: Float[np.ndarray, "frame episode"]
    """Acceleration commanded in the step that led to the frame [m/s2]; 0 in frame 0."""

    jaywalking_tendency: Float[np.ndarray, "episode ped"]
    """The trait tau in [0, 1]."""
    decisions: Int[np.ndarray, "frame episode ped"]
    """How many crossings the pedestrian has decided about so far."""
    at_kerb: Bool[np.ndarray, "frame episode ped"]
    """Whether the pedestrian is on a sidewalk, about to enter a roadway (within ``kerb_distance`` of walking)."""
    enters_roadway: Bool[np.ndarray, "frame episode ped"]
    """Whether the current leg leads into a roadway, so that the pedestrian doesn't turn before it."""
    going: Bool[np.ndarray, "frame episode ped"]
    """The go (true) or wait output in the step that led to the frame; true in frame 0."""
    predicted_miss: Float[np.ndarray, "frame episode ped"]
    """How close the centres would come if the pedestrian went on now and the car kept its velocity [m]."""

    parked: Float[np.ndarray, "episode slot column"] | None = None
    """The boxes of parked vehicles (`jaxwalk.maps.parking_slots.SLOT_COLUMNS`); NaN for a slot that is free. None where
    nobody ever parks."""
    perceived: Bool[np.ndarray, "frame episode ped"] | None = None
    """Whether what the car knows of the pedestrian is of this moment (with a delay, of the newest that can be known);
    this and what follows is None in a world without perception."""
    last_seen_x: Float[np.ndarray, "frame episode ped"] | None = None
    """Where the car last perceived the pedestrian [m]; 0 if never."""
    last_seen_y: Float[np.ndarray, "frame episode ped"] | None = None
    last_seen_age: Float[np.ndarray, "frame episode ped"] | None = None
    """How long ago that was [s]. After `jaxwalk.sim.perceived.KEPT` the car has forgotten it."""

    shield_changed: Bool[np.ndarray, "frame episode"] | None = None
    """Whether a shield changed the driver's action in the step that led to the frame; this and the next is None where
    the driver has no shield."""
    shield_infeasible: Bool[np.ndarray, "frame episode"] | None = None
    """Whether nothing that the shield could do then was safe by its rule."""

    def parked_in(self, episode: int) -> Float[np.ndarray, "vehicle column"]:
        """Return the boxes of the vehicles that are parked in an episode."""
        if self.parked is None:
            return np.zeros((0, len(SLOT_COLUMNS)))
        boxes = self.parked[episode]
        return boxes[~np.isnan(boxes[:, 0])]


Recorded = TypeVar("Recorded", bound=Walks)

AXES: dict[str, tuple[str, ...]] = {
    name: tuple(array.dim_str.split())
    for name, hint in get_type_hints(Trajectory).items()
    for array in (hint, *get_args(hint))
    if hasattr(array, "dim_str")
}
"""The axes of each column of a `Trajectory` (and of `Ghosts`), by its name."""


def without_episodes() -> Trajectory:
    """Return a recording of no episodes, in which one person would be for one frame."""
    sizes, kinds = {"frame": 1, "episode": 0, "ped": 1}, (np.bool_, np.int32, np.float32)
    columns = {}
    for name, hint in get_type_hints(Trajectory).items():
        if hasattr(hint, "dim_str"):
            kind = next(kind for kind in kinds if np.dtype(kind).name in hint.dtypes)
            columns[name] = np.zeros([sizes[axis] for axis in AXES[name]], kind)
    return Trajectory(dt=0.1, **columns)


def part_of(recorded: Recorded, *, frames: int, episodes: slice) -> Recorded:
    """Return the first frames of some episodes of a recording."""
    which = {"frame": slice(frames), "episode": episodes}
    columns = {name: x for name, x in vars(recorded).items() if name in AXES and x is not None}
    parts = {name: x[tuple(which.get(axis, slice(None)) for axis in AXES[name])] for name, x in columns.items()}
    return replace(recorded, **parts)


def with_people(recorded: Recorded, who: Bool[np.ndarray, "ped"]) -> Recorded:
    """Return a recording of some of the people, in their order."""
    columns = {name: x for name, x in vars(recorded).items() if "ped" in AXES.get(name, ()) and x is not None}
    return replace(recorded, **{name: x[..., who] for name, x in columns.items()})


def in_order(columns: Mapping[str, Shaped[np.ndarray, "..."]]) -> dict[str, Any]:
    """Return columns as a `Trajectory` has them, from arrays whose axes end in ``(..., ped, episode)``."""
    return {name: x.swapaxes(-1, -2) if "ped" in AXES[name] else x for name, x in columns.items()}
