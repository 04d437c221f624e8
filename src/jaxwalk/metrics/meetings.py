"""Measure the car's speed in encounters by distance, and compare encounters that are alike otherwise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from jaxtyping import Float, Int

from jaxwalk.metrics.crossings import ROAD, TYPES, RoadSteps
from jaxwalk.metrics.encounters import encounter_starts
from jaxwalk.metrics.metric import MetricTable, Rows
from jaxwalk.metrics.statistics import Estimate, episode_draws, interval, ratio
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.trajectory import Trajectory

BIN_WIDTH = 3.0
"""Width of a distance bin [m]."""
BINS = 4
"""Number of distance bins: [0, 3), [3, 6), [6, 9) and [9, 12) m."""
PLACE = 5.0
"""Cars count as at the same place within a square of this side [m], if they head for the same compass quarter ..."""
SPEED_STEP = 1.0
"""... and if their initial speeds are equal within this [m/s]."""


@dataclass(frozen=True)
class Meetings:
    """One row per encounter and distance bin in which it has a frame."""

    episode: Int[np.ndarray, "meeting"]
    """Row of the episode."""
    type: Int[np.ndarray, "meeting"]
    """CROSSWALK or JAYWALK."""
    bin: Int[np.ndarray, "meeting"]
    """Index of the distance bin; 0 is the nearest."""
    speed: Float[np.ndarray, "meeting"]
    """Mean speed of the car over the encounter's frames in the bin [m/s]."""
    initial_speed: Float[np.ndarray, "meeting"]
    """Speed of the car in the encounter's first frame [m/s]."""
    x: Float[np.ndarray, "meeting"]
    """Position of the car in the encounter's first frame in the bin [m] ..."""
    y: Float[np.ndarray, "meeting"]
    cos: Float[np.ndarray, "meeting"]
    """... and its heading there, as cosine and sine."""
    sin: Float[np.ndarray, "meeting"]


def distance_bin(distance: np.ndarray) -> Int[np.ndarray, "..."]:
    """Return the bin of each distance; distances are below the last edge."""
    return (distance // BIN_WIDTH).astype(np.int64)


def nearest_of_type(steps: RoadSteps, frames: int, episodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the distance to the nearest pedestrian of each type on a roadway [m], and each step's index in it.

    The distances are flat ``(type, episode, frame)``; they are infinite where there is no such pedestrian.
    """
    cell = ((steps.type - 1).astype(np.int64) * episodes + steps.episode) * frames + steps.frame
    nearest = np.full(len(TYPES) * episodes * frames, np.inf)
    np.minimum.at(nearest, cell, steps.distance)
    return nearest, cell


def find_meetings(trajectory: Trajectory, steps: RoadSteps) -> Meetings:
    """Find all meetings of a trajectory.

    An encounter has the frames from its start on in which its pedestrian is the nearest of its type (ties included).
    """
    nearest, cell = nearest_of_type(steps, *trajectory.car_x.shape)
    start = encounter_starts(steps)
    chosen = (steps.distance < BINS * BIN_WIDTH) & (steps.distance == nearest[cell])
    rows = np.flatnonzero(chosen & (steps.frame >= start[steps.crossing]))
    group = steps.crossing[rows] * BINS + distance_bin(steps.distance[rows])
    group, first, which, count = np.unique(group, return_index=True, return_inverse=True, return_counts=True)
    speed = np.bincount(which, weights=steps.car_speed[rows], minlength=len(group)) / count
    row = rows[first]  # rows are ordered by frame within a crossing
    episode, frame = steps.episode[row], steps.frame[row]
    there = frame, episode
    return Meetings(
        episode=episode.astype(np.int32),
        type=steps.type[row],
        bin=(group % BINS).astype(np.int8),
        speed=speed.astype(np.float64),
        initial_speed=trajectory.car_speed[start[steps.crossing[row]], episode].astype(np.float32),
        x=trajectory.car_x[there].astype(np.float32),
        y=trajectory.car_y[there].astype(np.float32),
        cos=trajectory.car_cos[there].astype(np.float32),
        sin=trajectory.car_sin[there].astype(np.float32),
    )


def meeting_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return, per episode, type and bin, the number of encounters and the sum of their mean speeds [m/s]."""
    table = rows[MEETINGS]
    cell = (table.episode.astype(np.int64) * len(TYPES) + table.type - 1) * BINS + table.bin
    shape = rows.episodes, len(TYPES), BINS
    count = np.bincount(cell, minlength=int(np.prod(shape)))
    total = np.bincount(cell, weights=table.speed, minlength=int(np.prod(shape)))
    return {"meetings": count.reshape(shape), "meeting_speed": total.reshape(shape)}


def matched_differences(rows: Rows, *, resamples: int, seed: int) -> tuple[Estimate, ...]:
    """Return, for every bin, the mean speed near jaywalkers minus near crosswalk users, between similar cars [m/s].

    The two means are subtracted within a stratum (same place, heading and initial speed). The average over strata has
    the weights n m / (n + m) for n encounters with jaywalkers and m with crosswalk users (Cochran 1954; Mantel and
    Haenszel 1959), so a stratum without one of them has no weight. Each count is the number of jaywalker encounters
    with a match.
    """
    table = rows[MEETINGS]
    stratum, of_bin = _strata(table)
    jaywalk = table.type == JAYWALK
    both = np.isin(np.arange(len(of_bin)), stratum[jaywalk]) & np.isin(np.arange(len(of_bin)), stratum[~jaywalk])
    kept, of_bin = both[stratum], of_bin[both]
    cell = (np.cumsum(both) - 1)[stratum[kept]] * len(TYPES) + table.type[kept] - 1
    place, shape = (table.episode[kept], cell), (rows.episodes, len(of_bin) * len(TYPES))
    count = _resampled(np.ones(len(cell)), place, shape, resamples, seed)
    speed = _resampled(table.speed[kept], place, shape, resamples, seed)
    weight = np.nan_to_num(ratio(count.prod(axis=2), count.sum(axis=2)))
    mean = ratio(speed, count)
    terms = np.where(weight > 0, weight * (mean[..., JAYWALK - 1] - mean[..., CROSSWALK - 1]), 0)
    found = [(of_bin == i, (table.bin[kept] == i) & jaywalk[kept]) for i in range(BINS)]
    return tuple(
        interval(ratio(terms[:, mine].sum(axis=1), weight[:, mine].sum(axis=1)), int(rows.sum()))
        for mine, rows in found
    )


def _strata(table: Meetings) -> tuple[Int[np.ndarray, "meeting"], Int[np.ndarray, "stratum"]]:
    """Return the stratum of each meeting, and the bin of each stratum."""
    # (rounding, unlike floor, treats the four directions alike)
    place = (np.rint(table.x / PLACE), np.rint(table.y / PLACE))
    quarter = np.where(np.abs(table.cos) >= np.abs(table.sin), np.sign(table.cos), 2 * np.sign(table.sin))
    speed = np.floor(table.initial_speed / SPEED_STEP)
    code = np.zeros(len(table.bin), np.int64)
    for column in (table.bin, *place, quarter, speed):
        values = column.astype(np.int64)
        values -= values.min(initial=0)
        code = code * (values.max(initial=0) + 1) + values
    _, first, stratum = np.unique(code, return_index=True, return_inverse=True)
    return stratum, table.bin[first]


def _resampled(
    values: Float[np.ndarray, "meeting"],
    place: tuple[np.ndarray, np.ndarray],
    shape: tuple[int, int],
    resamples: int,
    seed: int,
) -> Float[np.ndarray, "draw cell type"]:
    """Return sums of the values at places (episode, cell): over all episodes (row 0), and over resampled episodes."""
    columns = scipy.sparse.csr_array((values, place), shape=shape)
    sums = np.zeros((1 + resamples, shape[1]))
    for some, times in episode_draws(shape[0], resamples=resamples, seed=seed):
        sums += times @ columns[some]
    return sums.reshape(1 + resamples, -1, len(TYPES))


MEETINGS = MetricTable(
    name="meetings", measure=lambda recording: find_meetings(recording.trajectory, recording[ROAD][1]), needs=(ROAD,)
)
