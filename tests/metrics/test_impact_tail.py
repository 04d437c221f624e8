"""The speed in the worst contacts, by hand and by simulation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from jaxwalk.metrics import IMPACT_TAIL, measure, summarise
from jaxwalk.metrics.impact_tail import impact_speeds, tail_mean, tail_parts, value_at_risk
from metrics.scenes import Scene, Walk, trajectory

NOBODY = Walk(0.0, 50.0)


def test_the_largest_quarter_of_ten_by_hand():
    """2.5 of ten values: (9 + 8 + 0.5 x 5) / 2.5 = 7.8; the edge is the third."""
    values = np.array([0, 0, 9, 1, 2, 0, 8, 5, 3, 4])
    assert value_at_risk(values, 0.75) == 5
    parts = tail_parts(values, 0.75)
    np.testing.assert_allclose(parts, np.where(values == 9, 21, np.where(values == 8, 17, 5)))
    assert parts.mean() == pytest.approx(7.8)
    found = tail_mean(values, 0.75)
    assert (found.value, found.low, found.high, found.count) == (pytest.approx(7.8), None, None, 3)


def test_a_tail_with_fewer_contacts_than_it_has_room_for_is_the_mean_times_its_share():
    values = np.zeros(400)
    values[:3] = 2, 4, 6
    assert value_at_risk(values) == 0
    assert tail_mean(values).value == pytest.approx(100 * 12 / 400)
    assert tail_mean(np.zeros(400)).value == 0
    whole = tail_mean(values, 0.0)
    assert whole.value == pytest.approx(12 / 400)


def test_it_grows_with_every_value_and_scales_with_them():
    random = np.random.default_rng(0)
    values = np.where(random.random(1000) < 0.1, random.uniform(1, 12, 1000), 0)
    found = tail_mean(values)
    assert tail_mean(2 * values).value == pytest.approx(2 * found.value)
    assert tail_mean(values + random.uniform(0, 1, 1000)).value > found.value
    assert values.mean() < value_at_risk(values) < found.value < values.max()


def test_its_interval_by_hand():
    """20 speeds from 5 to 24 m/s in 1,000 episodes: the ten fastest, 15 to 24, are the tail; the edge is 15."""
    values = np.concatenate([np.arange(5.0, 25.0), np.zeros(980)])
    found = tail_mean(values)
    assert found.value == pytest.approx(19.5)
    parts = np.concatenate([15 + 100 * np.arange(10.0), np.full(990, 15.0)])
    half = stats.t.ppf(0.975, 9) * parts.std(ddof=1) / math.sqrt(1000) / 19.5
    assert (found.low, found.high) == (pytest.approx(19.5 * math.exp(-half)), pytest.approx(19.5 * math.exp(half)))
    assert found.count == 10


def test_its_interval_covers():
    """1 % of contacts at 1 to 12 m/s: on average 6.5 m/s in the worst hundredth."""
    random, held = np.random.default_rng(3), 0
    for _ in range(400):
        hit = random.random(2000) < 0.01
        found = tail_mean(np.where(hit, random.uniform(1, 12, 2000), 0))
        held += found.low is not None and found.high is not None and found.low <= 6.5 <= found.high
    assert 0.90 < held / 400 < 0.98


def test_of_recorded_episodes():
    """Two contacts of four episodes, at 4.4 and 3 m/s; the worst hundredth is a part of the worst one."""
    slowing, hit = [5.0, 5, 4.7, 4.4, 4.4], Walk(2.0, 0.0)
    hits = Scene(4, [hit], speed=slowing, touched=[0]), Scene(5, [hit], speed=3.0, touched=[0])
    rows = measure(trajectory(hits[0], Scene(9, [NOBODY]), hits[1], Scene(9, [NOBODY])))
    np.testing.assert_allclose(impact_speeds(rows), [4.4, 0, 3.0, 0], rtol=1e-6)
    found = summarise(rows, resamples=20)[IMPACT_TAIL]
    assert found.worst_hundredth.value == pytest.approx(4.4)
    assert found.worst_hundredth.count == 1
    assert found.exceeded_by_a_hundredth == pytest.approx(4.4)
    assert found.mean == pytest.approx(7.4 / 4)


def test_slow_contacts_count_and_equal_ones_have_no_interval():
    slow = np.zeros(400)
    slow[:3] = 0.5  # the tail has room for four
    assert tail_mean(slow).count == 3
    equal = tail_mean(np.full(1000, 5.0))
    assert (equal.value, equal.low, equal.high, equal.count) == (5, None, None, 10)
