"""Numbers in pieces have the sums, order statistics and counts of all of them together."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxwalk.metrics import values as module
from jaxwalk.metrics.statistics import kaplan_meier_median, mean_of, quantile
from jaxwalk.metrics.values import Values, without_nan


def in_pieces(numbers, *cuts):
    """Numbers that are divided before these places."""
    pieces = np.split(np.asarray(numbers), cuts)
    return Values(lambda: iter(pieces))


@pytest.fixture(params=[1, 10**6], ids=["divided by their bits", "sorted in memory"])
def at_once(request, monkeypatch):
    monkeypatch.setattr(module, "SORTED", request.param)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@given(numbers=st.lists(st.floats(width=32, allow_nan=False), min_size=1, max_size=30), data=st.data())
def test_values_at_ranks_are_those_of_the_sorted_numbers(kind, numbers, data):
    count = len(numbers)
    cuts = sorted(data.draw(st.lists(st.integers(0, count), max_size=3)))
    ranks = data.draw(st.lists(st.integers(0, count - 1), min_size=1, max_size=4))
    for sorted_at_once in (1, 10**6):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, "SORTED", sorted_at_once)
            found = in_pieces(np.array(numbers, kind), *cuts).ordered(ranks)
        assert found == [sorted(numbers)[rank] for rank in ranks]


def test_equal_values_beyond_what_is_sorted(at_once):
    assert in_pieces([0.0, -0.0, 2.5, 2.5, 2.5, -1.0, 2.5], 3).ordered([6, 3, 0, 1]) == [2.5, 2.5, -1.0, 0.0]


@pytest.mark.parametrize("rank", [-1, 3])
def test_a_rank_that_is_not_there_is_refused(rank):
    with pytest.raises(IndexError, match="3 values have no ranks"):
        in_pieces([1.0, 2.0, 3.0], 2).ordered([0, rank])
    assert in_pieces([]).ordered([]) == []


def test_a_sum_is_rounded_once_however_the_numbers_are_divided():
    numbers = [1e16, 1.0, -1e16, 1.0]
    assert {in_pieces(numbers, *cuts).sum() for cuts in ((), (1,), (1, 2, 3))} == {2.0}
    assert np.add.accumulate(numbers)[-1] != 2.0


def test_counts_ends_and_different_values():
    values = in_pieces(np.array([3, 1, 3, 2, 3], np.int8), 0, 2)
    assert (values.count, values.ends()) == (5, (1.0, 3.0))
    different, counts = values.distinct()
    assert (different.tolist(), counts.tolist()) == ([1.0, 2.0, 3.0], [1, 1, 3])
    assert values.each(lambda piece: piece[piece > 1]).count == 4
    with pytest.raises(ValueError):
        in_pieces([]).ends()
    assert without_nan(np.array([np.nan, 1.0])).tolist() == [1.0]


def test_numbers_of_values_are_those_of_one_array(at_once):
    numbers = np.random.default_rng(0).normal(size=200).astype(np.float32)
    pieces = in_pieces(numbers, 20, 20, 150)
    assert mean_of(pieces) == mean_of(numbers)
    assert mean_of(numbers).value == pytest.approx(math.fsum(numbers.tolist()) / 200)
    assert quantile(pieces, 0.05) == quantile(numbers, 0.05)
    assert quantile(numbers, 0.05).value == pytest.approx(np.quantile(numbers.astype(float), 0.05))
    times, seen = np.round(numbers, 1), numbers > -0.5
    assert kaplan_meier_median(in_pieces(times, 90), in_pieces(seen, 90)) == kaplan_meier_median(times, seen)
