"""Measure how fast the car passes people on a roadway, by how near it comes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from jaxwalk.metrics.crossings import ROAD, RoadSteps
from jaxwalk.metrics.encounters import ENCOUNTERS, ROAD_GAPS, Encounters, encounter_starts
from jaxwalk.metrics.metric import Metric, Rows, Sums
from jaxwalk.metrics.statistics import Estimate, interval, ratio

CLEARANCES = (0.0, 0.5, 1.0, 2.0, 5.0)
"""Edges of the bins of the smallest gap between the car's rectangle and the body [m]; each holds its lower edge."""


@dataclass(frozen=True)
class Passings:
    """One row per encounter, parallel to `Encounters`."""

    episode: Int[np.ndarray, "encounter"]
    """Row of the episode."""
    speed: Float[np.ndarray, "encounter"]
    """Speed of the car in the first frame of the smallest gap [m/s]."""


@dataclass(frozen=True)
class PassingSpeed:
    """The car's mean speed when it was nearest, in encounters without a touch."""

    near: float
    """The bin holds smallest gaps from this value [m] ..."""
    far: float
    """... to below this value [m]."""
    speed: Estimate
    """[m/s]; the count is of encounters."""


def measure_passings(encounters: Encounters, steps: RoadSteps, gaps: Float[np.ndarray, "step"]) -> Passings:
    """Return the car's speed where it was nearest, for each encounter."""
    start = encounter_starts(steps)
    gap = np.where(steps.frame >= start[steps.crossing], gaps, np.inf)
    nearest = np.minimum.reduceat(gap, steps.first)
    row, rows = np.arange(len(gap)), len(gap)
    first = np.where(gap == nearest[steps.crossing], row, rows)
    chosen = np.minimum.reduceat(first, steps.first)[np.isfinite(nearest)]
    return Passings(encounters.episode, steps.car_speed[chosen].astype(np.float32))


def passing_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return the encounters without a touch and the sum of the car's speeds, each of shape (episode, bin)."""
    met, table = rows[ENCOUNTERS], rows[PASSING]
    bins = len(CLEARANCES) - 1
    which = np.digitize(met.min_gap, CLEARANCES) - 1
    kept = ~met.collided & (met.min_gap > 0) & (which < bins)
    cell, shape = table.episode[kept].astype(np.int64) * bins + which[kept], (rows.episodes, bins)
    weights = (None, table.speed[kept])
    count, total = (np.bincount(cell, w, minlength=rows.episodes * bins).reshape(shape) for w in weights)
    return {"passed": count, "speed": total}


def summarise_passing(rows: Rows, sums: Sums) -> tuple[PassingSpeed, ...]:
    """Return the passing speed in each bin of clearance."""
    own = sums[PASSING]
    speeds = ratio(own["speed"], own["passed"]).T
    return tuple(
        PassingSpeed(near, far, interval(speed, count))
        for near, far, speed, count in zip(CLEARANCES[:-1], CLEARANCES[1:], speeds, own["passed"][0], strict=True)
    )


PASSING = Metric(
    name="passing",
    measure=lambda recording: measure_passings(recording[ENCOUNTERS], recording[ROAD][1], recording[ROAD_GAPS]),
    needs=(ROAD, ROAD_GAPS, ENCOUNTERS),
    columns=passing_columns,
    summarise=summarise_passing,
)
