"""Intervals of counts and shares against published tables and exact numbers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from jaxwalk.metrics import clustered_share, proportion, rate, rate_ratio
from jaxwalk.metrics.counts import clustered_rate, exact_share_ends, share_ends
from jaxwalk.metrics.statistics import Estimate, Rate, episode_sums, ratio


def test_wilson_of_the_papers_14_percent():
    found = proportion(70, 500)
    assert (found.value, found.successes, found.trials) == (0.14, 70, 500)
    assert (found.low, found.high) == (pytest.approx(0.112, abs=5e-4), pytest.approx(0.173, abs=5e-4))


@pytest.mark.parametrize(("successes", "method"), [(9, "exact"), (10, "wilson"), (90, "wilson"), (91, "exact")])
def test_few_events_have_the_exact_interval(successes, method):
    found = proportion(successes, 100)
    expected = stats.binomtest(successes, 100).proportion_ci(method=method)
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high))


def test_a_share_of_nothing_and_none_of_few():
    assert proportion(0, 0) == Rate(None, None, None, 0, 0)
    never, always = proportion(0, 10), proportion(10, 10)
    # 1 - 0.025^(1/10)
    assert (never.low, never.high) == (0, pytest.approx(0.3085, abs=1e-4))
    assert (always.low, always.high) == (pytest.approx(0.6915, abs=1e-4), 1)


def test_exact_ends_of_counts_that_are_not_whole_lie_between():
    ends = [exact_share_ends(x, 40.0) for x in (2, 2.5, 3)]
    assert ends[0][0] < ends[1][0] < ends[2][0]
    assert ends[0][1] < ends[1][1] < ends[2][1]


def test_garwoods_table():
    # Garwood (1936), 95 %: 0 to 3.689 for none, 0.0253 to 5.572 for one, 4.795 to 18.39 for ten
    for count, low, high in ((0, 0, 3.689), (1, 0.02532, 5.572), (10, 4.795, 18.391)):
        found = rate(count, 2.0)
        assert (found.value, found.count) == (count / 2, count)
        assert (found.low, found.high) == pytest.approx((low / 2, high / 2), rel=1e-3)
    assert rate(0, 0.0) == Estimate(None, None, None, 0)
    assert rate(1, 0.5).value == 2


def test_a_single_success_or_failure_has_an_exact_interval():
    # 1 - 0.975^(1/10) is the lower end of one of ten
    assert exact_share_ends(1, 10)[0] == pytest.approx(0.002529, abs=1e-6)
    assert exact_share_ends(9, 10)[1] == pytest.approx(1 - 0.002529, abs=1e-6)


def test_rate_ratio_is_the_conditional_binomial():
    # 4 of 67 collisions with jaywalkers, who made a tenth of the crossings: odds of the exact ends, times nine
    low, high = exact_share_ends(4, 67)
    found = rate_ratio((63, 4), (900.0, 100.0))
    assert (found.value, found.count) == (pytest.approx(4 / 63 * 9), 67)
    assert (found.low, found.high) == pytest.approx((9 * low / (1 - low), 9 * high / (1 - high)))


def test_rate_ratio_without_events_of_a_kind():
    none = rate_ratio((5, 0), (1.0, 1.0))
    assert (none.value, none.low) == (0, 0)
    assert none.high == pytest.approx(0.5218 / (1 - 0.5218), rel=1e-3)  # 1 - 0.025^(1/5)
    only = rate_ratio((0, 5), (1.0, 1.0))
    assert (only.value, only.high) == (None, None)
    assert only.low == pytest.approx(1 / none.high)
    assert rate_ratio((0, 0), (1.0, 1.0)) == Estimate(None, None, None, 0)
    assert rate_ratio((0, 5), (0.0, 1.0)) == Estimate(None, None, None, 5)


def _share(successes, trials):
    """Return the clustered share of per-episode counts."""
    sums = episode_sums({"over": np.array(successes), "under": np.array(trials)})
    return clustered_share(ratio(sums["over"], sums["under"]), sum(trials), np.count_nonzero(trials))


def test_a_clustered_share_of_single_trials_is_nearly_the_plain_one():
    ends = (np.arange(400) % 4 == 0).astype(int)
    found = _share(ends, [1] * 400)
    assert (found.value, found.count) == (0.25, 400)
    assert (found.low, found.high) == pytest.approx(share_ends(100, 400), abs=0.004)


def test_a_clustered_share_of_equal_trials_counts_episodes():
    """Ten trials that always end alike are one."""
    ends = (np.arange(100) % 4 == 0).astype(int)
    found = _share(10 * ends, [10] * 100)
    assert (found.low, found.high) == pytest.approx(share_ends(25, 100), abs=0.01)


def test_a_clustered_share_of_none_is_bounded_by_its_episodes():
    found = _share([0] * 30, [7] * 20 + [0] * 10)
    assert found == Estimate(0.0, *exact_share_ends(0, 20), 140)
    assert _share([7] * 20, [7] * 20).low == pytest.approx(0.8316, abs=1e-4)
    assert _share([3], [7]) == Estimate(3 / 7, *exact_share_ends(3 / 7, 1), 7)
    assert _share([0, 0], [0, 0]) == Estimate(None, None, None, 0)


def test_equal_shares_that_rounding_tells_apart_count_clusters():
    """0.1 + 0.2 isn't 0.3: whether resamples of equal shares are equal to the bit decides nothing."""
    equal = np.full(100, 0.6)
    rounded = equal + np.tile([0.0, 1e-16], 50)
    assert clustered_share(equal, 2000, 5) == Estimate(0.6, *exact_share_ends(3.0, 5.0), 2000)
    assert clustered_share(rounded, 2000, 5) == clustered_share(equal, 2000, 5)


def test_a_clustered_share_by_hand():
    """A variance of 0.01 is that of 0.25 / 0.01 = 25 trials; five episodes know it (1.95996 / 2.77645)^2 as well."""
    trials = 25 * (1.959964 / 2.776445) ** 2
    found = clustered_share(np.array([0.5, 0.4, 0.6, 0.4, 0.6]), 100, 5)
    assert (found.value, found.count) == (0.5, 100)
    assert (found.low, found.high) == pytest.approx(exact_share_ends(trials / 2, trials), abs=1e-6)
    # two episodes: t with one degree of freedom is 12.7062
    trials = 25 * (1.959964 / 12.7062) ** 2
    found = clustered_share(np.array([0.5, 0.4, 0.6, 0.4, 0.6]), 100, 2)
    assert (found.low, found.high) == pytest.approx(exact_share_ends(trials / 2, trials), abs=1e-5)


def test_trials_count_once_at_most():
    """A variance of 0.0001 would be that of 2,500 trials or, with 100 episodes, some fewer; there are 400."""
    found = clustered_share(np.array([0.5, 0.49, 0.51]), 400, 100)
    assert (found.low, found.high) == share_ends(200, 400)


def test_without_a_spread_between_episodes_each_counts_as_one_trial():
    varied, unknown = np.array([0.5, 0.4, 0.6]), np.array([0.5, np.nan, np.nan])
    assert clustered_share(varied, 8, 1) == Estimate(0.5, *exact_share_ends(0.5, 1), 8)
    assert clustered_share(unknown, 8, 4) == Estimate(0.5, *exact_share_ends(2, 4), 8)
    for share in (0.0, 1.0):
        assert clustered_share(np.array([share, 0.4, 0.6]), 8, 4) == Estimate(share, *exact_share_ends(4 * share, 4), 8)


def test_a_clustered_rate_by_hand():
    """Four events whose number varies by 16 are as one of four: Garwood's 0.02532 to 5.572 in a quarter of the time."""
    found = clustered_rate(np.array([4.0, 0, 8, 0, 8]), 0.5)
    assert (found.value, found.count) == (8, 4)
    assert (found.low, found.high) == pytest.approx((0.02532 * 8, 5.572 * 8), rel=1e-3)
    # one event whose number varies by 4 is as a quarter of one
    found = clustered_rate(np.array([1.0, 0, 4, 0, 4]), 1.0)
    assert (found.low, found.high) == pytest.approx(stats.chi2.ppf([0.025, 0.975], [0.5, 2.5]) / 2 * 4)


def test_a_clustered_rate_is_the_plain_one_where_events_vary_less():
    assert clustered_rate(np.array([4.0, 3, 5]), 0.5) == rate(4, 0.5)
    assert clustered_rate(np.array([4.0]), 0.5) == rate(4, 0.5)
    assert clustered_rate(np.zeros(3), 0.0) == Estimate(None, None, None, 0)
