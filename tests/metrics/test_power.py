"""Numbers of scenarios, against a textbook's and against simulated tests."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.metrics import mcnemar, scenarios_needed


def test_the_papers_14_and_16_percent():
    # by hand: s = 0.14 + 0.16 - 2 * 0.0224 = 0.2552, d = 0.02;
    # (1.959964 * 0.505173 + 0.841621 * 0.504777)^2 / 0.0004 = 5005.2
    assert scenarios_needed(0.14, 0.16) == 5006


def test_more_difference_power_or_likeness_asks_for_fewer():
    base = scenarios_needed(0.02, 0.04)
    assert scenarios_needed(0.02, 0.05) < base < scenarios_needed(0.02, 0.04, power=0.9)
    assert scenarios_needed(0.02, 0.04, both=0.015) < base
    assert scenarios_needed(0.04, 0.02) == base


@pytest.mark.parametrize(("a", "b", "both"), [(0.05, 0.09, 0.02), (0.14, 0.2, None)])
def test_simulated_tests_find_it_as_often_as_said(a, b, both):
    n = scenarios_needed(a, b, both=both)
    both = a * b if both is None else both
    kinds = np.random.default_rng(0).choice(4, (400, n), p=[both, a - both, b - both, 1 - a - b + both])
    found = np.mean([mcnemar(row <= 1, (row == 0) | (row == 2)) < 0.05 for row in kinds])
    assert 0.72 < found < 0.86  # the exact test is a little careful


@pytest.mark.parametrize(
    ("rates", "said"),
    [
        ((0.1, 0.1), "told apart"),
        ((0.6, 0.7, 0.1), "impossible"),
        ((0.1, 0.2, 0.15), "impossible"),
        ((1.2, 0.1), "impossible"),
    ],
)
def test_impossible_questions_are_refused(rates, said):
    with pytest.raises(ValueError, match=said):
        scenarios_needed(rates[0], rates[1], both=rates[2] if len(rates) > 2 else None)


def test_one_may_happen_only_where_the_other_does():
    # s = d = 0.1: (1.959964 * 0.316228 + 0.841621 * 0.3)^2 / 0.01 = 76.1
    assert scenarios_needed(0.1, 0.2, both=0.1) == 77
    assert scenarios_needed(0.1, 0.2, both=0.0) > scenarios_needed(0.1, 0.2)
    assert scenarios_needed(1.0, 0.8) > 0


def test_rates_of_which_one_happens_in_every_scenario():
    """9,984 goals in both, 11 and 5 alone: the shares add up to 1, but for rounding."""
    assert scenarios_needed(0.9995, 0.9989, both=0.9984) > 10_000
