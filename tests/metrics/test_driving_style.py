"""Harsh braking, jerk and passing speeds against worked examples."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.metrics import COMFORT, PASSING, clustered_rate, measure, rate, summarise
from jaxwalk.sim.crossing_kind import CROSSWALK
from metrics.scenes import Scene, Walk, trajectory

NOBODY = Walk(0.0, 50.0)


def test_harsh_braking_is_counted_while_the_car_rolls():
    speed = [5.0, 5, 4.7, 4.4, 4.4, 4.1, 0, 0, 0]
    commands = {2: -3.0, 3: -2.5, 4: -2.4, 5: -3.0, 7: -3.0, 8: -3.0}
    rows = measure(trajectory(Scene(8, [NOBODY], speed=speed, acceleration=commands)))
    table = rows[COMFORT]
    assert (table.harsh.tolist(), table.events.tolist(), table.steps.tolist()) == (
        [3],
        [2],
        [8],
    )  # it stands from frame 6
    found = summarise(rows, resamples=20)[COMFORT]
    assert found.harsh.value == pytest.approx(3 / 8)
    metres = 0.1 * sum(speed[1:])
    assert (found.harsh_per_km.value, found.harsh_per_km.count) == (pytest.approx(2 / metres * 1000), 2)


def test_a_car_that_crawls_rolls():
    table = measure(trajectory(Scene(5, [NOBODY], speed=0.5, acceleration={3: -2.5})))[COMFORT]
    assert (table.harsh.tolist(), table.events.tolist()) == ([1], [1])


def test_jerk_is_the_change_of_acceleration():
    # accelerations 0, -3, -3, 0 m/s2: changes of -30, 0 and 30 m/s3
    rows = measure(trajectory(Scene(4, [NOBODY], speed=[5.0, 5, 4.7, 4.4, 4.4]), Scene(9, [NOBODY])))
    assert rows[COMFORT].jerks.tolist() == [3, 8]
    assert rows[COMFORT].jerk_squared.tolist() == pytest.approx([1800, 0])
    assert summarise(rows, resamples=20)[COMFORT].jerk.value == pytest.approx((1800 / 11) ** 0.5)


def test_events_that_come_together_are_fewer():
    assert clustered_rate(np.array([0.0, 0, 0]), 2.0) == rate(0, 2.0)
    alone, together = (clustered_rate(np.array([10.0, *draws]), 2.0) for draws in ([8, 12], [0, 20]))
    assert (alone.low, alone.high) == (rate(10, 2.0).low, rate(10, 2.0).high)
    # ten times the variance of independent events: as sure as one event in a tenth of the exposure
    assert (together.value, together.low, together.high) == (5, rate(1, 0.2).low, rate(1, 0.2).high)


def test_the_car_has_its_speed_where_it_was_nearest():
    # its front comes abreast at x = 2.3 in frame 5, at 3 m/s and 2.5 - 0.9 - 0.25 m aside; the other's gap is 2.85 m
    speed = [5.0, 5, 5, 5, 5, 3, 5, 5, 5]
    near, far = (Walk(4.5, y, crossings=[(1, 8, CROSSWALK)]) for y in (2.5, 4.0))
    below = Walk(4.5, 1.1, crossings=[(1, 8, CROSSWALK)])  # touched by the footprint, in a world of the disc
    rows = measure(
        trajectory(Scene(8, [near], speed=speed), Scene(8, [far]), Scene(8, [near], touched=[0]), Scene(8, [below]))
    )
    assert rows[PASSING].speed[:3].tolist() == pytest.approx([3, 5, 5])
    found = summarise(rows, resamples=20)[PASSING]
    assert [(one.near, one.far, one.speed.count) for one in found] == [(0, 0.5, 0), (0.5, 1, 0), (1, 2, 1), (2, 5, 1)]
    assert [one.speed.value for one in found] == [None, None, pytest.approx(3), pytest.approx(5)]


def test_a_passing_is_in_the_bin_of_its_gap_or_in_none():
    """Gaps of 5.35, 0.25 and 0.75 m: 1.15 m less than the distance to the side. The first is in no bin."""
    scenes = [Scene(8, [Walk(4.5, y, crossings=[(1, 8, CROSSWALK)])]) for y in (6.5, 1.4, 1.9)]
    found = summarise(measure(trajectory(*scenes)), resamples=20)[PASSING]
    assert [one.speed.count for one in found] == [1, 1, 0, 0]
