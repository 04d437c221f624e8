"""Compare two drivers as if both were equally quick: who hurries touches more people, whatever it sees.

Each driver was trained with several settings that make it hurry more or less, and with several seeds. Within the
trainings of one driver and seed, contacts change with the delay; the slope of that change, common to both drivers,
moves the difference between them to the delay at which they are equal: an analysis of covariance (Fisher 1932).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy import stats

from jaxwalk.metrics.over_seeds import FEWEST_SEEDS
from jaxwalk.metrics.statistics import CONFIDENCE


@dataclass(frozen=True)
class Adjusted:
    """A difference at equal delay."""

    value: float
    """Number of B minus that of A, at equal delay."""
    slope: float
    """Change of the number per second of delay, within the trainings of one driver and seed."""
    low: float | None
    high: float | None
    p: float | None
    """Two-sided p-value of the t-test that the difference is 0; like the interval None if there are too few seeds."""


def at_equal_delay(
    delay: Float[np.ndarray, "2 setting seed"], number: Float[np.ndarray, "2 setting seed"]
) -> Adjusted | None:
    """Return B's number minus A's at equal delay; None where a delay is unknown or no setting changes it.

    The interval and the test are Student's, with the jackknife's standard error over training seeds (Tukey 1958), which
    holds the uncertainty of the slope as well as of the means.

    Args:
        delay: mean delay of each training of A and of B [s].
        number: what is compared, of the same trainings.
    """
    value, slope = _difference(delay, number)
    seeds = delay.shape[-1]
    if not math.isfinite(value):
        return None
    if seeds < FEWEST_SEEDS:
        return Adjusted(value, slope, None, None, None)
    without = [_difference(np.delete(delay, i, -1), np.delete(number, i, -1))[0] for i in range(seeds)]
    error = (seeds - 1) * float(np.std(without, ddof=1)) / math.sqrt(seeds)
    if not error > 0:
        return Adjusted(value, slope, None, None, None)
    half = float(stats.t.ppf((1 + CONFIDENCE) / 2, seeds - 1)) * error
    return Adjusted(value, slope, value - half, value + half, float(2 * stats.t.sf(abs(value) / error, seeds - 1)))


def _difference(
    delay: Float[np.ndarray, "2 setting seed"], number: Float[np.ndarray, "2 setting seed"]
) -> tuple[float, float]:
    """Return the difference at equal delay, and the slope; NaN where there is none."""
    mean_delay, mean_number = delay.mean(axis=1, keepdims=True), number.mean(axis=1, keepdims=True)
    spread = float(((delay - mean_delay) ** 2).sum())
    if not spread > 0:
        return math.nan, math.nan
    slope = float(((delay - mean_delay) * (number - mean_number)).sum()) / spread
    adjusted = number.mean(axis=(1, 2)) - slope * delay.mean(axis=(1, 2))
    return float(adjusted[1] - adjusted[0]), slope
