"""Strengths from paired comparisons with ties: Davidson's extension of the Bradley-Terry model.

Of two items with strengths a and b (log scale), the first is preferred with probability exp(a) / Z, the second with
exp(b) / Z, and neither with nu exp((a + b) / 2) / Z, where Z is the sum of the three numerators (Davidson 1970, *On
extending the Bradley-Terry model to accommodate ties in paired comparison experiments*). Without ties it is the model
of Bradley and Terry (1952). A tie that counts as half a win for each would pull the strengths together.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
import scipy
from jaxtyping import Float, Int

from jaxwalk.metrics.statistics import CONFIDENCE

RIDGE = 0.1
"""Precision of the normal prior about 0 of every strength and of log nu: it keeps an item that always wins finite."""
STEP, ENOUGH, MOST_STEPS = 1.0, 1e-8, 200
"""A Newton step changes no parameter by more than this; it ends when none changes by more than ``ENOUGH``."""


def pairs_of(items: int) -> Int[np.ndarray, "pair 2"]:
    """Return all pairs of items, in the order of counts."""
    return np.array(list(combinations(range(items), 2)), int).reshape(-1, 2)


def fit(counts: Float[np.ndarray, "*sample pair 3"], items: int, *, ridge: float = RIDGE) -> Float[np.ndarray, "..."]:
    """Return the strengths of all items, ``(*sample, item)``, whose mean is 0; samples are fitted at once.

    Args:
        counts: for each pair of `pairs_of`: how often the first item was preferred, how often the second, and ties.
        items: number of items, at least 2.
        ridge: precision of the prior, above 0.
    """
    shape = counts.shape[:-2]
    found = np.asarray(counts, np.float64).reshape(-1, *counts.shape[-2:])
    features = _features(items)
    products = np.einsum("pkd,pke->pkde", features, features)
    total = found.sum(axis=2)
    x = np.zeros((len(found), items + 1))
    for _ in range(MOST_STEPS):
        share = scipy.special.softmax(np.einsum("sd,pkd->spk", x, features), axis=2)
        mean = np.einsum("spk,pkd->spd", share, features)
        slope = np.einsum("spk,pkd->sd", found - total[:, :, None] * share, features) - ridge * x
        curve = np.einsum("spk,pkde->sde", total[:, :, None] * share, products)
        curve -= np.einsum("sp,spd,spe->sde", total, mean, mean)
        curve += ridge * np.eye(items + 1)
        step = np.clip(np.linalg.solve(curve, slope[:, :, None])[:, :, 0], -STEP, STEP)
        x += step
        if np.abs(step).max(initial=0.0) < ENOUGH:
            break
    return x[:, :items].reshape(*shape, items)


def _features(items: int) -> Float[np.ndarray, "pair 3 parameter"]:
    """Return what each parameter (the strengths, log nu) adds to the log numerator of each answer."""
    found = np.zeros((items * (items - 1) // 2, 3, items + 1))
    for place, (a, b) in enumerate(pairs_of(items)):
        found[place, 0, a] = found[place, 1, b] = found[place, 2, items] = 1.0
        found[place, 2, [a, b]] = 0.5
    return found


def resampled(
    counts: Float[np.ndarray, "rater pair 3"], *, resamples: int, seed: int = 0
) -> Float[np.ndarray, "sample pair 3"]:
    """Return the sums over raters: of all of them (sample 0), and of as many drawn with replacement."""
    raters = len(counts)
    draws = np.random.default_rng(seed).multinomial(raters, np.full(raters, 1 / raters), size=resamples)
    times = np.concatenate([np.ones((1, raters)), draws])
    return np.einsum("sr,rpk->spk", times, counts)


def ends(samples: Float[np.ndarray, "sample *item"], raters: int) -> Float[np.ndarray, "2 *item"]:
    """Return the 95 % interval of a number of so few raters from its bootstrap samples, without the first one.

    The percentile interval of n raters is too narrow by the factor sqrt((n - 1) / n), and by that of the normal to
    Student's t. Its levels are moved outward as much (Hesterberg 2015, *What teachers should know about the
    bootstrap*).
    """
    tail = (1 - CONFIDENCE) / 2
    level = scipy.stats.norm.cdf(np.sqrt(raters / (raters - 1)) * scipy.stats.t.ppf(tail, raters - 1))
    return np.quantile(samples[1:], [level, 1 - level], axis=0)
