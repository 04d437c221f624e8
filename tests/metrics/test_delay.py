"""Delays against worked examples."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.metrics import DELAY, measure, summarise
from jaxwalk.metrics.delay import Unhindered
from metrics.scenes import Scene, Walk, trajectory


def _rows(times, *ends):
    rows = measure(trajectory(*(Scene(steps, [Walk(0.0, 9.0)], goal=goal) for steps, goal in ends)))
    return rows.having(DELAY, Unhindered(np.array(times)))


def test_delays_are_of_scenarios_in_which_both_arrive():
    # 1 s and 4 s late; one doesn't arrive, and of one it isn't known
    rows = _rows([9.0, 8.0, 1.0, np.nan], (100, True), (120, True), (30, False), (50, True))
    found = summarise(rows, resamples=200)[DELAY]
    assert (found.mean.value, found.mean.count) == (pytest.approx(2.5), 2)
    assert (found.mean.low, found.mean.high) == (None, None)  # one resample in sixteen has neither of them
    assert found.long.value == pytest.approx(1 + 0.95 * 3)
    assert found.long.count == 2


def test_a_recording_has_no_delay():
    found = summarise(measure(trajectory(Scene(100, [Walk(0.0, 9.0)], goal=True))))[DELAY]
    assert (found.mean.value, found.mean.count, found.long.value) == (None, 0, None)
