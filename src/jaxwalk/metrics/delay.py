"""Measure how much later cars arrive than they would with nobody to wait for: among those that arrive.

The mean time to goal compares survivors: a car that collides on long routes has a short mean. A delay is the difference
to the unhindered time on the same scenario, so it compares like with like.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from jaxwalk.metrics.metric import Metric, Recording, Rows, Sums
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.metrics.statistics import Estimate, interval, quantile, ratio
from jaxwalk.metrics.values import without_nan


@dataclass(frozen=True)
class Unhindered:
    """One row per episode. A recording doesn't know these times: evaluations add them."""

    time: Float[np.ndarray, "episode"]
    """Time to the goal at full throttle with nobody to touch [s]; NaN if unknown, or if that car doesn't arrive."""


@dataclass(frozen=True)
class Delay:
    """Seconds beyond full throttle on the same route without people, over scenarios in which both arrive."""

    mean: Estimate
    """The count is the number of those scenarios, here and below."""
    long: Estimate
    """95th percentile [s]."""


def delays(rows: Rows) -> Float[np.ndarray, "episode"]:
    """Return each episode's delay [s]; NaN if it doesn't reach the goal, or its unhindered time is unknown."""
    table = rows[OUTCOMES]
    return np.where(table.goal, table.steps * rows.dt - rows[DELAY].time, np.nan)


def delay_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return the delays that exist, and which do."""
    found = delays(rows)
    return {"delay": np.nan_to_num(found), "arrived": ~np.isnan(found)}


def summarise_delay(rows: Rows, sums: Sums) -> Delay:
    """Return the mean delay, and a long one."""
    own = sums[DELAY]
    mean = interval(ratio(own["delay"], own["arrived"]), own["arrived"][0])
    return Delay(mean=mean, long=quantile(rows.values(lambda chunk: without_nan(delays(chunk))), 0.95))


def _measure(recording: Recording) -> Unhindered:
    return Unhindered(np.full(len(recording.trajectory.length), np.nan, np.float32))


DELAY = Metric(name="delay", measure=_measure, needs=(OUTCOMES,), columns=delay_columns, summarise=summarise_delay)
