"""Percentiles of plausibility: uniform for ordinary scenarios, low for odd ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2, kstest

from jaxwalk import Street
from jaxwalk.scenarios.archived import scenarios_at
from jaxwalk.search.cube import ordinary
from jaxwalk.search.plausibility import ChoiceMade, DrawsUsed, draws_used, equivalent_squares, percentile, whose_draws
from jaxwalk.sim.person_kind import in_shares
from jaxwalk.sim.scenario import dimensions, parts
from jaxwalk.sim.sim_config import SimConfig


def test_numbers_are_compared_with_chi_squared():
    scores = np.full(10, 1.5)
    assert percentile(DrawsUsed(scores, ())) == pytest.approx(100 * chi2.sf(22.5, 10), abs=1.0)
    assert percentile(DrawsUsed(np.zeros(0), ())) == 100


def test_choices_count_by_their_probability():
    """By hand: the rare side of 5 % has half its own probability; the usual one all of the rarer and half its own."""
    rare, usual = equivalent_squares((0.05, 0.95))
    assert chi2.sf(rare, 1) == pytest.approx(0.025) and chi2.sf(usual, 1) == pytest.approx(0.05 + 0.475)
    assert equivalent_squares((0.5, 0.5)).tolist() == pytest.approx([chi2.isf(0.5, 1)] * 2)
    every = DrawsUsed(np.zeros(0), (ChoiceMade((0.05, 0.95), (4, 16)),))
    none = DrawsUsed(np.zeros(0), (ChoiceMade((0.05, 0.95), (0, 20)),))
    assert percentile(every) < 3 and percentile(none) == 100


@pytest.mark.parametrize(
    "changed",
    [
        {},
        {"pace_correlation": 0.5},
        {"kinds": in_shares(calm=0.3, hurried=0.7), "jaywalk_multiplier": 1.0},
        {"grouped": 0.4, "pedestrians": 5, "earlier_decisions": 3},
    ],
    ids=["plain", "correlated", "kinds", "groups"],
)
def test_ordinary_scenarios_have_uniform_percentiles(changed):
    street = Street.create(("paper",), replace(SimConfig(pedestrians=6), **changed))
    count = 300
    scenarios = scenarios_at(street, ordinary(np.random.default_rng(3), count, dimensions(street.world)))
    decisions = np.random.default_rng(4).integers(0, 4, (count, street.world.rules.pedestrians))
    found = [percentile(one) for one in draws_used(street, scenarios, decisions, range(count))]
    assert kstest(np.array(found) / 100, "uniform").statistic < 0.12
    assert np.mean(np.array(found) <= 5) == pytest.approx(0.05, abs=0.035)


def test_people_who_are_not_there_do_not_count(street):
    point = ordinary(np.random.default_rng(5), 1, dimensions(street.world))
    where = parts(street.world, np.arange(dimensions(street.world)))
    point[0, where.traits[1, 3]] = 1 - 2.0**-20
    absent = np.zeros((12, 1), bool)
    there = scenarios_at(street, point, absent)
    absent[3] = True
    left_out = scenarios_at(street, point, absent)
    decisions = np.zeros((1, 12), int)
    (odd,), (plain,) = (draws_used(street, each, decisions, [0]) for each in (there, left_out))
    assert len(odd.numbers) == len(plain.numbers) + 2
    assert percentile(odd) < percentile(plain)


def test_a_follower_whose_leader_is_not_there_moves_by_its_leaders_draws():
    leader = np.array([0, 0, 2, 2])
    own, decisions = whose_draws(leader, np.array([False, True, True, False]), np.array([0, 3, 1, 0]))
    assert own.tolist() == [True, False, True, False]
    assert decisions.tolist() == [3, 0, 1, 0]
