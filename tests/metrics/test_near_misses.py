"""Contacts extrapolated from near misses: tails whose truth is known, and what cannot be extrapolated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from jaxwalk.metrics import NEAR_MISSES, Estimate, measure
from jaxwalk.metrics.near_misses import FEWEST, THRESHOLDS, UNLIKELY, Tail, _checked, _overlap, _rate, extrapolate
from jaxwalk.metrics.pareto_tail import ParetoFit, fit
from jaxwalk.sim.crossing_kind import CROSSWALK
from metrics.excesses import once
from metrics.scenes import Scene, Walk, trajectory


def _excesses(shape, beyond, count, seed=0):
    """Evenly spread excesses over 1, of which this share would be 1 or more; those are left out."""
    scale = shape / (beyond**-shape - 1) if shape else -1 / np.log(beyond)
    quantiles = (np.arange(count) + 0.5) / count * (1 - beyond)
    return once(stats.genpareto.ppf(quantiles, shape, scale=scale))


@pytest.mark.parametrize(("shape", "beyond"), [(-0.3, 0.02), (0.0, 0.01), (0.2, 0.01)])
def test_a_tail_is_found_again(shape, beyond):
    found = fit(_excesses(shape, beyond, 20_000), 1.0)
    assert found.shape == pytest.approx(shape, abs=0.02)
    assert found.ratio == pytest.approx(beyond / (1 - beyond), rel=0.06)
    assert found.low < found.ratio < found.high < 3 * found.low
    assert found.p > 0.99


def test_a_tail_of_another_form_fits_poorly():
    clusters = np.concatenate([np.linspace(0.01, 0.02, 500), np.linspace(0.5, 0.51, 500)])
    assert fit(once(clusters), 1.0).p < UNLIKELY


def test_contacts_per_episode_by_hand():
    """100 near misses in 1,000 episodes, a hundredth as many contacts; ends that a fit doesn't have."""
    bounds_nothing = ParetoFit(ratio=0.01, low=0.0, high=None, shape=0.1, p=0.5)
    found = _rate(100, 1000, bounds_nothing)
    assert (found.value, found.low, found.high, found.count) == (pytest.approx(0.001), 0.0, None, 100)
    found = _rate(100, 1000, replace(bounds_nothing, low=0.005, high=0.02))
    # on the scale of logarithms, a factor of 2 and the share's own (Wilson: 8.291 to 12.015 %) add up as squares do
    assert found.low == pytest.approx(0.001 * np.exp(-np.hypot(np.log(2), np.log(10 / 8.291))), rel=1e-3)
    assert found.high == pytest.approx(0.001 * np.exp(np.hypot(np.log(2), np.log(12.015 / 10))), rel=1e-3)


def test_the_unit_of_length_does_not_matter():
    excesses = _excesses(-0.1, 0.05, 300)
    threefold = replace(excesses, size=3 * excesses.size)
    assert fit(threefold, 3.0).ratio == pytest.approx(fit(excesses, 1.0).ratio, rel=1e-3)


def test_a_tail_that_ends_before_a_contact_may_have_none():
    found = fit(once(stats.genpareto.ppf((np.arange(300) + 0.5) / 300, -0.5, scale=0.3)), 1.0)  # it ends at 0.6
    assert (found.low, found.high) == (0.0, pytest.approx(0, abs=0.002))


def test_what_is_as_frequent_near_a_contact_as_farther_away_bounds_nothing():
    found = extrapolate(np.linspace(0.001, 1.999, 2000))
    assert (found.extrapolated.value, found.threshold, found.agrees) == (None, None, None)
    assert {tail.problem for tail in found.tails} == {"no upper bound"}


def _gaps(count, contacts, episodes=10_000):
    """Episodes with near misses that have an exponential tail, 2 % of which would reach a contact; and contacts."""
    gaps = np.full(episodes, np.nan)
    gaps[:count] = max(THRESHOLDS) * (1 - _excesses(0.0, 0.02, count).size)
    gaps[count : count + contacts] = 0
    return gaps


def test_observed_contacts_check_what_is_extrapolated_and_have_no_part_in_it():
    right, wrong = (extrapolate(_gaps(1000, contacts)) for contacts in (20, 400))
    assert right.threshold == max(THRESHOLDS)
    assert right.extrapolated.value == pytest.approx(0.1 * 0.02 / 0.98, rel=0.05)
    assert right.extrapolated == wrong.extrapolated
    assert (right.observed.value, right.agrees, wrong.agrees) == (0.002, True, False)


def test_few_near_misses_are_not_extrapolated():
    found = extrapolate(_gaps(FEWEST - 1, 3))
    assert (found.problem, found.extrapolated.count) == ("few near misses", FEWEST - 1)
    assert {tail.fit for tail in found.tails} == {None}


def test_a_threshold_is_unstable_if_a_lower_one_finds_something_else():
    def tail(threshold, low, high, problem="none"):
        return Tail(threshold, 0.1, 0.5, Estimate((low + high) / 2, low, high, 200), problem)

    high, poor = tail(2.0, 0.001, 0.002), tail(1.5, 0.1, 0.2, "poor fit")
    assert [x.problem for x in _checked([high, tail(1.0, 0.0015, 0.01)])] == ["none", "none"]
    assert [x.problem for x in _checked([high, poor, tail(1.0, 0.01, 0.02)])] == ["unstable", "poor fit", "none"]
    assert [x.problem for x in _checked([high, tail(1.0, 0.01, 0.02)])] == ["unstable", "none"]
    assert [x.problem for x in _checked([high, tail(1.0, 0.002, 0.02)])] == ["none", "none"], "one end in common"


def test_an_end_that_is_unknown_is_open():
    rare, often = Estimate(0.0015, 0.001, 0.002, 200), Estimate(0.015, 0.01, 0.02, 200)
    assert not _overlap(rare, often)
    assert _overlap(replace(rare, high=None), often)
    assert not _overlap(rare, replace(often, high=None))
    assert _overlap(rare, replace(often, low=None))
    assert not _overlap(replace(rare, low=None), often)


def test_there_are_never_more_contacts_than_episodes():
    found = _rate(1000, 1000, ParetoFit(ratio=3.0, low=2.0, high=4.0, shape=0.1, p=0.5))
    assert (found.value, found.high) == (1.0, 1.0)


def test_the_gap_is_the_smallest_while_the_car_moves():
    touched, near, far = (Walk(4.5, y, crossings=[(1, 8, CROSSWALK)]) for y in (1.0, 2.5, 4.0))
    slow = [5.0] + [0.3] * 8  # below 0.5 m/s, closing in
    scenes = Scene(8, [near, far]), Scene(8, [touched, far]), Scene(8, [near, far], speed=slow), Scene(8, [far, far])
    gap = measure(trajectory(*scenes))[NEAR_MISSES].gap
    assert gap == pytest.approx([2.5 - 0.9 - 0.25, 0, np.nan, 4.0 - 0.9 - 0.25], nan_ok=True)


def test_near_misses_are_counted_below_each_threshold_and_without_contacts():
    gaps = np.array([0, 0.25, 0.5, 0.5, 0.75, 1.25, 2.0, 3.0, np.nan])
    found = extrapolate(gaps)
    assert [(tail.threshold, tail.rate.count) for tail in found.tails] == [
        (2, 5),
        (1.5, 5),
        (1, 4),
        (0.75, 3),
        (0.5, 1),
    ]
    assert (found.observed.successes, found.observed.trials) == (1, 9)


def test_a_hundred_near_misses_are_enough_and_the_largest_threshold_says_what_the_problem_is():
    found = extrapolate(np.linspace(0.001, 1.999, 100))  # 75 of them below 1.5 m
    assert [tail.problem for tail in found.tails] == ["no upper bound"] + ["few near misses"] * 4
    assert (found.problem, found.extrapolated.count) == ("no upper bound", 100)


def test_a_car_at_just_the_moving_speed_moves():
    near = Walk(4.5, 2.5, crossings=[(1, 8, CROSSWALK)])
    assert np.isfinite(measure(trajectory(Scene(8, [near], speed=0.5)))[NEAR_MISSES].gap).all()
