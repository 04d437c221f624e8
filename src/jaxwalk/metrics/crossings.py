"""Find who is on a roadway when: the crossings of a trajectory, and every step that a pedestrian spends on one.

People are on sidewalks most of the time, so all computations about crossings use these rows only.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from jaxwalk.metrics.metric import Finding, MetricTable
from jaxwalk.sim import events
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK, NO_CROSSING
from jaxwalk.sim.trajectory import Trajectory

T = TypeVar("T")
TYPES = (CROSSWALK, JAYWALK)
"""The types of a crossing. An axis named ``type`` has them in this order: index = type - 1."""


@dataclass(frozen=True)
class ByType(Generic[T]):
    """One value for each type of crossing."""

    crosswalk: T
    jaywalk: T


@dataclass(frozen=True)
class Crossings:
    """One row per crossing: an unbroken stay of a pedestrian on a roadway, ordered by episode, pedestrian and time."""

    episode: Int[np.ndarray, "crossing"]
    """Row of the episode."""
    ped: Int[np.ndarray, "crossing"]
    number: Int[np.ndarray, "crossing"]
    """1 for the pedestrian's first crossing of the episode."""
    type: Int[np.ndarray, "crossing"]
    """CROSSWALK or JAYWALK."""
    enter: Int[np.ndarray, "crossing"]
    """First frame on the roadway."""
    last: Int[np.ndarray, "crossing"]
    """Last frame on the roadway."""
    entry_seen: Bool[np.ndarray, "crossing"]
    """The pedestrian entered after frame 0, not before the episode began."""
    completed: Bool[np.ndarray, "crossing"]
    """The pedestrian left the roadway before the episode ended."""


@dataclass(frozen=True)
class RoadSteps:
    """One row per real frame and pedestrian on a roadway, ordered by episode, pedestrian and frame."""

    episode: Int[np.ndarray, "step"]
    ped: Int[np.ndarray, "step"]
    frame: Int[np.ndarray, "step"]
    crossing: Int[np.ndarray, "step"]
    """Row of the crossing that the step belongs to."""
    first: Int[np.ndarray, "crossing"]
    """For each crossing, its first row here (for ``ufunc.reduceat``)."""
    type: Int[np.ndarray, "step"]
    distance: Float[np.ndarray, "step"]
    """Between the centres of car and pedestrian [m]."""
    closing: Bool[np.ndarray, "step"]
    """``events.closes_in``: the car is within 20 m and closing."""
    car_speed: Float[np.ndarray, "step"]
    """[m/s]"""


def real_frames(trajectory: Trajectory) -> Bool[np.ndarray, "frame episode"]:
    """Return which frames are not padding: frames 0 to ``length``."""
    return np.arange(len(trajectory.car_x))[:, None] <= trajectory.length


def rows_of(chosen: Bool[np.ndarray, "frame episode ped"]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frame, episode and pedestrian wherever it is true, ordered by episode, pedestrian and frame."""
    # (only few places are true: to sort those is cheaper than to turn the whole array round)
    frames, episodes, people = chosen.shape
    frame, walk = np.divmod(np.flatnonzero(chosen), episodes * people)
    walk, frame = np.divmod(np.sort(walk * frames + frame), frames)
    return frame, *np.divmod(walk, people)


def crossing_type(decided: np.ndarray, on_crosswalk: np.ndarray) -> np.ndarray:
    """Return CROSSWALK or JAYWALK for people on a roadway: their decision, or the place if they never decided."""
    # (somebody may never have decided: who begins the episode on a roadway, or comes from a foreign recording)
    return np.where(decided == NO_CROSSING, np.where(on_crosswalk, CROSSWALK, JAYWALK), decided).astype(np.int8)


def find_crossings(trajectory: Trajectory) -> tuple[Crossings, RoadSteps]:
    """Find all crossings of a trajectory, and all their steps."""
    on_road = trajectory.on_roadway & real_frames(trajectory)[..., None]
    frame, episode, ped = rows_of(on_road)
    first, crossing = runs(episode, ped, frame)
    last = np.append(first[1:], len(frame))[: len(first)] - 1
    begin = frame[first], episode[first], ped[first]
    crossings = Crossings(
        episode=episode[first].astype(np.int32),
        ped=ped[first].astype(np.int16),
        number=_numbers(episode[first], ped[first]),
        type=crossing_type(trajectory.crossing[begin], trajectory.on_crosswalk[begin]),
        enter=frame[first].astype(np.int32),
        last=frame[last].astype(np.int32),
        entry_seen=frame[first] > 0,
        completed=frame[last] < trajectory.length[episode[first]],
    )
    distance, closing = _approach(trajectory, episode, ped, frame)
    steps = RoadSteps(
        episode=episode,
        ped=ped,
        frame=frame,
        crossing=crossing,
        first=first,
        type=crossings.type[crossing],
        distance=distance,
        closing=closing,
        car_speed=trajectory.car_speed[frame, episode].astype(np.float64),
    )
    return crossings, steps


def runs(episode: np.ndarray, ped: np.ndarray, frame: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows at which unbroken stays begin, and the stay that each row belongs to."""
    begins = np.ones(len(frame), bool)
    begins[1:] = (np.diff(frame) != 1) | (np.diff(ped) != 0) | (np.diff(episode) != 0)
    return np.flatnonzero(begins), np.cumsum(begins) - 1


def _numbers(episode: np.ndarray, ped: np.ndarray) -> np.ndarray:
    """Number rows 1, 2, ... within each (episode, pedestrian); rows are ordered by both."""
    row = np.arange(len(ped))
    new = np.ones(len(ped), bool)
    new[1:] = (np.diff(ped) != 0) | (np.diff(episode) != 0)
    return (row - np.maximum.accumulate(np.where(new, row, 0)) + 1).astype(np.int16)


def _approach(trajectory, episode, ped, frame) -> tuple[np.ndarray, np.ndarray]:
    """Return the distance between car and pedestrian [m] and ``events.closes_in``, for the given rows."""
    car, person = (frame, episode), (frame, episode, ped)
    speed = trajectory.car_speed[car].astype(np.float64)
    dx = trajectory.ped_x[person].astype(np.float64) - trajectory.car_x[car]
    dy = trajectory.ped_y[person].astype(np.float64) - trajectory.car_y[car]
    dvx = trajectory.ped_vx[person] - speed * trajectory.car_cos[car]
    dvy = trajectory.ped_vy[person] - speed * trajectory.car_sin[car]
    return events.distance(dx, dy), events.closes_in(dx, dy, dvx, dvy)


def count_by_type(
    episode: Int[np.ndarray, "row"], kind: Int[np.ndarray, "row"], episodes: int, weights: np.ndarray | None = None
) -> Shaped[np.ndarray, "episode type"]:
    """Return how many rows each episode has of each type of crossing, or the sum of their weights."""
    cell = episode.astype(np.int64) * len(TYPES) + kind - 1
    return np.bincount(cell, weights, minlength=episodes * len(TYPES)).reshape(episodes, len(TYPES))


ROAD = Finding(name="road", measure=lambda recording: find_crossings(recording.trajectory))
"""Crossings, and every step of them."""
CROSSINGS = MetricTable(name="crossings", measure=lambda recording: recording[ROAD][0], needs=(ROAD,))
