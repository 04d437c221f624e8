"""Measure whether people wait at the kerb: before a car they would walk into, before any other car, and what it costs.

Counted are kerb moments (`metrics.kerb`): a person who waits has many. `metrics.approaches` counts each person once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.metrics.counts import clustered_share
from jaxwalk.metrics.crossings import real_frames, rows_of, runs
from jaxwalk.metrics.kerb import DANGER, HARMLESS, KERB, NEAR, OTHER, SETTINGS, Kerb
from jaxwalk.metrics.metric import Metric, Rows, Sums, episodes_with
from jaxwalk.metrics.statistics import Estimate, interval, ratio
from jaxwalk.sim import events
from jaxwalk.sim.trajectory import Trajectory

DISTANCES = (0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, NEAR)
"""Edges of the distance bins [m]; each holds its lower edge."""
SPEEDS = (0.0, 2.0, 4.0, 6.0, 8.33)
"""Edges of the speed bins [m/s]; the last also holds anything faster."""
MISSES = (0.0, 1.0, 2.5, 5.0)
"""Lower edges of the bins of the predicted miss [m]; the last has no end."""


@dataclass(frozen=True)
class KerbMoments:
    """Kerb moments, and how many of them were waited through, by the car's position and motion: one row per episode."""

    moments: Int[np.ndarray, "episode setting"]
    waits: Int[np.ndarray, "episode setting"]
    distance_moments: Int[np.ndarray, "episode distance miss"]
    """Moments with the pedestrian ahead of the car and within 40 m."""
    distance_waits: Int[np.ndarray, "episode distance miss"]
    speed_moments: Int[np.ndarray, "episode speed miss"]
    """The same moments by the car's speed."""
    speed_waits: Int[np.ndarray, "episode speed miss"]
    walked: Float[np.ndarray, "episode"]
    """Distance walked by all pedestrians together [m]."""
    ped_steps: Int[np.ndarray, "episode"]
    """Steps played, times the number of pedestrians."""
    ped_waits: Int[np.ndarray, "episode"]
    """How many of those steps were waits, at any place."""
    longest_stand: Int[np.ndarray, "episode"]
    """The longest time that anybody stood still on a roadway, in consecutive steps."""


@dataclass(frozen=True)
class WaitBin:
    """Wait rates in one bin of the car's distance or speed; each count is of kerb moments."""

    begin: float
    """The bin holds values from this [m or m/s] ..."""
    end: float
    """... to below this."""
    rates: tuple[Estimate, ...]
    """By predicted miss: [0, 1), [1, 2.5), [2.5, 5) m, and 5 m or more."""


@dataclass(frozen=True)
class Waiting:
    """Shares of kerb moments that were waited through (each count is of moments), and the cost of waiting."""

    danger: Estimate
    """Moments with the car within 40 m and faster than 2 m/s, the pedestrian ahead, predicted miss below 2.5 m."""
    harmless: Estimate
    """Moments with the car 40 m away or more, or more than 2.5 m past."""
    other: Estimate
    by_distance: tuple[WaitBin, ...]
    """Moments with the pedestrian ahead of the car and within 40 m."""
    by_speed: tuple[WaitBin, ...]
    """The same moments by the car's speed."""
    pace: Estimate
    """Distance walked per second of pedestrians' lifetime [m/s]; the count is in metres."""
    waited: Estimate
    """Share of all pedestrians' steps that were waits, at any place; the count is the number of steps."""
    longest_stand: int
    """The longest time that anybody stood still on a roadway, in consecutive steps."""


def measure_waiting(trajectory: Trajectory, kerb: Kerb) -> KerbMoments:
    """Count the kerb moments of each episode."""
    episodes, people = len(trajectory.length), trajectory.ped_x.shape[2]
    played = real_frames(trajectory)[1:, :, None]
    moments, waits = _tally(kerb.waited, (kerb.episode, kerb.setting), (episodes, len(SETTINGS)))

    close = (kerb.distance < NEAR) & (kerb.ahead > 0)
    columns = (kerb.waited, kerb.episode, kerb.distance, kerb.speed, kerb.miss)
    waited, episode, distance, speed, miss = (x[close] for x in columns)
    gap = _bin(miss, MISSES)
    by_distance, by_speed = (
        _tally(waited, (episode, _bin(values, edges[:-1]), gap), (episodes, len(edges) - 1, len(MISSES)))
        for values, edges in ((distance, DISTANCES), (speed, SPEEDS))
    )
    return KerbMoments(
        moments=moments,
        waits=waits,
        distance_moments=by_distance[0],
        distance_waits=by_distance[1],
        speed_moments=by_speed[0],
        speed_waits=by_speed[1],
        walked=_walked(trajectory, played),
        ped_steps=(trajectory.length * people).astype(np.int32),
        ped_waits=(~trajectory.going[1:] & played).sum(axis=(0, 2)).astype(np.int32),
        longest_stand=_longest_stand(trajectory),
    )


def _bin(values: np.ndarray, edges: tuple[float, ...]) -> Int[np.ndarray, "row"]:
    """Return the index of the last lower edge that each value reaches."""
    return np.digitize(values, edges) - 1


def _tally(
    waited: Bool[np.ndarray, "row"], cell: tuple[np.ndarray, ...], shape: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Count the moments in each cell of ``shape``, and how many of them were waited through."""
    flat, size = np.ravel_multi_index(cell, shape), math.prod(shape)
    moments, waits = (np.bincount(rows, minlength=size).reshape(shape) for rows in (flat, flat[waited]))
    return moments.astype(np.int32), waits.astype(np.int32)


def _walked(trajectory: Trajectory, played: Bool[np.ndarray, "step episode 1"]) -> Float[np.ndarray, "episode"]:
    """Return the distance that all pedestrians together walked [m]."""
    speed = events.distance(trajectory.ped_vx[1:], trajectory.ped_vy[1:])
    return np.where(played, speed, 0).sum(axis=(0, 2), dtype=np.float64) * trajectory.dt


def _longest_stand(trajectory: Trajectory) -> Int[np.ndarray, "episode"]:
    """Return the longest time that anybody stood still on a roadway, in consecutive steps."""
    stood = trajectory.on_roadway & ~trajectory.going & real_frames(trajectory)[..., None]
    frame, episode, ped = rows_of(stood)
    first, _ = runs(episode, ped, frame)
    longest = np.zeros(len(trajectory.length), np.int32)
    np.maximum.at(longest, episode[first], np.diff(first, append=len(frame)))
    return longest


def waiting_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return the counts of `KerbMoments`, and the total lifetime of all pedestrians [s]."""
    table = rows[WAITING]
    names = ("moments", "waits", "distance_moments", "distance_waits", "speed_moments", "speed_waits")
    people = {"walked": table.walked, "ped_steps": table.ped_steps, "ped_time": table.ped_steps * rows.dt}
    return {name: getattr(table, name) for name in names} | people | {"ped_waits": table.ped_waits}


def summarise_waiting(rows: Rows, sums: Sums) -> Waiting:
    """Return wait rates and the cost of waiting."""
    own, episodes = sums[WAITING], episodes_with(rows, waiting_columns)
    by_setting = _rates(own["waits"], own["moments"], episodes["moments"])
    steps = own["ped_steps"]
    return Waiting(
        danger=by_setting[DANGER],
        harmless=by_setting[HARMLESS],
        other=by_setting[OTHER],
        by_distance=_bins(DISTANCES, own["distance_waits"], own["distance_moments"], episodes["distance_moments"]),
        by_speed=_bins(SPEEDS, own["speed_waits"], own["speed_moments"], episodes["speed_moments"]),
        pace=interval(ratio(own["walked"], own["ped_time"]), own["walked"][0]),
        waited=clustered_share(ratio(own["ped_waits"], steps), steps[0], episodes["ped_steps"]),
        longest_stand=max(int(chunk[WAITING].longest_stand.max(initial=0)) for chunk in rows.chunks()),
    )


def _rates(
    waits: Float[np.ndarray, "draw bin"], moments: Float[np.ndarray, "draw bin"], episodes: Int[np.ndarray, "bin"]
) -> tuple[Estimate, ...]:
    """Return the share of moments that were waited through, in each bin; ``episodes`` is how many have any."""
    return tuple(clustered_share(ratio(w, m), m[0], n) for w, m, n in zip(waits.T, moments.T, episodes, strict=True))


def _bins(
    edges: tuple[float, ...], waits: np.ndarray, moments: np.ndarray, episodes: np.ndarray
) -> tuple[WaitBin, ...]:
    """Return wait rates between consecutive edges, from resampled sums of shape (draw, bin, miss)."""
    return tuple(
        WaitBin(begin=edges[i], end=edges[i + 1], rates=_rates(waits[:, i], moments[:, i], episodes[i]))
        for i in range(len(edges) - 1)
    )


WAITING = Metric(
    name="waiting",
    measure=lambda recording: measure_waiting(recording.trajectory, recording[KERB]),
    needs=(KERB,),
    columns=waiting_columns,
    summarise=summarise_waiting,
)
