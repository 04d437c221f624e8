"""Numbers over streets by hand: which streets, which seeds, and which of them an interval is for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from jaxwalk.evaluation.over_streets import StreetScores, gap, share

RULE = StreetScores("rule", None, episodes=(10, 30), goal=(10, 15), touched=(0, 3))


def car(seed, goal, episodes=None):
    return StreetScores("car", seed, tuple(episodes or [10] * len(goal)), tuple(goal), (0,) * len(goal))


def test_streets_that_differ_leave_a_rule_a_wider_interval():
    """The same 100 of 200 goals, nearly evenly and with streets that are all or nothing."""
    even = replace(RULE, episodes=(10,) * 20, goal=(4, 6) * 10, touched=(0,) * 20)
    odd = replace(even, goal=(10, 0) * 10)
    found, wide = share([even], "goal"), share([odd], "goal")
    assert found.value == wide.value == 0.5
    assert wide.low < 0.4 < found.low < found.high < 0.6 < wide.high
    assert share([RULE], "touched").value == 3 / 40


def test_nothing_on_a_few_streets_proves_little():
    """Every street counts as one trial: 0 of 20, so up to 1 - 0.025 ** (1 / 20) (Clopper and Pearson)."""
    nothing = replace(RULE, episodes=(10,) * 20, goal=(10,) * 20, touched=(0,) * 20)
    found, goals = share([nothing], "touched"), share([nothing], "goal")
    assert (found.value, found.low) == (0, 0) and found.high == pytest.approx(1 - 0.025 ** (1 / 20))
    assert (goals.value, goals.high) == (1, 1) and goals.low == pytest.approx(0.025 ** (1 / 20))


def test_a_rule_on_one_street_has_no_interval():
    found = share([replace(RULE, episodes=(10,), goal=(4,), touched=(0,))], "goal")
    assert (found.value, found.low, found.high) == (0.4, None, None)


def test_few_seeds_have_no_interval():
    few = [car(seed, (9, 8)) for seed in range(4)]
    assert share(few, "goal").low is None
    assert gap([car(seed, (10,)) for seed in range(4)], few, "goal").low is None


def test_streets_count_as_much_as_seeds():
    """Cars of all seeds alike, streets that differ: five seeds say no more of other streets than one."""
    streets = (2, 10, 4, 8, 6, 10, 3, 9)
    five = share([car(seed, streets) for seed in range(5)], "goal")
    ten = share([car(seed, streets) for seed in range(10)], "goal")
    assert five.value == pytest.approx(52 / 80)
    assert ten.high - ten.low == pytest.approx(five.high - five.low, rel=0.2)
    assert five.high - five.low > 0.15


def test_the_gap_by_hand():
    """Own streets: 1.0, 0.9, ...; tests: 0.8 on average."""
    own = [car(seed, goal, (20,)) for seed, goal in enumerate([(20,), (18,), (20,), (18,), (19,)])]
    test = [car(seed, (82, 78), (100, 100)) for seed in range(5)]
    found = gap(own, test, "goal")
    assert found.value == pytest.approx(0.95 - 0.8)
    assert 0 < found.low < found.value < found.high
    seeds_alone = np.std([1, 0.9, 1, 0.9, 0.95], ddof=1) / np.sqrt(5) * 2.776
    assert found.high - found.value > seeds_alone, "the two streets of the test differ too"


def test_a_gap_needs_the_same_seeds():
    with pytest.raises(ValueError, match="same training seeds in the same order"):
        gap([car(1, (1,))], [car(2, (1,))], "goal")
