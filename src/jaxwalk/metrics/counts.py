"""Intervals of counts and shares that cover what they say when events are rare.

A resample of an episode without a collision has none either: the bootstrap of a count of zero ends at zero, and with
one or two events it covers 63 to 87 %. So no count or share of counts in jaxwalk has a bootstrap interval.
``docs/metrics.md`` has the measured coverage of all of these.
"""

from __future__ import annotations

import math
from typing import SupportsInt

import numpy as np
import scipy
from jaxtyping import Float

from jaxwalk.metrics.statistics import CONFIDENCE, Estimate, Rate

FEW = 10
"""With fewer events, or fewer trials without the event, than this, the interval of a share is exact, not Wilson's."""

ROUNDING = 1e-20
"""Resamples of a share with a smaller variance are equal but for rounding."""


def proportion(successes: SupportsInt, trials: SupportsInt) -> Rate:
    """Return the share of independent trials that succeeded, with the interval of `share_ends`."""
    successes, trials = int(successes), int(trials)
    if trials == 0:
        return Rate(None, None, None, 0, 0)
    return Rate(successes / trials, *share_ends(successes, trials), successes, trials)


def share_ends(successes: int | float, trials: int | float) -> tuple[float, float]:
    """Return the 95 % interval of a share: Wilson's score interval, or Clopper and Pearson's exact one for few events.

    The counts needn't be whole: they may be effective ones (`clustered_share`). ``trials`` must be positive.
    """
    few = min(successes, trials - successes) < FEW
    return exact_share_ends(successes, trials) if few else _wilson_ends(successes, trials)


def exact_share_ends(successes: int | float, trials: int | float) -> tuple[float, float]:
    """Return Clopper and Pearson's exact interval: it covers at least 95 %, whatever the share."""
    tail, failures = (1 - CONFIDENCE) / 2, trials - successes
    low = scipy.stats.beta.ppf(tail, successes, failures + 1) if successes > 0 else 0.0
    high = scipy.stats.beta.ppf(1 - tail, successes + 1, failures) if failures > 0 else 1.0
    return float(low), float(high)


def _wilson_ends(successes: int | float, trials: int | float) -> tuple[float, float]:
    z2, share = float(scipy.stats.norm.ppf((1 + CONFIDENCE) / 2)) ** 2 / trials, successes / trials
    centre, half = share + z2 / 2, math.sqrt(z2 * (share * (1 - share) + z2 / 4))
    return (centre - half) / (1 + z2), (centre + half) / (1 + z2)


def clustered_share(draws: Float[np.ndarray, "draw"], count: int | float, clusters: SupportsInt) -> Estimate:
    """Return a share of trials that depend on each other within an episode, with an interval for it.

    The interval is `share_ends` of an effective number of trials: that of independent ones with the variance that the
    resamples over episodes have (Korn and Graubard, 1998). Where nothing varies (none or all of the trials, a single
    episode), every episode counts as one trial.

    Args:
        draws: the share (element 0), and its resamples over episodes; NaN means undefined.
        count: number of trials, or another measure of them.
        clusters: number of episodes with a trial.
    """
    share, resamples, clusters = float(draws[0]), draws[1:], int(clusters)
    if not math.isfinite(share):
        return Estimate(None, None, None, int(count))
    variance = float(np.var(resamples[np.isfinite(resamples)])) if np.isfinite(resamples).any() else 0.0
    trials = float(clusters)
    if clusters > 1 and share * (1 - share) > 0 and variance > ROUNDING:
        # so few episodes tell the variance itself no better than a t-distribution's degrees of freedom say
        tail = (1 + CONFIDENCE) / 2
        known = float(scipy.stats.norm.ppf(tail) / scipy.stats.t.ppf(tail, clusters - 1)) ** 2
        trials = min(share * (1 - share) / variance * known, max(float(count), clusters))
    return Estimate(share, *share_ends(share * trials, trials), int(count))


def rate(count: SupportsInt, exposure: int | float) -> Estimate:
    """Return events per unit of exposure, with Garwood's exact Poisson interval (1936); the exposure counts as known.

    The value does not exist without exposure.
    """
    count = int(count)
    if not exposure > 0:
        return Estimate(None, None, None, count)
    return Estimate(count / exposure, *_rate_ends(count, exposure), count)


def clustered_rate(draws: Float[np.ndarray, "draw"], exposure: int | float) -> Estimate:
    """Return events per unit of known exposure, if events of one episode depend on each other.

    The interval is Garwood's of an effective number of events: as many independent ones as vary as much as the
    resamples over episodes do.

    Args:
        draws: the number of events (element 0), and its resamples over episodes; NaN means undefined.
        exposure: all of it.
    """
    count = int(draws[0])
    if not exposure > 0:
        return Estimate(None, None, None, count)
    variance = float(np.nan_to_num(np.var(draws[1:]))) if len(draws) > 1 else 0.0
    times = max(1.0, variance / max(count, 1))
    return Estimate(count / exposure, *_rate_ends(count / times, exposure / times), count)


def _rate_ends(count: int | float, exposure: int | float) -> tuple[float, float]:
    tail = (1 - CONFIDENCE) / 2
    low = scipy.stats.chi2.ppf(tail, 2 * count) / 2 if count else 0.0
    high = scipy.stats.chi2.ppf(1 - tail, 2 * count + 2) / 2
    return float(low / exposure), float(high / exposure)


def rate_ratio(events: tuple[SupportsInt, SupportsInt], exposures: tuple[float, float]) -> Estimate:
    """Return the second rate over the first, with its exact interval given the number of events of both.

    Given that number, the second kind's part of it is binomial, and Clopper and Pearson's interval of the share gives
    that of the ratio (Przyborowski and Wilenski, 1940). Without an event of the first kind neither the ratio nor an
    upper end exists; the lower end does. ``count`` is the number of events of both.
    """
    first, second = (int(x) for x in events)
    both = first + second
    if both == 0 or min(exposures) <= 0:
        return Estimate(None, None, None, both)
    scale = exposures[0] / exposures[1]
    low, high = (scale * share / (1 - share) if share < 1 else None for share in exact_share_ends(second, both))
    return Estimate(scale * second / first if first else None, low, high, both)
