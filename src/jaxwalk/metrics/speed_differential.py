"""How much faster the car drives near jaywalkers than near crosswalk users (paper, equation 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from jaxwalk.metrics.crossings import TYPES, RoadSteps
from jaxwalk.metrics.encounters import encounter_starts
from jaxwalk.metrics.statistics import Estimate, interval, ratio
from jaxwalk.sim.trajectory import CROSSWALK, JAYWALK, Trajectory

BIN_WIDTH = 3.0
"""[m]"""
BINS = 4
"""[0, 3), [3, 6), [6, 9) and [9, 12) m."""


@dataclass(frozen=True)
class NearSpeeds:
    """One row per episode: the car's speed while the nearest pedestrian of a type on a roadway is in a distance bin."""

    speed_sum: Float[np.ndarray, "episode type bin"]
    """Sum over frames [m/s]."""
    frames: Int[np.ndarray, "episode type bin"]
    encounter_speed_sum: Float[np.ndarray, "episode type bin"]
    """Sum over encounters of the mean over the encounter's frames in the bin [m/s]."""
    encounters: Int[np.ndarray, "episode type bin"]
    """Encounters with a frame in the bin."""


@dataclass(frozen=True)
class SpeedGap:
    """Mean car speeds in one bin; each count is of frames, or of encounters where they are the unit."""

    crosswalk: Estimate
    """Near crosswalk users [m/s]."""
    jaywalk: Estimate
    """Near jaywalkers [m/s]."""
    difference: Estimate
    """Jaywalk minus crosswalk [m/s]; the count is the smaller of the two."""


@dataclass(frozen=True)
class SpeedBin:
    """The speed differential at one distance."""

    near: float
    """The bin holds distances from this [m] ..."""
    far: float
    """... to below this [m]."""
    pooled: SpeedGap
    """Every frame weighs the same, as in equation 2: long encounters with a slow car dominate."""
    by_encounter: SpeedGap
    """Every encounter weighs the same."""


def measure_near_speeds(trajectory: Trajectory, steps: RoadSteps) -> NearSpeeds:
    """Per frame and type, the nearest pedestrian of the type on a roadway gives the bin of the car's speed.

    An encounter has the frames from its start on in which its pedestrian is that nearest one (or as near).
    """
    frames, episodes = trajectory.car_x.shape
    cell = ((steps.type - 1).astype(np.int64) * episodes + steps.episode) * frames + steps.frame
    nearest = np.full(len(TYPES) * episodes * frames, np.inf)
    np.minimum.at(nearest, cell, steps.distance)

    close = np.flatnonzero(nearest < BINS * BIN_WIDTH)
    kind, rest = np.divmod(close, episodes * frames)
    episode, frame = np.divmod(rest, frames)
    group = (episode * len(TYPES) + kind) * BINS + _bin(nearest[close])
    speed = trajectory.car_speed[frame, episode].astype(np.float64)
    shape = (episodes, len(TYPES), BINS)
    count, total = _grouped(group, speed, shape)

    chosen = (steps.distance < BINS * BIN_WIDTH) & (steps.distance == nearest[cell])
    chosen &= steps.frame >= encounter_starts(steps)[steps.crossing]
    encounters, means = _encounter_means(steps, chosen, shape)
    return NearSpeeds(speed_sum=total, frames=count, encounter_speed_sum=means, encounters=encounters)


def _encounter_means(steps: RoadSteps, chosen: np.ndarray, shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Encounters per (episode, type, bin), and the sum of their mean speeds [m/s], over the chosen steps."""
    per_crossing = (len(steps.first), BINS)
    group = steps.crossing[chosen] * BINS + _bin(steps.distance[chosen])
    count, total = _grouped(group, steps.car_speed[chosen], per_crossing)
    crossing, place = np.nonzero(count)
    row = steps.first[crossing]
    target = (steps.episode[row] * len(TYPES) + steps.type[row] - 1) * BINS + place
    return _grouped(target, total[crossing, place] / count[crossing, place], shape)


def _bin(distance: np.ndarray) -> np.ndarray:
    """Which bin a distance below the last edge falls into."""
    return (distance // BIN_WIDTH).astype(np.int64)


def _grouped(group: np.ndarray, values: np.ndarray, shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """How many rows each group has, and the sum of their values; groups number the cells of ``shape``."""
    size = int(np.prod(shape))
    count = np.bincount(group, minlength=size).astype(np.int32)
    total = np.bincount(group, weights=values, minlength=size).astype(np.float64)  # (NumPy sums no rows to integers)
    return count.reshape(shape), total.reshape(shape)


def speed_columns(table: NearSpeeds) -> dict[str, np.ndarray]:
    """The sums and counts to be resampled, each (episode, type, bin)."""
    return {
        "speed_sum": table.speed_sum,
        "speed_frames": table.frames,
        "encounter_speed_sum": table.encounter_speed_sum,
        "speed_encounters": table.encounters,
    }


def summarise_speeds(sums: dict[str, np.ndarray]) -> tuple[SpeedBin, ...]:
    """The speed differential in every bin; ``sums`` are the resampled sums of ``speed_columns``."""
    pooled = _gaps(sums["speed_sum"], sums["speed_frames"])
    by_encounter = _gaps(sums["encounter_speed_sum"], sums["speed_encounters"])
    edges = BIN_WIDTH * np.arange(BINS + 1)
    return tuple(
        SpeedBin(near=float(edges[i]), far=float(edges[i + 1]), pooled=pooled[i], by_encounter=by_encounter[i])
        for i in range(BINS)
    )


def _gaps(total: np.ndarray, count: np.ndarray) -> list[SpeedGap]:
    """A gap for each bin, of resampled sums (resample, type, bin)."""
    mean = ratio(total, count)
    crosswalk, jaywalk = mean[:, CROSSWALK - 1], mean[:, JAYWALK - 1]
    return [
        SpeedGap(
            crosswalk=interval(crosswalk[:, i], count[0, CROSSWALK - 1, i]),
            jaywalk=interval(jaywalk[:, i], count[0, JAYWALK - 1, i]),
            difference=interval(jaywalk[:, i] - crosswalk[:, i], count[0, :, i].min()),
        )
        for i in range(BINS)
    ]
