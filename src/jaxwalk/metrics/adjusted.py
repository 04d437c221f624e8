"""Compare two drivers as if both were equally quick: who hurries may touch more people, whatever it sees.

Each driver was trained with several prices of time, so that it hurries more or less, and with several seeds. Within the
trainings of one driver and seed a number, such as that of contacts, changes with the delay; the slope of that change,
common to both drivers, moves the difference between them to equal delay: an analysis of covariance (Fisher 1932).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from jaxwalk.metrics.over_seeds import FEWEST_SEEDS, crossed_mean


@dataclass(frozen=True)
class Adjusted:
    """A difference at equal delay."""

    value: float
    """Number of B minus that of A, at equal delay."""
    slope: float
    """Change of the number per second of delay, within the trainings of one driver and seed."""
    slopes: tuple[float, float]
    """The same of A's trainings alone, and of B's: they should be alike."""
    low: float | None
    high: float | None
    p: float | None
    """Two-sided p-value of the t-test that the difference is 0; like the interval None if there are too few seeds."""


def at_equal_delay(
    delay: Float[np.ndarray, "2 price seed scenario"], number: Float[np.ndarray, "2 price seed scenario"]
) -> Adjusted | None:
    """Return B's number minus A's at equal delay; None where a delay is unknown or no price changes it.

    The interval and the test are those of `jaxwalk.metrics.over_seeds.crossed_mean`, of what each seed and scenario
    adds to the difference to first order, through the means and through the slope.

    Args:
        delay: delay of each training of A and of B in each scenario [s].
        number: what is compared, of the same trainings in the same scenarios.
    """
    delays, numbers = delay.mean(axis=-1), number.mean(axis=-1)
    off = delays - delays.mean(axis=1, keepdims=True)
    spreads = (off**2).sum(axis=(1, 2))
    if not (np.isfinite(spreads).all() and (spreads > 0).all()):
        return None
    slopes = (off * numbers).sum(axis=(1, 2)) / spreads
    slope = float((slopes * spreads).sum() / spreads.sum())
    level = number - slope * delay
    later = float(delays[1].mean() - delays[0].mean())
    of_slope = delay.shape[2] * (off[..., None] * level).sum(axis=(0, 1)) / spreads.sum()
    parts = (level[1] - level[0]).mean(axis=0) - later * of_slope
    low, high, p = None, None, None
    if len(parts) >= FEWEST_SEEDS and (found := crossed_mean(parts)).error > 0:
        (low, high), p = found.ends(), found.p()
    return Adjusted(float(parts.mean()), slope, (float(slopes[0]), float(slopes[1])), low, high, p)
