"""Intervals against published or exact numbers."""

from __future__ import annotations

import dataclasses
import importlib
import pkgutil
import warnings

import numpy as np
import pytest
from scipy import stats

from jaxwalk import metrics
from jaxwalk.metrics import statistics
from jaxwalk.metrics.statistics import (
    Estimate,
    bootstrap_by_episode,
    episode_sums,
    finite_or_none,
    interval,
    kaplan_meier_median,
    mean_of,
    quantile,
    ratio,
    sums_over_chunks,
)

MODULES = [importlib.import_module(f"jaxwalk.metrics.{found.name}") for found in pkgutil.iter_modules(metrics.__path__)]
KINDS = {x for module in MODULES for x in vars(module).values() if isinstance(x, type)}
DATACLASSES = {kind for kind in KINDS if "__dataclass_fields__" in vars(kind)}


@pytest.mark.parametrize("kind", sorted(DATACLASSES, key=str))
def test_numbers_and_tables_cannot_be_changed(kind):
    with pytest.raises(dataclasses.FrozenInstanceError):
        object.__new__(kind).anything = None


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


def test_two_parts_and_two_episodes_are_drawn_from(monkeypatch):
    assert set(episode_sums({"x": np.array([1.0, 2.0])}, resamples=50)["x"]) == {2, 3, 4}
    monkeypatch.setattr(statistics, "CHUNK", 8)
    sums = episode_sums({"one": np.ones(12)}, resamples=50)
    assert sums["one"].tolist() == [12] * 51


def test_columns_of_any_number_keep_their_shapes():
    columns = {"a": np.ones(3), "b": np.arange(6.0).reshape(3, 2), "c": np.arange(3.0), "d": np.ones((3, 1, 2))}
    sums = episode_sums(columns, resamples=4)
    assert [sums[name][0].tolist() for name in "abcd"] == [3, [6, 9], 3, [[3, 3]]]


@pytest.mark.parametrize("sizes", [[8], [8, 4, 4], [8, 3], [4, 8]])
def test_chunks_that_are_not_those_of_the_episodes_are_refused(monkeypatch, sizes):
    monkeypatch.setattr(statistics, "CHUNK", 8)  # 12 episodes are 8 and 4
    with pytest.raises(ValueError):
        sums_over_chunks([{"x": np.ones(size)} for size in sizes], 12, resamples=5)


def test_ends_of_an_interval_are_percentiles_of_the_resamples():
    found = interval(np.concatenate([[7.0], np.arange(1001.0)]), 3)
    assert (found.value, found.low, found.high, found.count) == (7, pytest.approx(25), pytest.approx(975), 3)


def test_ratio_and_interval_of_what_is_undefined():
    assert np.isnan(ratio(np.array([1.0, 0.0]), np.zeros(2))).all()
    assert interval(np.array([np.nan, 1.0]), 3).value is None
    assert [finite_or_none(x) for x in (2.5, np.inf, np.nan)] == [2.5, None, None]


def test_an_interval_allows_as_many_undefined_resamples_as_a_tail_holds():
    # of the middle half, a tail holds a quarter
    three, two = np.array([7, 1, 2, 3, np.nan]), np.array([7, 1, 2, np.nan, np.nan])
    assert interval(three, 5, confidence=0.5) == Estimate(7.0, 1.5, 2.5, 5)
    assert interval(two, 5, confidence=0.5) == Estimate(7.0, None, None, 5)
    assert interval(np.array([7.0, 6.0]), 5) == Estimate(7.0, 6.0, 6.0, 5)
    assert interval(np.array([7.0]), 5) == Estimate(7.0, None, None, 5)


def test_mean_of_has_the_t_interval():
    # 1, 2, 3: standard error 1 / sqrt(3), t with 2 degrees of freedom is 4.303
    found = mean_of(np.array([1.0, 2.0, 3.0]))
    assert (found.value, found.count) == (2, 3)
    assert (found.low, found.high) == pytest.approx((2 - 4.303 / 3**0.5, 2 + 4.303 / 3**0.5), abs=1e-3)
    assert mean_of(np.array([1.0, 2.0, 3.0]), within=(0.0, 4.0)).low == 0
    assert mean_of(np.array([1.0, 2.0, 3.0]), within=(0.0, 4.0)).high == 4
    assert mean_of(np.array([7.0, 7.0])) == Estimate(7.0, None, None, 2)
    assert mean_of(np.array([7.0])) == Estimate(7.0, None, None, 1)
    assert mean_of(np.array([])) == Estimate(None, None, None, 0)


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
