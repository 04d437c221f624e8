"""What can be left out of a failure, on constructed cases."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.search.minimising import all_at_once, leave_out


def found_by(needed: set[int], count: int) -> tuple[set[int], int]:
    """What is left where a set of items is needed, and how many trials it took."""
    trials = 0

    def try_out(owners, asked):
        nonlocal trials
        trials += len(asked)
        return np.array([not any(trial[item] for item in needed) for trial in asked])

    (out,) = all_at_once([leave_out(count)], try_out)
    return set(np.flatnonzero(~out).tolist()), trials


@pytest.mark.parametrize("needed", [set(), {0}, {11}, {3, 4}, {0, 5, 11}, set(range(12))])
def test_only_what_is_needed_is_left(needed):
    left, trials = found_by(needed, 12)
    assert left == needed
    assert trials <= 3 * 12 + 12


def test_nothing_to_leave_out():
    assert found_by(set(), 0) == (set(), 0)


def test_one_of_two_is_enough():
    """Either of two items will do: one of them is left, not both."""

    def try_out(owners, asked):
        return np.array([not (trial[1] and trial[6]) for trial in asked])

    (out,) = all_at_once([leave_out(9)], try_out)
    assert set(np.flatnonzero(~out).tolist()) in ({1}, {6})


def test_searches_run_side_by_side():
    """Each gets the answers to its own trials, in few rounds."""
    needed, rounds = [{0}, set(), {2, 7}], 0

    def try_out(owners, asked):
        nonlocal rounds
        rounds += 1
        return np.array([not any(t[i] for i in needed[o]) for o, t in zip(owners, asked, strict=True)])

    found = all_at_once([leave_out(8) for _ in needed], try_out)
    assert [set(np.flatnonzero(~out).tolist()) for out in found] == needed
    assert rounds < 16
