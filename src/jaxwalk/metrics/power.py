"""Compute how many scenarios are needed to show that two rates differ."""

from __future__ import annotations

import math

import scipy

ROUNDING = 1e-9
"""Shares may add up to this much more than 1."""


def scenarios_needed(a: float, b: float, *, both: float | None = None, power: float = 0.8, alpha: float = 0.05) -> int:
    """Return how many scenarios a two-sided McNemar test needs to detect a difference with probability ``power``.

    n = (z_{1 - alpha/2} sqrt(s) + z_power sqrt(s - d^2))^2 / d^2, where d = b - a, and s is the share of scenarios with
    this ending in exactly one of the two (Connor 1987, *Sample size for testing differences in proportions for the
    paired-sample design*). The exact test is more conservative and has slightly less power: 0.77 to 0.79, not 0.8.

    Args:
        a: rate of the first driver, in [0, 1].
        b: rate of the second driver on the same scenarios.
        both: share of scenarios with this ending in both (default: a b, as if all scenarios were equally difficult,
            which asks for more scenarios than needed).
        power: in (0, 1).
        alpha: largest p-value that counts as significant.

    Raises:
        ValueError: the rates are equal (no number of scenarios is enough), or impossible together.
    """
    both = a * b if both is None else both
    if not 0 <= both <= min(a, b) or max(a, b) > 1 or a + b - both > 1 + ROUNDING:
        raise ValueError(f"rates {a} and {b} with {both} in both are impossible")
    if a == b:
        raise ValueError(f"rates that are equal ({a}) can't be told apart by any number of scenarios")
    difference, single = b - a, a + b - 2 * both
    found = scipy.stats.norm.ppf(1 - alpha / 2) * math.sqrt(single)
    found += scipy.stats.norm.ppf(power) * math.sqrt(max(single - difference**2, 0.0))
    return math.ceil((found / difference) ** 2)
