"""Krippendorff's alpha, which says how far raters agree beyond chance.

Krippendorff (2011), *Computing Krippendorff's alpha-reliability*.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

Difference = Callable[[np.ndarray, np.ndarray], np.ndarray]


def interval(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the squared difference of values."""
    return (a - b) ** 2


def nominal(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return 1 where values differ, and 0 elsewhere."""
    return (a != b).astype(float)


def alpha(
    ratings: Float[np.ndarray, "rater unit"], difference: Difference = interval, weights: np.ndarray | None = None
) -> float:
    """Return alpha; 1 is agreement, 0 what chance would give, NaN if there is nothing to compare or nothing varies.

    Args:
        ratings: each rater's value of each unit, NaN where there is none.
        difference: squared differences of two arrays of values.
        weights: how often each unit counts (default: once), as in a bootstrap over units.
    """
    values = np.unique(ratings[~np.isnan(ratings)])
    counts = (ratings[:, :, None] == values).sum(axis=0).astype(float)  # (unit, value)
    each = counts.sum(axis=1)
    paired = each > 1
    times = np.ones(len(each)) if weights is None else np.asarray(weights, np.float64)
    counts, each, times = counts[paired], each[paired], times[paired]
    apart = difference(values[:, None], values[None, :])
    within = np.einsum("uc,uk,ck->u", counts, counts, apart) / (each - 1)
    totals = times @ counts
    expected = totals @ apart @ totals
    if not expected > 0:
        return float("nan")
    return float(1 - (totals.sum() - 1) * (times @ within) / expected)


def with_mirrored(ratings: Float[np.ndarray, "rater unit"]) -> Float[np.ndarray, "rater twice"]:
    """Return the units and their mirror images: which of two clips comes first is arbitrary, and must not matter."""
    return np.concatenate([ratings, -ratings], axis=1)
