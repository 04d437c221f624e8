"""Numbers over training seeds against the t-distribution and a worked analysis of variance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from jaxwalk.metrics import FEWEST_SEEDS, Estimate, crossed_mean, interquartile_mean, over_seeds
from jaxwalk.metrics.counts import share_ends
from jaxwalk.metrics.over_seeds import linear_part

GRID = np.array([[3.0, 5, 4, 6], [1, 3, 3, 5], [2, 6, 3, 5]])
"""Three seeds, four scenarios; mean squares of seeds, scenarios and the rest: 7/3, 59/9, 5/9."""


def test_crossed_mean_by_hand():
    both = 7 / 3 + 59 / 9 - 5 / 9
    found = crossed_mean(GRID)
    assert found.value == pytest.approx(46 / 12)
    assert found.error == pytest.approx(math.sqrt(both / 12))
    assert found.freedom == pytest.approx(2 * (both / (7 / 3)) ** 2)
    low, high = found.ends()
    assert (low + high) / 2 == pytest.approx(found.value)
    assert high - found.value == pytest.approx(stats.t(found.freedom).ppf(0.975) * found.error)


def test_one_scenario_leaves_the_spread_of_the_seeds():
    found = crossed_mean(np.array([[1.0], [2.0], [3.0]]))
    assert (found.value, found.error, found.freedom) == (2, pytest.approx(1 / math.sqrt(3)), 2)


def test_a_seed_that_matters_as_much_as_a_scenario():
    """Mean squares of seeds and of scenarios are 1, and of the rest 0; with two scenarios, both have a part in it."""
    found = crossed_mean(np.array([[0.0, 1], [1, 2]]))
    assert (found.value, found.error, found.freedom) == (1, pytest.approx(math.sqrt(2 / 4)), pytest.approx(4))


def test_the_linear_part_by_hand():
    """A ratio of 10 / 4; the second scenario's 9 is 1.5 more than 2.5 x 3, over a mean denominator of 2."""
    np.testing.assert_allclose(linear_part(np.array([[1.0, 9]]), np.array([[1.0, 3]])), [[2.5 - 0.75, 2.5 + 0.75]])


def test_without_common_scenarios_it_is_the_t_test_over_seeds():
    """Each scenario has the same mean: nothing of it is common to the seeds."""
    values = np.repeat([[1.0], [2.0], [4.0], [-1.0], [3.0]], 6, axis=1)
    values[0] += [1, -1] * 3
    values[1] -= [1, -1] * 3
    found, expected = crossed_mean(values), stats.ttest_1samp(values.mean(axis=1), 0)
    assert found.freedom == 4
    assert found.ends() == pytest.approx(tuple(expected.confidence_interval()))
    assert found.p() == pytest.approx(expected.pvalue)


def test_over_seeds_is_a_t_interval_over_seeds():
    rates = np.repeat([[0.2], [0.4], [0.3], [0.5], [0.1]], 40, axis=1)
    found = over_seeds(rates, np.ones_like(rates))
    assert (found.mean.value, found.iqm, found.mean.count) == (pytest.approx(0.3), pytest.approx(0.3), 5)
    assert found.each == pytest.approx((0.2, 0.4, 0.3, 0.5, 0.1))
    half = 2.776 * np.std([0.2, 0.4, 0.3, 0.5, 0.1], ddof=1) / 5**0.5
    assert (found.mean.low, found.mean.high) == pytest.approx((0.3 - half, 0.3 + half), abs=1e-3)
    # odds of 3 / 7, and half / 0.21 on the scale of their logarithm; of a rate, half / 0.3
    share, rate = (over_seeds(rates, np.ones_like(rates), kind=kind).mean for kind in ("share", "rate"))
    odds = [3 / 7 * math.exp(sign * half / 0.21) for sign in (-1, 1)]
    assert (share.low, share.high) == pytest.approx([x / (1 + x) for x in odds], abs=1e-3)
    assert (rate.low, rate.high) == pytest.approx((0.3 * math.exp(-half / 0.3), 0.3 * math.exp(half / 0.3)), abs=1e-3)


def test_a_share_stays_between_0_and_1():
    one = np.repeat(np.eye(5)[0][:, None], 40, axis=1)
    rarely, mostly = (over_seeds(x, np.ones_like(x), kind="share").mean for x in (one, 1 - one))
    assert 0 < rarely.low < 0.2 < rarely.high < 1
    assert (mostly.low, mostly.high) == pytest.approx((1 - rarely.high, 1 - rarely.low))
    assert over_seeds(one, np.ones_like(one), kind="rate").mean.low > 0


def test_over_seeds_where_only_scenarios_differ():
    """Every seed ends alike in the same scenario: more seeds tell nothing more."""
    ends = (np.random.default_rng(3).random(400) < 0.3).astype(float)
    found = over_seeds(np.tile(ends, (5, 1)), np.ones((5, 400))).mean
    error = ends.std(ddof=1) / 20
    assert (found.low, found.high) == pytest.approx((ends.mean() - 1.96 * error, ends.mean() + 1.96 * error), abs=1e-4)


def test_a_ratio_of_sums_varies_as_its_linear_part():
    """The interval of a ratio is that of a mean with the same values, if every denominator is the same."""
    over = np.random.default_rng(4).random((5, 50))
    doubled, plain = over_seeds(2 * over, 2 * np.ones((5, 50))).mean, over_seeds(over, np.ones((5, 50))).mean
    assert (doubled.low, doubled.high) == pytest.approx((plain.low, plain.high))
    twice = over_seeds(over * over, over).mean
    assert twice.value == pytest.approx(np.mean((over * over).sum(axis=1) / over.sum(axis=1)))


def test_equal_seeds_are_no_proof():
    never, trials = np.zeros((5, 2000)), np.ones((5, 2000))
    found = over_seeds(never, trials, kind="share").mean
    assert (found.value, found.low, found.high) == (0, *share_ends(0, 2000))
    assert over_seeds(never, trials / 100, kind="rate").mean.high == pytest.approx(3.689 / 20, rel=1e-3)
    assert over_seeds(never, trials).mean == Estimate(0.0, None, None, 5)
    three = np.zeros((5, 2000))
    for seed in range(5):
        three[seed, 3 * seed : 3 * seed + 3] = 1
    found = over_seeds(three, trials, kind="share").mean
    assert (found.value, found.low, found.high) == (0.0015, *share_ends(3, 2000))


def test_few_seeds_do_not_tell_how_much_seeds_differ():
    values = np.arange(4 * 30.0).reshape(4, 30)
    found = over_seeds(values, np.ones((4, 30)))
    assert found.mean == Estimate(59.5, None, None, FEWEST_SEEDS - 1)
    assert found.iqm == 59.5
    assert over_seeds(values[:1], np.ones((1, 30))).mean == Estimate(14.5, None, None, 1)


def test_a_seed_without_a_number_leaves_none_over_seeds():
    found = over_seeds(np.ones((5, 4)), np.array([[0.0] * 4, [1] * 4, [2] * 4, [1] * 4, [1] * 4]))
    assert (found.mean.value, found.iqm) == (None, None)
    assert found.each == (None, 1, 0.5, 1, 1)


def test_interquartile_mean_drops_a_quarter_at_either_end():
    assert interquartile_mean(np.array([100.0, 1, 2, 3, -50])) == 2
    assert interquartile_mean(np.array([0.0, 1, 5])) == 2  # a quarter of three is nobody
    assert interquartile_mean(np.array([[1.0, 2, 3, 9], [4, 4, 4, np.nan]])).tolist()[0] == 2.5
    assert np.isnan(interquartile_mean(np.array([4.0, 4, 4, np.nan])))


def test_seeds_with_equal_counts_do_not_differ_by_rounding():
    """Seven of 2,000 in each of five seeds, in other scenarios: NumPy's variance of five equal means is not 0."""
    values = np.zeros((5, 2000))
    for seed in range(5):
        values[seed, 311 * seed : 311 * seed + 7] = 1
    assert values.mean(axis=1).var(ddof=1) > 0, "so this test says something"
    found = over_seeds(values, np.ones_like(values), kind="share").mean
    assert (found.low, found.high) == share_ends(7, 2000)


def test_scenarios_with_equal_counts_do_not_differ_by_rounding():
    """Neither seeds nor scenarios differ, so there is no standard error."""
    for share in (0.002, 0.003, 0.007, 0.3):
        assert crossed_mean(np.full((5, 7), share)).error == 0
