"""Measure how much faster the car drives near jaywalkers than near crosswalk users (paper, equation 2), four ways.

The difference is pooled over frames as in the paper, weighted by encounter, matched on place and initial speed
(`metrics.meetings`), and compared with the difference near ghosts, which the car cannot see. A difference that is as
large near ghosts may come from the place alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from jaxwalk.metrics.crossings import ROAD, TYPES, RoadSteps, find_crossings, real_frames
from jaxwalk.metrics.footprint import in_car_frame, near_car
from jaxwalk.metrics.meetings import (
    BIN_WIDTH,
    BINS,
    MEETINGS,
    distance_bin,
    matched_differences,
    meeting_columns,
    nearest_of_type,
)
from jaxwalk.metrics.metric import Metric, MetricTable, Rows, Sums
from jaxwalk.metrics.statistics import Estimate, interval, ratio
from jaxwalk.sim import events
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Ghosts, Trajectory


@dataclass(frozen=True)
class NearSpeeds:
    """One row per episode: the car's speed while the nearest pedestrian of a type on a roadway is in a distance bin."""

    speed_sum: Float[np.ndarray, "episode type bin"]
    """Sum over frames [m/s]."""
    frames: Int[np.ndarray, "episode type bin"]


@dataclass(frozen=True)
class PlaceboSpeeds:
    """Near speeds of people and of ghosts up to the first touch of either kind: one row per episode."""

    speed_sum: Float[np.ndarray, "episode type bin"]
    """Near people, sum over frames [m/s]."""
    frames: Int[np.ndarray, "episode type bin"]
    ghost_speed_sum: Float[np.ndarray, "episode type bin"]
    """Near ghosts [m/s]."""
    ghost_frames: Int[np.ndarray, "episode type bin"]


@dataclass(frozen=True)
class SpeedGap:
    """Mean car speeds in one bin; each count is the number of frames, or of encounters where they are the unit."""

    crosswalk: Estimate
    """Near crosswalk users [m/s]."""
    jaywalk: Estimate
    """Near jaywalkers [m/s]."""
    difference: Estimate
    """Jaywalk minus crosswalk [m/s]; the count is the smaller of the two."""


@dataclass(frozen=True)
class Placebo:
    """The speed differential near people and near ghosts, over frames up to the first touch of either kind."""

    people: SpeedGap
    ghosts: SpeedGap
    difference: Estimate
    """The differential near people minus that near ghosts [m/s]: among always-go, 0 for a car that does not see people.
    The count is the smaller of the two."""


@dataclass(frozen=True)
class SpeedBin:
    """The speed differential at one distance."""

    near: float
    """The bin holds distances from this value [m] ..."""
    far: float
    """... to below this value [m]."""
    pooled: SpeedGap
    """Every frame has the same weight, as in equation 2: long encounters with a slow car dominate."""
    by_encounter: SpeedGap
    """Every encounter has the same weight."""
    matched: Estimate
    """Jaywalk minus crosswalk among encounters of cars at the same place with the same initial speed [m/s]; the count
    is the number of jaywalker encounters with a match."""
    placebo: Placebo
    """The comparison with ghosts; all values are None without ghosts."""


def measure_near_speeds(trajectory: Trajectory, steps: RoadSteps) -> NearSpeeds:
    """Measure the car's speed per frame and type; the nearest pedestrian of the type on a roadway gives the bin.

    Steps after the trajectory's ``length`` are ignored.
    """
    frames, episodes = trajectory.car_x.shape
    nearest, _ = nearest_of_type(steps, frames, episodes)
    nearest = nearest.reshape(len(TYPES), episodes, frames)
    kind, episode, frame = np.nonzero((nearest < BINS * BIN_WIDTH) & real_frames(trajectory).T)
    group = (episode * len(TYPES) + kind) * BINS + distance_bin(nearest[kind, episode, frame])
    speed = trajectory.car_speed[frame, episode].astype(np.float64)
    shape = (episodes, len(TYPES), BINS)
    size = int(np.prod(shape))
    count = np.bincount(group, minlength=size).astype(np.int32)
    total = np.bincount(group, weights=speed, minlength=size).astype(np.float64)  # (NumPy returns integers for no rows)
    return NearSpeeds(total.reshape(shape), count.reshape(shape))


def measure_placebo(
    trajectory: Trajectory, steps: RoadSteps, ghosts: Ghosts | None, config: SimConfig
) -> PlaceboSpeeds:
    """Measure near speeds of people and of ghosts, up to the first frame in which the car touches either.

    An episode ends when the car touches a person, but the car would drive through a ghost. Both are cut at the first
    touch of either, so that both are observed equally long. For a car that ignores people, among people who always
    go, people and ghosts are then exchangeable: every difference between them is chance. Without ghosts, all values are
    0. The rules say what a touch is.
    """
    if ghosts is None:
        none = np.zeros((len(trajectory.length), len(TYPES), BINS))
        return PlaceboSpeeds(none, none.astype(np.int32), none, none.astype(np.int32))
    haunted = replace(trajectory, **vars(ghosts))
    near = frame, episode, _ = near_car(haunted, config)
    touched = events.touching(config, *in_car_frame(haunted, *near), 1.0, 0.0)
    length = trajectory.length.copy()
    np.minimum.at(length, episode[touched], frame[touched])
    shortened = replace(trajectory, length=length)
    people, unseen = (measure_near_speeds(shortened, on_road) for on_road in (steps, find_crossings(haunted)[1]))
    return PlaceboSpeeds(people.speed_sum, people.frames, unseen.speed_sum, unseen.frames)


def speed_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return the sums of speeds and their counts, each of shape (episode, type, bin)."""
    table, placebo = rows[SPEED_DIFFERENTIAL], rows[PLACEBO]
    return {
        "speed_sum": table.speed_sum,
        "speed_frames": table.frames,
        "people_speed": placebo.speed_sum,
        "people_frames": placebo.frames,
        "ghost_speed": placebo.ghost_speed_sum,
        "ghost_frames": placebo.ghost_frames,
    } | meeting_columns(rows)


def summarise_speeds(rows: Rows, sums: Sums) -> tuple[SpeedBin, ...]:
    """Return the speed differential in every bin."""
    own, matched = sums[SPEED_DIFFERENTIAL], matched_differences(rows, resamples=sums.resamples, seed=sums.seed)
    return tuple(
        SpeedBin(
            near=i * BIN_WIDTH,
            far=(i + 1) * BIN_WIDTH,
            pooled=_gap(own["speed_sum"][..., i], own["speed_frames"][..., i]),
            by_encounter=_gap(own["meeting_speed"][..., i], own["meetings"][..., i]),
            matched=matched[i],
            placebo=_placebo({name: column[..., i] for name, column in own.items() if name in _PLACEBO}),
        )
        for i in range(BINS)
    )


def _placebo(sums: dict[str, np.ndarray]) -> Placebo:
    """Return the placebo of one bin, from resampled sums of shape (draw, type)."""
    people, ghosts = (sums["people_speed"], sums["people_frames"]), (sums["ghost_speed"], sums["ghost_frames"])
    fewest = min(people[1][0].min(), ghosts[1][0].min())
    return Placebo(_gap(*people), _gap(*ghosts), interval(_difference(*people) - _difference(*ghosts), fewest))


def _gap(total: Float[np.ndarray, "draw type"], count: Float[np.ndarray, "draw type"]) -> SpeedGap:
    """Return the mean speeds and their difference."""
    mean = ratio(total, count)
    return SpeedGap(
        crosswalk=interval(mean[:, CROSSWALK - 1], count[0, CROSSWALK - 1]),
        jaywalk=interval(mean[:, JAYWALK - 1], count[0, JAYWALK - 1]),
        difference=interval(_difference(total, count), count[0].min()),
    )


def _difference(total: Float[np.ndarray, "draw type"], count: Float[np.ndarray, "draw type"]) -> np.ndarray:
    """Return the mean near jaywalkers minus the mean near crosswalk users [m/s]."""
    mean = ratio(total, count)
    return mean[:, JAYWALK - 1] - mean[:, CROSSWALK - 1]


_PLACEBO = ("people_speed", "people_frames", "ghost_speed", "ghost_frames")

PLACEBO = MetricTable(
    name="placebo",
    measure=lambda recording: measure_placebo(
        recording.trajectory, recording[ROAD][1], recording.ghosts, recording.config
    ),
    needs=(ROAD,),
)
SPEED_DIFFERENTIAL = Metric(
    name="speed_differential",
    measure=lambda recording: measure_near_speeds(recording.trajectory, recording[ROAD][1]),
    needs=(ROAD, PLACEBO, MEETINGS),
    columns=speed_columns,
    summarise=summarise_speeds,
    headline=True,
)
