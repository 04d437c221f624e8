"""Estimate how certain numbers are: intervals of means, ratios of sums, quantiles and waiting times.

Counts and shares of counts have their own (`metrics.counts`), and so do numbers over training seeds.

A number that does not exist (a division by zero, a median never reached) is None, never NaN: JSON has null.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import scipy
from jaxtyping import Bool, Float, Shaped

Key = TypeVar("Key", bound=Hashable)
RESAMPLES = 1000
"""Default number of bootstrap resamples."""
CHUNK = 2**14
"""Number of episodes resampled at once: with 1,000 resamples, 125 MiB."""
CONFIDENCE = 0.95
"""Level of all intervals."""


@dataclass(frozen=True)
class Rate:
    """A share of trials, with its interval; all None without trials."""

    value: float | None
    low: float | None
    high: float | None
    successes: int
    trials: int


@dataclass(frozen=True)
class Estimate:
    """A number with its interval."""

    value: float | None
    low: float | None
    """Lower end of the interval; None if there are too few data."""
    high: float | None
    count: int
    """Number of observations behind the number; its place in the summary says what they are."""


def episode_sums(
    columns: Mapping[Key, Shaped[np.ndarray, "episode ..."]], *, resamples: int = RESAMPLES, seed: int = 0
) -> dict[Key, Float[np.ndarray, "draw ..."]]:
    """Return every column summed over all episodes (row 0), and over episodes drawn with replacement (the other rows).

    All columns use the same draws, so numbers computed from the rows keep their dependence on each other. Episodes are
    the unit because steps, crossings and encounters of one episode are not independent. With fewer than two episodes
    the resamples are NaN.
    """
    episodes = len(next(iter(columns.values())))
    chunks = ({name: column[first : first + CHUNK] for name, column in columns.items()}
              for first in range(0, max(episodes, 1), CHUNK))  # fmt: skip
    return sums_over_chunks(chunks, episodes, resamples=resamples, seed=seed)


def sums_over_chunks(
    chunks: Iterable[Mapping[Key, Shaped[np.ndarray, "_ ..."]]],
    episodes: int,
    *,
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> dict[Key, Float[np.ndarray, "draw ..."]]:
    """Return what `episode_sums` returns, for columns in chunks of `CHUNK` episodes, the last one with the rest.

    Raise ValueError unless the chunks have that many episodes, and together ``episodes``.
    """
    shapes: dict[Key, tuple[int, ...]] = {}
    sums: Any = 0.0
    for columns, (_, times) in zip(chunks, episode_draws(episodes, resamples=resamples, seed=seed), strict=True):
        shapes = {name: np.shape(column)[1:] for name, column in columns.items()}
        flat = [columns[name].reshape(times.shape[1], math.prod(shape)) for name, shape in shapes.items()]
        sums = sums + times @ np.concatenate(flat, axis=1, dtype=np.float64)
    ends = np.cumsum([math.prod(shape) for shape in shapes.values()])[:-1]
    parts = np.split(sums, ends, axis=1)
    return {name: part.reshape(-1, *shape) for (name, shape), part in zip(shapes.items(), parts, strict=True)}


def episode_draws(
    episodes: int, *, resamples: int = RESAMPLES, seed: int = 0
) -> Iterator[tuple[slice, Float[np.ndarray, "draw episode"]]]:
    """Yield some episodes at a time, and how often each is in each sample: once in row 0, as drawn in the others.

    Memory is bounded, however many episodes there are: a sample's draws are first divided among parts of `CHUNK`
    episodes (a multinomial), then among the episodes of a part. This equals drawing from all episodes at once. With
    fewer than two episodes the drawn rows are NaN.
    """
    rng = np.random.default_rng(seed)
    parts = [slice(begin, min(begin + CHUNK, episodes)) for begin in range(0, max(episodes, 1), CHUNK)]
    shares = [(part.stop - part.start) / max(episodes, 1) for part in parts]
    drawn = rng.multinomial(episodes, shares, resamples) if len(parts) > 1 else np.full((resamples, 1), episodes)
    for part, draws in zip(parts, drawn.T, strict=True):
        times = np.ones((1 + resamples, part.stop - part.start))
        size = times.shape[1]
        for row, count in enumerate(draws, 1):
            times[row] = np.bincount(rng.integers(0, size, count), minlength=size) if episodes > 1 else np.nan
        yield part, times


def ratio(numerator: np.ndarray, denominator: np.ndarray) -> np.ndarray:
    """Return the elementwise quotient; NaN where the denominator is 0 or NaN, without a warning."""
    numerator, denominator = np.broadcast_arrays(np.asarray(numerator, float), np.asarray(denominator, float))
    return np.divide(numerator, denominator, out=np.full(numerator.shape, np.nan), where=denominator != 0)


def interval(statistic: Float[np.ndarray, "draw"], count: int | float, *, confidence: float = 0.95) -> Estimate:
    """Return the statistic (element 0) with the percentile interval of its resamples (the rest); NaN means undefined.

    If more resamples are undefined than a tail of the interval holds, both ends are None.
    """
    value, resampled = float(statistic[0]), np.asarray(statistic[1:])
    tail = (1 - confidence) / 2
    if not math.isfinite(value):
        return Estimate(None, None, None, int(count))
    defined = resampled[np.isfinite(resampled)]
    if len(defined) == 0 or len(defined) < (1 - tail) * len(resampled):
        return Estimate(value, None, None, int(count))
    low, high = np.quantile(defined, [tail, 1 - tail])
    return Estimate(value, float(low), float(high), int(count))


def bootstrap_by_episode(
    numerator: Shaped[np.ndarray, "episode"],
    denominator: Shaped[np.ndarray, "episode"],
    *,
    resamples: int = RESAMPLES,
    confidence: float = 0.95,
    seed: int = 0,
) -> Estimate:
    """Return the sum of numerators over the sum of denominators, with its percentile interval over resampled episodes.

    ``count`` is the number of episodes whose denominator is not zero.
    """
    sums = episode_sums({"over": numerator, "under": denominator}, resamples=resamples, seed=seed)
    count = int(np.count_nonzero(denominator))
    return interval(ratio(sums["over"], sums["under"]), count, confidence=confidence)


def mean_of(
    values: Shaped[np.ndarray, "observation"],
    *,
    within: tuple[float, float] = (-math.inf, math.inf),
    confidence: float = CONFIDENCE,
) -> Estimate:
    """Return the mean of independent values with its t-interval, cut at the limits ``within`` of what it can be.

    A single value, or equal ones, have no interval: their spread is unknown.
    """
    values = np.asarray(values, np.float64)
    if len(values) == 0:
        return Estimate(None, None, None, 0)
    value = float(values.mean())
    if np.ptp(values) == 0:
        return Estimate(value, None, None, len(values))
    error = float(values.std(ddof=1)) / math.sqrt(len(values))
    half = float(scipy.stats.t.ppf((1 + confidence) / 2, len(values) - 1)) * error
    return Estimate(value, max(value - half, within[0]), min(value + half, within[1]), len(values))


def quantile(values: Shaped[np.ndarray, "observation"], p: float, *, confidence: float = 0.95) -> Estimate:
    """Return a quantile (linear between order statistics), with the exact interval for independent values."""
    if len(values) == 0:
        return Estimate(None, None, None, 0)
    values = np.asarray(values, np.float64)
    # quantile_test tests against q; any q gives the same interval
    ends = scipy.stats.quantile_test(values, q=0, p=p).confidence_interval(confidence_level=confidence)
    return Estimate(float(np.quantile(values, p)), finite_or_none(ends.low), finite_or_none(ends.high), len(values))


def kaplan_meier_median(
    times: Shaped[np.ndarray, "subject"], observed: Bool[np.ndarray, "subject"], *, confidence: float = 0.95
) -> Estimate:
    """Return the first time by which half of the subjects had their event; None if the curve stays above one half.

    Args:
        times: when the event came, or when the subject was last observed without it.
        observed: whether the event came; else the time is right-censored.
        confidence: level of the interval: the times at which the log-log band of the curve falls to one half
            (Brookmeyer and Crowley, 1982); an end that is never reached is None.
    """
    times, observed = np.asarray(times, np.float64), np.asarray(observed, bool)
    if not observed.any():
        return Estimate(None, None, None, len(times))
    curve: Any = scipy.stats.ecdf(scipy.stats.CensoredData.right_censored(times, ~observed)).sf
    value = _comes_down(curve.quantiles, curve.probabilities)
    low, high = _band(times, observed, curve.quantiles, curve.probabilities, confidence)
    return Estimate(value, _comes_down(curve.quantiles, low), _comes_down(curve.quantiles, high), len(times))


def _band(times, observed, at, survival, confidence) -> tuple[np.ndarray, np.ndarray]:
    """Return Greenwood's log-log band of a survival curve at sorted times ``at``; its upper edge is NaN at 0 and 1."""
    # the same as scipy's ecdf().sf.confidence_interval, which warns wherever the curve is 0 or 1
    at_risk = len(times) - np.searchsorted(np.sort(times), at, side="left")
    ordered = np.sort(times[observed])
    events = np.searchsorted(ordered, at, side="right") - np.searchsorted(ordered, at, side="left")
    inside = (survival > 0) & (survival < 1)
    terms = np.nan_to_num(ratio(events, at_risk * (at_risk - events)))
    log_survival = np.log(survival, out=np.full(len(at), -1.0), where=inside)
    width = scipy.stats.norm.ppf((1 + confidence) / 2) * np.sqrt(np.cumsum(terms)) / -log_survival
    low = np.where(inside, survival ** np.exp(width), survival)
    high = np.where(inside, survival ** np.exp(-width), np.nan)
    return low, high


def _comes_down(times: np.ndarray, survival: np.ndarray) -> float | None:
    """Return the first time at which a survival curve is at one half or below."""
    below = np.flatnonzero(survival <= 0.5)
    return float(times[below[0]]) if len(below) else None


def finite_or_none(number: float) -> float | None:
    """Return the number, or None if it is infinite or NaN."""
    return float(number) if math.isfinite(number) else None
