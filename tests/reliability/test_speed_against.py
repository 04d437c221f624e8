"""The bound that `speed_against.py` prints."""

import numpy as np

from reliability.speed_against import lower_bound, take_turns
from reliability.speed_worker import NAMES, module


def test_the_bound_is_below_the_median_nineteen_times_in_twenty():
    draws = np.random.default_rng(0).lognormal(size=(2000, 20))  # median 1
    share = np.mean([lower_bound(list(x)) <= 1 for x in draws])
    assert 0.95 <= share <= 0.995  # an order statistic can't meet 0.95 exactly: 0.979 for 20 values


def test_too_few_turns_have_no_bound():
    assert lower_bound([1.0] * 4) is None
    assert lower_bound([5.0, 2.0, 4.0, 3.0, 1.0]) == 1.0


def test_old_and_new_take_turns_and_the_first_one_alternates():
    calls = []
    program = lambda name, speed: lambda: (calls.append(name), speed)[1]  # noqa: E731
    assert take_turns(program("old", 2.0), program("new", 3.0), 3) == [(2.0, 3.0)] * 3
    assert calls == ["old", "new", "new", "old", "old", "new"]


def test_the_worker_finds_its_modules():
    assert [module(name).__name__ for name in NAMES] == [now for now, _ in NAMES.values()]
