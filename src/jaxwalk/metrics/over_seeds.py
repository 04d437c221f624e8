"""Numbers of policies that were trained with several seeds: what to expect of another training, on other scenarios."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
from jaxtyping import Float, Shaped

from jaxwalk.metrics.counts import proportion, rate
from jaxwalk.metrics.statistics import CONFIDENCE, Estimate, finite_or_none, ratio

FEWEST_SEEDS = 5
"""Fewer training seeds than this give no interval and no test: their spread is unknown."""
ROUNDING = 1e-12
"""Means that differ by less than this share of the largest value are equal: NumPy's variance of equal numbers
needn't be 0."""
Kind = Literal["share", "rate", "mean"]
"""What a number over seeds is: a share of trials; events per unit of exposure; or a mean or difference, of any sign."""


@dataclass(frozen=True)
class OverSeeds:
    """A number over several training seeds."""

    mean: Estimate
    """The count is the number of seeds."""
    iqm: float | None
    """Interquartile mean."""
    each: tuple[float | None, ...]
    """The number of each seed."""


@dataclass(frozen=True)
class CrossedMean:
    """A mean over training seeds, all of which played the same scenarios."""

    value: float
    error: float
    """Standard error for another training on other scenarios."""
    freedom: float
    """Degrees of freedom of the standard error: those of the seeds, or more where scenarios matter more than seeds."""

    def ends(self) -> tuple[float, float]:
        """Return the 95 % t-interval."""
        half = float(scipy.stats.t.ppf((1 + CONFIDENCE) / 2, self.freedom)) * self.error
        return self.value - half, self.value + half

    def p(self) -> float:
        """Return the two-sided p-value of the t-test that the mean is 0; the standard error must not be 0."""
        return float(2 * scipy.stats.t.sf(abs(self.value) / self.error, self.freedom))


def crossed_mean(values: Shaped[np.ndarray, "seed scenario"]) -> CrossedMean:
    """Return the mean of values of at least two seeds on the same scenarios, with its standard error.

    The values' own spread over seeds holds what a training and chance do to one scenario. What a scenario does to all
    seeds alike does not average out over seeds: its part of the variance is added. Both come from the two-way analysis
    of variance that radiology uses for several readers of the same cases (Obuchowski and Rockette 1995; degrees of
    freedom of Hillis 2007). Without anything common to the scenarios it is the t-interval over seeds.
    """
    values = np.asarray(values, np.float64)
    seeds, scenarios = values.shape
    largest = float(np.abs(values).max())
    of_seeds = scenarios * _variance(values.mean(axis=1), largest)
    if scenarios == 1:
        return CrossedMean(float(values.mean()), math.sqrt(of_seeds / seeds), float(seeds - 1))
    of_scenarios = seeds * _variance(values.mean(axis=0), largest)
    total = values.var() * values.size - (seeds - 1) * of_seeds - (scenarios - 1) * of_scenarios
    both = of_seeds + max(of_scenarios - total / ((seeds - 1) * (scenarios - 1)), 0) if of_seeds + of_scenarios else 0.0
    freedom = (seeds - 1) * (both / of_seeds) ** 2 if of_seeds > 0 else math.inf
    return CrossedMean(float(values.mean()), math.sqrt(both / values.size), freedom)


def _variance(means: Float[np.ndarray, "mean"], largest: float) -> float:
    return float(means.var(ddof=1)) if np.ptp(means) > ROUNDING * largest else 0.0


def crossed_ratio(over: Shaped[np.ndarray, "seed scenario"], under: Shaped[np.ndarray, "seed scenario"]) -> CrossedMean:
    """Return the mean over seeds of sum of numerators / sum of denominators, which varies as its linear part does."""
    return crossed_mean(linear_part(over, under))


def linear_part(
    over: Shaped[np.ndarray, "seed scenario"], under: Shaped[np.ndarray, "seed scenario"]
) -> Float[np.ndarray, "seed scenario"]:
    """Return what each scenario adds to its seed's ratio: their means are the ratios of the sums."""
    each = (over.sum(axis=1) / under.sum(axis=1))[:, None]
    return each + (over - each * under) / under.mean(axis=1, keepdims=True)


def over_seeds(
    numerator: Shaped[np.ndarray, "seed scenario"],
    denominator: Shaped[np.ndarray, "seed scenario"],
    *,
    kind: Kind = "mean",
) -> OverSeeds:
    """Return each training seed's sum of numerators over sum of denominators, their mean and interquartile mean.

    The interval is that of `crossed_mean`: of shares on the scale of log odds, of rates on that of logarithms, so that
    it stays where they can be, and misses on either side alike. There is none with fewer than `FEWEST_SEEDS` seeds. A
    ratio varies as its linear part does: numerator - ratio x denominator.

    Where nothing varies there is no spread to judge by. The interval is then that of one seed's scenarios: 0 of 2,000
    in each of five seeds is no proof that the share is 0, and if it is the scenario that decides, five seeds on 2,000
    scenarios are no more than 2,000 trials. A mean that does not vary has no interval.
    """
    over, under = np.asarray(numerator, np.float64), np.asarray(denominator, np.float64)
    each = ratio(over.sum(axis=1), under.sum(axis=1))
    seeds, mean = len(each), finite_or_none(each.mean())
    low, high = (None, None) if mean is None or seeds < FEWEST_SEEDS else _ends(over, under, kind)
    known = tuple(finite_or_none(value) for value in each)
    return OverSeeds(Estimate(mean, low, high, seeds), finite_or_none(float(interquartile_mean(each))), known)


def _ends(
    over: Float[np.ndarray, "seed scenario"], under: Float[np.ndarray, "seed scenario"], kind: Kind
) -> tuple[float | None, float | None]:
    """Return the interval of the mean of the seeds' ratios."""
    found = crossed_ratio(over, under)
    mean, (low, high) = found.value, found.ends()
    if kind == "mean":
        return (low, high) if found.error > 0 else (None, None)
    if found.error == 0:
        one = (proportion if kind == "share" else rate)(over[0].sum(), under[0].sum())
        return one.low, one.high
    if kind == "rate":
        half = (high - mean) / mean
        return mean * math.exp(-half), mean * math.exp(half)
    half, odds = (high - mean) / (mean * (1 - mean)), math.log(mean / (1 - mean))
    return float(scipy.special.expit(odds - half)), float(scipy.special.expit(odds + half))


def interquartile_mean(values: Float[np.ndarray, "*step seed"]) -> Float[np.ndarray, "*step"]:
    """Return the mean without the lowest and the highest quarter of the values (of fewer than four values: of all).

    The result is NaN if any value is. Agarwal et al. (2021), *Deep reinforcement learning at the edge of the
    statistical precipice*.
    """
    values = np.asarray(values, np.float64)
    mean = scipy.stats.trim_mean(values, 0.25, axis=-1)
    return np.where(np.isnan(values).any(axis=-1), np.nan, mean)  # an older SciPy treats NaN as the largest value
