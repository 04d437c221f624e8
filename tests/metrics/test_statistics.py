"""Intervals against published or exact numbers."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy import stats

from jaxwalk.metrics import statistics
from jaxwalk.metrics.statistics import (
    Estimate,
    bootstrap_by_episode,
    episode_sums,
    holm,
    interquartile_mean,
    interval,
    kaplan_meier_median,
    mcnemar,
    over_seeds,
    quantile,
    ratio,
    wilson,
)


def test_wilson_of_the_papers_14_percent():
    rate = wilson(70, 500)
    assert (rate.value, rate.low, rate.high) == (0.14, pytest.approx(0.112, abs=5e-4), pytest.approx(0.173, abs=5e-4))


def test_wilson_at_the_edges():
    assert wilson(0, 0).value is None
    assert (wilson(0, 10).low, wilson(10, 10).high) == (0, pytest.approx(1))
    # a single success: centre (1 + z^2 / 2) / (1 + z^2), half width z / 2 * |z| / (1 + z^2)
    z2 = stats.norm.ppf(0.975) ** 2
    assert wilson(1, 1).low == pytest.approx(1 / (1 + z2))


def test_mcnemar():
    # 9 against 1 of 10 discordant pairs: 2 * (1 + 10) / 2^10
    a = np.array([True] * 9 + [False] + [True] * 5)
    b = np.array([False] * 9 + [True] + [True] * 5)
    assert mcnemar(a, b) == pytest.approx(22 / 1024)
    assert mcnemar(a, a) == 1.0
    with pytest.raises((ValueError, TypeError)):  # TypeError: where shapes are checked
        mcnemar(a, b[1:])


def test_bootstrap_of_a_mean_is_near_the_normal_interval():
    values = np.random.default_rng(1).normal(3, 1, 400)
    estimate = bootstrap_by_episode(values, np.ones(400), resamples=4000)
    half = 1.96 * values.std() / 20
    assert estimate.value == pytest.approx(values.mean())
    assert estimate.low == pytest.approx(values.mean() - half, abs=0.01)
    assert estimate.high == pytest.approx(values.mean() + half, abs=0.01)


def test_bootstrap_is_of_the_ratio_of_sums_not_the_mean_of_ratios():
    assert bootstrap_by_episode(np.array([1, 9]), np.array([1, 3])).value == 2.5


def test_bootstrap_where_little_is_known():
    assert bootstrap_by_episode(np.ones(3), np.zeros(3)).value is None
    assert bootstrap_by_episode(np.array([]), np.array([])).value is None
    alone = bootstrap_by_episode(np.array([2.0]), np.array([1.0]))
    assert (alone.value, alone.low, alone.high) == (2.0, None, None)
    # one episode in ten contributes: 35 % of the resamples miss it
    rare = bootstrap_by_episode(np.eye(10)[0], np.eye(10)[0])
    assert (rare.value, rare.low, rare.count) == (1.0, None, 1)


def test_resamples_draw_as_many_episodes_and_share_them():
    sums = episode_sums({"one": np.ones(30), "more": np.arange(60.0).reshape(30, 2)}, resamples=50)
    assert (sums["one"] == 30).all()
    assert sums["more"].shape == (51, 2)
    assert sums["more"][0].tolist() == [870, 900]
    # the second column is the first plus one, episode by episode: so are the sums, but for 30
    np.testing.assert_allclose(sums["more"][:, 1] - sums["more"][:, 0], 30)
    assert len(np.unique(sums["more"][:, 0])) > 30


def test_draws_of_many_episodes_are_made_in_parts_and_are_as_good(monkeypatch):
    columns = {"one": np.ones(50), "x": np.arange(50.0)}
    whole = episode_sums(columns, resamples=2000, seed=3)
    monkeypatch.setattr(statistics, "CHUNK", 8)  # 8 + ... + 8 + 2
    parts = episode_sums(columns, resamples=2000, seed=3)
    assert (parts["one"] == 50).all() and parts["x"][0] == whole["x"][0]
    expected = np.sqrt(50) * np.arange(50).std()
    assert [s["x"][1:].std() for s in (whole, parts)] == pytest.approx([expected] * 2, rel=0.06)
    assert parts["x"][1:].mean() == pytest.approx(parts["x"][0], rel=0.02)
    assert (episode_sums(columns, resamples=20, seed=4)["x"][1:] != parts["x"][1:21]).any()


def test_holm_on_a_worked_example():
    # Holm's procedure by hand: 0.005 x 4, 0.01 x 3, 0.03 x 2, and 0.04 x 1 is raised to the one before
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))
    assert holm([0.9, 0.8]) == (1.0, 1.0)
    assert holm([]) == ()


def test_ends_of_an_interval_are_percentiles_of_the_resamples():
    found = interval(np.concatenate([[7.0], np.arange(1001.0)]), 3)
    assert (found.value, found.low, found.high, found.count) == (7, pytest.approx(25), pytest.approx(975), 3)


def test_ratio_and_interval_of_what_is_undefined():
    assert np.isnan(ratio(np.array([1.0, 0.0]), np.zeros(2))).all()
    assert interval(np.array([np.nan, 1.0]), 3).value is None


def test_interquartile_mean_drops_a_quarter_at_either_end():
    assert interquartile_mean(np.array([100.0, 1, 2, 3, -50])) == 2
    assert interquartile_mean(np.array([0.0, 1, 5])) == 2  # a quarter of three is nobody
    assert interquartile_mean(np.array([[1.0, 2, 3, 9], [4, 4, 4, np.nan]])).tolist()[0] == 2.5
    assert np.isnan(interquartile_mean(np.array([4.0, 4, 4, np.nan])))


def test_over_seeds_of_one_seed_is_the_bootstrap_by_episode():
    over, under = np.random.default_rng(2).random((2, 1, 50))
    found = over_seeds(over, under)
    alone = bootstrap_by_episode(over[0], under[0])
    assert (found.mean.value, found.mean.low, found.mean.high) == (alone.value, alone.low, alone.high)
    assert found.iqm == found.mean
    assert found.each == (alone.value,)


def test_over_seeds_where_only_seeds_differ():
    """No episode matters: the ends are quantiles of means of five seeds drawn from 0, 0, 0, 0 and 1."""
    rates = np.repeat(np.eye(5)[0][:, None], 40, axis=1)
    found = over_seeds(rates, np.ones_like(rates), resamples=4000)
    assert (found.mean.value, found.iqm.value, found.mean.count) == (0.2, 0, 5)
    assert found.each == (1, 0, 0, 0, 0)
    often = stats.binom(5, 0.2).ppf([0.025, 0.975]) / 5
    assert (found.mean.low, found.mean.high) == pytest.approx(tuple(often))


def test_over_seeds_where_only_scenarios_differ():
    """Every seed ends alike in the same scenario: more seeds tell nothing more."""
    ends = (np.random.default_rng(3).random(400) < 0.3).astype(float)
    found = over_seeds(np.tile(ends, (5, 1)), np.ones((5, 400)))
    alone = over_seeds(ends[None], np.ones((1, 400)))
    assert (found.mean.low, found.mean.high) == pytest.approx((alone.mean.low, alone.mean.high))


def test_two_seeds_do_not_tell_how_much_seeds_differ():
    found = over_seeds(np.ones((2, 30)), np.ones((2, 30)))
    assert (found.mean.value, found.mean.low, found.iqm.low) == (1, None, None)
    three = over_seeds(np.ones((3, 30)), np.ones((3, 30)))
    assert (three.mean.low, three.mean.high) == (1, 1)


def test_a_seed_without_a_number_leaves_none_over_seeds():
    found = over_seeds(np.ones((3, 4)), np.array([[0.0] * 4, [1] * 4, [2] * 4]))
    assert (found.mean.value, found.iqm.value) == (None, None)
    assert found.each == (None, 1, 0.5)


def test_quantile_interval_covers():
    rng = np.random.default_rng(0)
    found = [quantile(rng.random(200), 0.05) for _ in range(300)]
    share = np.mean([e.low <= 0.05 <= e.high for e in found if e.low is not None and e.high is not None])
    assert share > 0.93
    assert quantile(np.array([]), 0.05) == Estimate(None, None, None, 0)
    assert quantile(np.array([7.0]), 0.05).value == 7.0


# Freireich et al. (1963), remission in weeks under 6-MP: median 23 in every textbook
WEEKS = np.array([6, 6, 6, 6, 7, 9, 10, 10, 11, 13, 16, 17, 19, 20, 22, 23, 25, 32, 32, 34, 35])
RELAPSED = np.array([1, 1, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0], bool)


def test_kaplan_meier_median_of_a_textbook_sample():
    estimate = kaplan_meier_median(WEEKS, RELAPSED)
    assert (estimate.value, estimate.low, estimate.high, estimate.count) == (23, 13, None, 21)


@pytest.mark.parametrize("subjects", [30, 40, 300])
def test_kaplan_meier_interval_is_that_of_greenwoods_band(subjects):
    rng = np.random.default_rng(5)
    times, seen = rng.exponential(10, subjects).round(1), rng.random(subjects) < 0.7
    with np.errstate(divide="ignore", invalid="ignore"):
        curve = stats.ecdf(stats.CensoredData.right_censored(times, ~seen)).sf
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # SciPy's, of where the curve is 1 or 0
            band = curve.confidence_interval(0.9, method="log-log")
    comes_down = [float(curve.quantiles[np.flatnonzero(x.probabilities <= 0.5)[0]]) for x in (band.low, band.high)]
    found = kaplan_meier_median(times, seen, confidence=0.9)
    assert [found.low, found.high] == comes_down
    assert found.low < found.value < found.high


def test_kaplan_meier_median_without_censoring_is_the_median():
    assert kaplan_meier_median(np.array([5, 1, 4, 2, 3]), np.ones(5, bool)).value == 3
    assert kaplan_meier_median(np.array([1, 2, 3, 4]), np.ones(4, bool)).value == 2  # one half is enough


def test_kaplan_meier_median_never_reached():
    assert kaplan_meier_median(np.array([1, 2, 3, 4, 5]), np.array([1, 0, 0, 0, 0], bool)).value is None
    assert kaplan_meier_median(np.array([1, 2]), np.zeros(2, bool)).value is None
    assert kaplan_meier_median(np.array([]), np.array([], bool)).value is None
