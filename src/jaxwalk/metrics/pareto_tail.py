"""Fit a generalised Pareto distribution to near misses, and say how many contacts its tail holds for each of them.

Peaks over threshold (Coles, 2001, chapter 4): of gaps below a threshold u, the excess y = u - gap has the survival
function (1 + shape y / scale)^(-1 / shape), and a contact is an excess of u or more. Near misses without a contact lie
below u, so they are fitted as a sample that is cut off there: contacts that were observed have no part in the fit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy
from jaxtyping import Float, Int

from jaxwalk.metrics.statistics import CONFIDENCE

SHAPES = (-1.0, 1.0)
"""Shapes that are considered: below -1 there is no likeliest one, above 1 no mean."""
RATIOS = (-16.0, 8.0)
"""Logarithms of contacts per near miss that are considered; the lower end stands for none, the upper for any number."""
PRECISELY = {"xatol": 1e-3}
"""How precisely a shape, or the logarithm of a ratio, is sought."""
CELLS = 10
"""The fit is tested by counts in this many equally likely parts."""


@dataclass(frozen=True)
class Excesses:
    """Different excesses, and how often each was seen."""

    size: Float[np.ndarray, "different"]
    times: Int[np.ndarray, "different"]

    @property
    def count(self) -> int:
        """How many were seen."""
        return int(self.times.sum())


@dataclass(frozen=True)
class ParetoFit:
    """Contacts per near miss by the fitted tail, with the profile-likelihood interval."""

    ratio: float
    low: float
    """0 if the tail may end before a contact."""
    high: float | None
    """None if the near misses set no bound."""
    shape: float
    p: float
    """Chance of a worse fit, if the distribution were the fitted one (chi-square of `CELLS` counts)."""


def fit(excesses: Excesses, threshold: float) -> ParetoFit:
    """Fit the tail of excesses in (0, threshold); there must be some tens of them."""
    y = replace(excesses, size=excesses.size / threshold)
    grid = np.linspace(*RATIOS, 25)
    likely = [_profile(y, at)[0] for at in grid]
    best = int(np.argmax(likely))
    around = (grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)])
    found, _ = _largest(lambda at: _profile(y, at)[0], around)
    top, shape = _profile(y, found)
    allowed = top - float(scipy.stats.chi2.ppf(CONFIDENCE, 1)) / 2
    low, high = (_where(y, allowed, found, end) for end in RATIOS)
    return ParetoFit(
        ratio=math.exp(found),
        low=0.0 if low is None else math.exp(low),
        high=None if high is None else math.exp(high),
        shape=shape,
        p=_fit_p(y, found, shape),
    )


def _profile(y: Excesses, log_ratio: float) -> tuple[float, float]:
    """Return the largest log likelihood at this number of contacts per near miss, and its shape; ``y`` is in (0, 1)."""
    shape, top = _largest(lambda shape: _log_likelihood(y, log_ratio, shape), SHAPES)
    return top, shape


def _largest(function: Callable[[float], float], bounds: tuple[float, float]) -> tuple[float, float]:
    """Return where a function is largest between two bounds, and how large."""
    found: Any = scipy.optimize.minimize_scalar(
        lambda x: -function(x), bounds=bounds, method="bounded", options=PRECISELY
    )
    return float(found.x), -float(found.fun)


def _log_likelihood(y: Excesses, log_ratio: float, shape: float) -> float:
    """Return the log likelihood of excesses in (0, 1).

    The parameters are the shape and S / (1 - S), S being the chance of an excess of 1 or more: S = (1 + a)^(-1 / shape)
    with a = shape / scale.
    """
    log_beyond, log_within = scipy.special.log_expit(log_ratio), scipy.special.log_expit(-log_ratio)
    if abs(shape) < 1e-6:
        return y.count * (math.log(-log_beyond) - log_within) + log_beyond * float(y.times @ y.size)
    a = math.expm1(-shape * log_beyond)
    return y.count * (math.log(a / shape) - log_within) - (1 / shape + 1) * float(y.times @ np.log1p(a * y.size))


def _where(y: Excesses, allowed: float, found: float, end: float) -> float | None:
    """Return where the profile falls to what is allowed, between the likeliest value and an end; None if nowhere."""
    if _profile(y, end)[0] >= allowed:
        return None
    fallen: Any = scipy.optimize.brentq(lambda at: _profile(y, at)[0] - allowed, found, end, xtol=1e-3)
    return float(fallen)


def _fit_p(y: Excesses, log_ratio: float, shape: float) -> float:
    """Return the p-value of the chi-square test of the fit; two parameters were fitted."""
    log_beyond = float(scipy.special.log_expit(log_ratio))
    scaled = math.expm1(-shape * log_beyond) if abs(shape) >= 1e-6 else 0.0
    survival = np.exp(-np.log1p(scaled * y.size) / shape) if scaled else np.exp(log_beyond * y.size)
    within = (1 - survival) / -math.expm1(log_beyond)
    counts, expected = np.histogram(within, CELLS, (0, 1), weights=y.times)[0], y.count / CELLS
    return float(scipy.stats.chi2.sf(((counts - expected) ** 2).sum() / expected, CELLS - 3))
