"""Tests of paired outcomes of two policies, and of several tests at once."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy
from jaxtyping import Bool

from jaxwalk.metrics.statistics import CONFIDENCE, Estimate


def mcnemar(a: Bool[np.ndarray, "trial"], b: Bool[np.ndarray, "trial"]) -> float:
    """Return the exact two-sided p-value for equal rates of two yes-no outcomes of the same trials (1 if all agree).

    Trials are independent: scenarios of one pair of policies, not those of several training seeds.
    """
    return mcnemar_of_counts(*_discordant(a, b))


def mcnemar_of_counts(only_a: int, only_b: int) -> float:
    """Return the p-value of `mcnemar` from the trials in which only A, and only B, said yes."""
    if only_a + only_b == 0:
        return 1.0
    return float(scipy.stats.binomtest(only_a, only_a + only_b, 0.5).pvalue)


def paired_difference(
    a: Bool[np.ndarray, "trial"], b: Bool[np.ndarray, "trial"], *, confidence: float = CONFIDENCE
) -> Estimate:
    """Return the share in B minus the share in A of the same independent trials, with Bonett and Price's interval.

    One trial is added to either kind of disagreement (Bonett and Price, 2012), so the interval has a width also where
    all agree. ``count`` is the number of trials, at least one.
    """
    only_a, only_b = _discordant(a, b)
    trials = len(a)
    more, less = (only_b + 1) / (trials + 2), (only_a + 1) / (trials + 2)
    z = float(scipy.stats.norm.ppf((1 + confidence) / 2))
    half = z * math.sqrt((more + less - (more - less) ** 2) / (trials + 2))
    low, high = max(more - less - half, -1.0), min(more - less + half, 1.0)
    return Estimate((only_b - only_a) / trials, low, high, trials)


def _discordant(a: np.ndarray, b: np.ndarray) -> tuple[int, int]:
    """Return how many trials succeed in A alone, and in B alone."""
    a, b = np.asarray(a, bool), np.asarray(b, bool)
    if a.shape != b.shape:
        raise ValueError(f"paired outcomes need equal lengths, not {a.shape} and {b.shape}")
    return int((a & ~b).sum()), int((b & ~a).sum())


SURE = 0.05
"""A difference with a smaller p-value, adjusted for all tests of one answer (`holm`), is called one."""


def holm(p: Sequence[float]) -> tuple[float, ...]:
    """Return the adjusted p-values of a family of tests, in the same order (Holm, 1979).

    With probability at least 1 - alpha, every true null hypothesis has an adjusted p-value above alpha.
    """
    order = np.argsort(p, kind="stable")
    worse = np.maximum.accumulate(np.asarray(p, np.float64)[order] * np.arange(len(p), 0, -1))
    adjusted = np.empty(len(p))
    adjusted[order] = np.minimum(worse, 1)
    return tuple(adjusted.tolist())
