"""Measure the car's speed in encounters by distance, and compare encounters that are alike otherwise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from jaxtyping import Float, Int

from jaxwalk.metrics.crossings import ROAD, TYPES, RoadSteps
from jaxwalk.metrics.encounters import encounter_starts
from jaxwalk.metrics.metric import MetricTable, Rows
from jaxwalk.metrics.statistics import Estimate, episode_slices, interval, ratio, resampled_sums
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

AT_ONCE = 2048
"""Number of strata that are resampled at once: with 1,000 resamples, 64 MiB."""


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
    ends = _ends(rows)
    codes, of_bin = _matched(rows, ends)
    over, under, met = np.zeros((BINS, 1 + resamples)), np.zeros((BINS, 1 + resamples)), np.zeros(BINS)
    for first in range(0, len(codes), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        parts = _meetings_by_stratum(rows, ends, codes[some])
        sums = resampled_sums(parts, rows.episodes, resamples=resamples, seed=seed)
        count, speed = np.moveaxis(sums.reshape(1 + resamples, 2, -1, len(TYPES)), 1, 0)
        weight = np.nan_to_num(ratio(count.prod(axis=2), count.sum(axis=2)))
        mean = ratio(speed, count)
        terms = np.where(weight > 0, weight * (mean[..., JAYWALK - 1] - mean[..., CROSSWALK - 1]), 0)
        here = np.equal.outer(np.arange(BINS), of_bin[some])
        over += here @ terms.T
        under += here @ weight.T
        met += here @ count[0, :, JAYWALK - 1]
    return tuple(interval(ratio(*both), int(count)) for *both, count in zip(over, under, met, strict=True))


def _kinds(table: Meetings) -> Int[np.ndarray, "5 meeting"]:
    """Return what makes the stratum of each meeting: its bin, place (2), quarter of heading and step of speed."""
    # (rounding, unlike floor, treats the four directions alike)
    place = (np.rint(table.x / PLACE), np.rint(table.y / PLACE))
    quarter = np.where(np.abs(table.cos) >= np.abs(table.sin), np.sign(table.cos), 2 * np.sign(table.sin))
    speed = np.floor(table.initial_speed / SPEED_STEP)
    return np.stack([table.bin, *place, quarter, speed]).astype(np.int64)


def _ends(rows: Rows) -> Int[np.ndarray, "5 2"]:
    """Return the smallest of each number of `_kinds`, and how many numbers there are from it to the largest."""
    low, high = np.zeros(5, np.int64), np.zeros(5, np.int64)
    for chunk in rows.chunks():
        kinds = _kinds(chunk[MEETINGS])
        low, high = np.minimum(low, kinds.min(axis=1, initial=0)), np.maximum(high, kinds.max(axis=1, initial=0))
    return np.stack([low, high - low + 1], axis=1)


def _codes(table: Meetings, ends: Int[np.ndarray, "5 2"]) -> Int[np.ndarray, "meeting"]:
    """Return a number for the stratum of each meeting, those of a bin one after the other."""
    code = np.zeros(len(table.bin), np.int64)
    for kind, (low, size) in zip(_kinds(table), ends, strict=True):
        code = code * size + kind - low
    return code


def _matched(rows: Rows, ends: Int[np.ndarray, "5 2"]) -> tuple[Int[np.ndarray, "stratum"], Int[np.ndarray, "stratum"]]:
    """Return the codes of the strata with meetings of both types, and their bins."""
    seen = {kind: np.zeros(0, np.int64) for kind in TYPES}
    for chunk in rows.chunks():
        codes = _codes(chunk[MEETINGS], ends)
        seen = {kind: np.union1d(found, codes[chunk[MEETINGS].type == kind]) for kind, found in seen.items()}
    both = np.intersect1d(seen[CROSSWALK], seen[JAYWALK])
    return both, both // ends[1:, 1].prod() + ends[0, 0]


def _meetings_by_stratum(rows: Rows, ends: Int[np.ndarray, "5 2"], codes: Int[np.ndarray, "stratum"]) -> Iterator[Any]:
    """Yield the meetings of some episodes in each of the strata by type, and then the sums of their speeds, sparse."""
    for chunk in rows.chunks():
        table = chunk[MEETINGS]
        found = _codes(table, ends)
        kept = np.isin(found, codes)
        cell = np.searchsorted(codes, found[kept]) * len(TYPES) + table.type[kept] - 1
        place, shape = (table.episode[kept], cell), (chunk.episodes, len(codes) * len(TYPES))
        both = [scipy.sparse.csr_array((x, place), shape=shape) for x in (np.ones(len(cell)), table.speed[kept])]
        matrix = scipy.sparse.hstack(both, format="csr")
        yield from (matrix[some] for some in episode_slices(chunk.episodes))


MEETINGS = MetricTable(
    name="meetings", measure=lambda recording: find_meetings(recording.trajectory, recording[ROAD][1]), needs=(ROAD,)
)
