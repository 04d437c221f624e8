"""Strengths from comparisons: small cases by hand, and the same optimum as a general optimiser finds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize, special

from jaxwalk.raters.agreement import alpha, nominal, with_mirrored
from jaxwalk.raters.preferences import RIDGE, ends, fit, pairs_of, resampled


def test_two_drivers_by_hand():
    """Without a prior to speak of and without ties, strengths differ by the log of the odds: ln 3 of 30 against 10."""
    found = fit(np.array([[30.0, 10.0, 0.0]]), 2, ridge=1e-6)
    assert found.tolist() == pytest.approx([np.log(3) / 2, -np.log(3) / 2], abs=1e-3)


def test_ties_do_not_pull_strengths_together():
    """In Davidson's model the odds of decided comparisons are those of the strengths, however many ties there are."""
    few, many = (fit(np.array([[300.0, 100.0, ties]]), 2, ridge=1e-6) for ties in (1.0, 400.0))
    assert few[0] - few[1] == pytest.approx(np.log(3), abs=1e-3)
    assert many[0] - many[1] == pytest.approx(np.log(3), abs=1e-3)


def test_who_always_wins_stays_finite():
    found = fit(np.array([[20.0, 0.0, 0.0]]), 2)
    assert 1 < found[0] < 5
    assert fit(np.zeros((3, 3)), 3).tolist() == [0, 0, 0]


def _cost(x, counts, items):
    a, b = x[pairs_of(items)].T
    logits = np.stack([a, b, (a + b) / 2 + x[-1]], axis=1)
    return RIDGE / 2 * (x @ x) - (counts * special.log_softmax(logits, axis=1)).sum()


def test_it_is_the_optimum_of_the_likelihood():
    rng = np.random.default_rng(1)
    counts = rng.integers(0, 30, (10, 3)).astype(float)
    best = optimize.minimize(_cost, np.zeros(6), (counts, 5), tol=1e-10).x[:5]
    assert fit(counts, 5) == pytest.approx(best, abs=1e-4)
    together = fit(np.stack([counts, counts[:, [1, 0, 2]]]), 5)
    assert together[0] == pytest.approx(fit(counts, 5))
    assert together[1] == pytest.approx(-together[0])  # every preference turned round
    assert together.sum(axis=1) == pytest.approx([0, 0], abs=1e-9)


def test_resamples_are_of_whole_raters():
    counts = np.zeros((4, 1, 3))
    counts[:, 0, 0] = [1, 10, 100, 1000]
    found = resampled(counts, resamples=50)
    assert found.shape == (51, 1, 3)
    assert found[0, 0, 0] == 1111
    digits = [sum(map(int, str(int(value)))) for value in found[1:, 0, 0]]
    assert set(digits) == {4}  # four raters in each sample


def test_intervals_of_few_raters_are_wider_than_percentiles():
    samples = np.concatenate([[0.0], np.linspace(0, 1, 10_001)])
    low, high = ends(samples, 5)
    # the t quantile of 4 degrees of freedom is 2.776, times sqrt(5 / 4) 3.104, beyond which 0.095 % of a normal lie
    assert (low, high) == pytest.approx((0.00095, 0.99905), abs=1e-4)


EXAMPLE = """
1 2 3 3 2 1 4 1 2 . . .
1 2 3 3 2 2 4 1 2 5 . 3
. 3 3 3 2 3 4 2 2 5 1 .
1 2 3 3 2 4 4 1 2 5 1 .
"""
"""Krippendorff (2011), example C: four observers and twelve units."""


def test_alpha_of_krippendorffs_example():
    ratings = np.array([[np.nan if x == "." else float(x) for x in line.split()] for line in EXAMPLE.split("\n")[1:-1]])
    assert alpha(ratings, nominal) == pytest.approx(0.743, abs=5e-4)
    assert alpha(ratings) == pytest.approx(0.849, abs=5e-4)
    assert alpha(ratings, weights=np.ones(12)) == alpha(ratings)


def test_alpha_of_agreement_and_of_none():
    alike = np.array([[1.0, -1.0, 0.0], [1.0, -1.0, 0.0]])
    assert alpha(alike) == 1
    assert alpha(np.array([[1.0, -1.0], [-1.0, 1.0]])) < 0
    assert np.isnan(alpha(np.array([[1.0, np.nan], [np.nan, 1.0]])))  # nobody rated the same
    assert np.isnan(alpha(np.ones((3, 2))))  # nothing varies
    one_sided = np.ones((2, 3))
    assert alpha(with_mirrored(one_sided)) == 1  # whose clip is called the first one doesn't matter
