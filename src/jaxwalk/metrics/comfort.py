"""Measure how harshly the car drives: hard braking, and jerk."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float, Int

from jaxwalk.metrics.counts import clustered_rate, clustered_share
from jaxwalk.metrics.crossings import real_frames
from jaxwalk.metrics.metric import Metric, Rows, Sums, episodes_with
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.metrics.statistics import Estimate, interval, ratio
from jaxwalk.sim.trajectory import Trajectory

HARSH = -2.5
"""Braking is harsh if the commanded acceleration is at or below this [m/s2] while the car rolls."""


@dataclass(frozen=True)
class Harshness:
    """One row per episode."""

    steps: Int[np.ndarray, "episode"]
    """Steps played."""
    harsh: Int[np.ndarray, "episode"]
    """Steps of harsh braking."""
    events: Int[np.ndarray, "episode"]
    """Unbroken rows of such steps."""
    jerk_squared: Float[np.ndarray, "episode"]
    """Squared jerk, summed over the steps that have one [m2/s6]."""
    jerks: Int[np.ndarray, "episode"]
    """Steps that have one: all but the first."""


@dataclass(frozen=True)
class Comfort:
    """How harshly the car drives."""

    harsh: Estimate
    """Share of steps with harsh braking; the count is of steps."""
    harsh_per_km: Estimate
    """Times that harsh braking began, per kilometre driven; the count is of those."""
    jerk: Estimate
    """Root mean square of the change of the car's acceleration [m/s3]; the count is of steps."""


def measure_harshness(trajectory: Trajectory) -> Harshness:
    """Count harsh braking, and add up squared jerk."""
    played = real_frames(trajectory)[1:]
    harsh = (trajectory.car_acceleration[1:] <= HARSH) & (trajectory.car_speed[:-1] > 0) & played
    begins = harsh.copy()
    begins[1:] &= ~harsh[:-1]
    acceleration = np.diff(trajectory.car_speed.astype(np.float64), axis=0) / trajectory.dt
    jerk = np.where(played[1:], np.diff(acceleration, axis=0) / trajectory.dt, 0)
    return Harshness(
        steps=trajectory.length.astype(np.int32),
        harsh=harsh.sum(axis=0).astype(np.int32),
        events=begins.sum(axis=0).astype(np.int32),
        jerk_squared=(jerk**2).sum(axis=0),
        jerks=played[1:].sum(axis=0).astype(np.int32),
    )


def comfort_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return the columns of `Harshness`."""
    return {column.name: getattr(rows[COMFORT], column.name) for column in fields(Harshness)}


def summarise_comfort(rows: Rows, sums: Sums) -> Comfort:
    """Return how harshly the car drives."""
    own, km = sums[COMFORT], sums[OUTCOMES]["km"][0]
    episodes = episodes_with(rows, comfort_columns)["steps"]
    return Comfort(
        harsh=clustered_share(ratio(own["harsh"], own["steps"]), own["steps"][0], episodes),
        harsh_per_km=clustered_rate(own["events"], float(km)),
        jerk=interval(np.sqrt(ratio(own["jerk_squared"], own["jerks"])), own["jerks"][0]),
    )


COMFORT = Metric(
    name="comfort",
    measure=lambda recording: measure_harshness(recording.trajectory),
    needs=(OUTCOMES,),
    columns=comfort_columns,
    summarise=summarise_comfort,
)
