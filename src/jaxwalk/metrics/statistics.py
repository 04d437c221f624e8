"""Estimate how certain numbers are: intervals of means, ratios of sums, quantiles and waiting times.

Counts and shares of counts have their own (`metrics.counts`), and so do numbers over training seeds.

A number that does not exist (a division by zero, a median never reached) is None, never NaN: JSON has null.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any, TypeVar

import numpy as np
import scipy
from jaxtyping import Bool, Float, Int, Shaped

from jaxwalk.metrics.values import Values

Key = TypeVar("Key", bound=Hashable)
RESAMPLES = 1000
"""Default number of bootstrap resamples."""
CHUNK = 2**14
"""Number of episodes resampled at once: with 1,000 resamples, 125 MiB. Parts keep as many in a row group, so another
number needs another ``FORMAT`` of `jaxwalk.evaluation.parts`."""
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
    return sums_over_chunks([columns], len(next(iter(columns.values()))), resamples=resamples, seed=seed)


def sums_over_chunks(
    chunks: Iterable[Mapping[Key, Shaped[np.ndarray, "_ ..."]]],
    episodes: int,
    *,
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> dict[Key, Float[np.ndarray, "draw ..."]]:
    """Return what `episode_sums` returns, for columns in chunks.

    Each chunk but the last has a multiple of `CHUNK` episodes.

    Raise ValueError unless the chunks have such numbers of episodes, and together ``episodes``.
    """
    shapes: dict[Key, tuple[int, ...]] = {}

    def matrices(columns: Mapping[Key, np.ndarray]) -> Iterator[Float[np.ndarray, "episode column"]]:
        shapes.update({name: column.shape[1:] for name, column in columns.items()})
        for some in episode_slices(max(map(len, columns.values()))):
            size = some.stop - some.start
            flat = [column[some].reshape(size, math.prod(column.shape[1:])) for column in columns.values()]
            yield np.concatenate(flat, axis=1, dtype=np.float64)

    flat = chain.from_iterable(map(matrices, chunks))
    sums = resampled_sums(flat, episodes, resamples=resamples, seed=seed)
    ends = np.cumsum([math.prod(shape) for shape in shapes.values()])[:-1]
    parts = np.split(sums, ends, axis=1)
    return {name: part.reshape(-1, *shape) for (name, shape), part in zip(shapes.items(), parts, strict=True)}


def resampled_sums(
    matrices: Iterable[Any], episodes: int, *, resamples: int = RESAMPLES, seed: int = 0
) -> Float[np.ndarray, "draw column"]:
    """Return the columns of matrices, dense or sparse, summed over all rows (row 0), and over rows drawn with
    replacement.

    Each matrix has a row for each episode of one of the `episode_slices`. Raise ValueError for others.
    """
    draws = episode_draws(episodes, resamples=resamples, seed=seed)
    sums: Any = 0.0
    for matrix, (_, times) in zip(matrices, draws, strict=True):
        sums = np.add(sums, found := times @ matrix, out=found)
    return sums


def episode_slices(episodes: int) -> list[slice]:
    """Return slices of `CHUNK` episodes, the last one with the rest; at least one."""
    return [slice(begin, min(begin + CHUNK, episodes)) for begin in range(0, max(episodes, 1), CHUNK)]


def episode_draws(
    episodes: int, *, resamples: int = RESAMPLES, seed: int = 0
) -> Iterator[tuple[slice, Float[np.ndarray, "draw episode"]]]:
    """Yield some episodes at a time, and how often each is in each sample: once in row 0, as drawn in the others.

    Memory is bounded, however many episodes there are: a sample's draws are first divided among parts of `CHUNK`
    episodes (a multinomial), then among the episodes of a part. This equals drawing from all episodes at once. With
    fewer than two episodes the drawn rows are NaN.
    """
    rng = np.random.default_rng(seed)
    parts = episode_slices(episodes)
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
    values: Shaped[np.ndarray, "observation"] | Values,
    *,
    within: tuple[float, float] = (-math.inf, math.inf),
    confidence: float = CONFIDENCE,
) -> Estimate:
    """Return the mean of independent values with its t-interval, cut at the limits ``within`` of what it can be.

    A single value, or equal ones, have no interval: their spread is unknown.
    """
    values = Values.of(values)
    count = values.count
    if count == 0:
        return Estimate(None, None, None, 0)
    value, (least, most) = values.sum() / count, values.ends()
    if least == most:
        return Estimate(least, None, None, count)
    error = standard_deviation(values, value) / math.sqrt(count)
    half = float(scipy.stats.t.ppf((1 + confidence) / 2, count - 1)) * error
    return Estimate(value, max(value - half, within[0]), min(value + half, within[1]), count)


def standard_deviation(values: Values, mean: float) -> float:
    """Return the sample standard deviation (n - 1) of at least two values with this mean."""
    return math.sqrt(values.each(lambda piece: (piece.astype(np.float64) - mean) ** 2).sum() / (values.count - 1))


def quantile(
    values: Shaped[np.ndarray, "observation"] | Values, p: float, *, confidence: float = CONFIDENCE
) -> Estimate:
    """Return a quantile (linear between order statistics), with the exact interval for independent values.

    The number of values below the quantile is binomial, so the ends of the interval are two order statistics.
    """
    values = Values.of(values)
    count = values.count
    if count == 0:
        return Estimate(None, None, None, 0)
    below = scipy.stats.binom(count, p)
    tail, at = (1 - confidence) / 2, (count - 1) * p
    first = math.floor(at)
    ranks = {"first": first, "second": min(first + 1, count - 1), "low": int(below.ppf(tail)) - 1,
             "high": int(below.isf(tail))}  # fmt: skip
    there = {name: rank for name, rank in ranks.items() if 0 <= rank < count}
    found = dict(zip(there, values.ordered([*there.values()]), strict=True))
    value = float(np.quantile([found["first"], found["second"]], at - first))
    low, high = (finite_or_none(found.get(end, math.nan)) for end in ("low", "high"))
    return Estimate(value, low, high, count)


def kaplan_meier_median(
    times: Shaped[np.ndarray, "subject"] | Values,
    observed: Bool[np.ndarray, "subject"] | Values,
    *,
    confidence: float = CONFIDENCE,
) -> Estimate:
    """Return the first time by which half of the subjects had their event; None if the curve stays above one half.

    Args:
        times: when the event came, or when the subject was last observed without it; few different ones, such as times
            in steps.
        observed: whether the event came; else the time is right-censored.
        confidence: level of the interval: the times at which the log-log band of the curve falls to one half
            (Brookmeyer and Crowley, 1982); an end that is never reached is None.
    """
    times, observed = Values.of(times), Values.of(observed)
    at, subjects = times.distinct()
    came, often = Values(lambda: (time[seen] for time, seen in zip(times, observed, strict=True))).distinct()
    if not len(came):
        return Estimate(None, None, None, times.count)
    events = np.zeros(len(at), np.int64)
    events[np.searchsorted(at, came)] = often
    at_risk = subjects[::-1].cumsum()[::-1]
    survival = np.cumprod((at_risk - events) / at_risk)
    value, low, high = (_comes_down(at, curve) for curve in (survival, *_band(events, at_risk, survival, confidence)))
    return Estimate(value, low, high, times.count)


def _band(
    events: Int[np.ndarray, "time"], at_risk: Int[np.ndarray, "time"], survival: Float[np.ndarray, "time"],
    confidence: float,
) -> tuple[Float[np.ndarray, "time"], Float[np.ndarray, "time"]]:  # fmt: skip
    """Return Greenwood's log-log band of a survival curve; its upper edge is NaN at 0 and 1."""
    # the same as scipy's ecdf().sf.confidence_interval, which warns wherever the curve is 0 or 1
    inside = (survival > 0) & (survival < 1)
    terms = np.nan_to_num(ratio(events, at_risk * (at_risk - events)))
    log_survival = np.log(survival, out=np.full(len(survival), -1.0), where=inside)
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
