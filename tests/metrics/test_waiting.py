from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from jaxwalk.metrics import WAITING, Rows, measure, summarise
from jaxwalk.metrics.waiting import DANGER, DISTANCES, HARMLESS, MISSES, OTHER, SPEEDS
from jaxwalk.sim.crossing_kind import CROSSWALK
from metrics.reference import kerb_moments
from metrics.scenes import Scene, Walk, changed, trajectory
from metrics.test_properties import few, trajectories


def waiting(*scenes):
    return summarise(measure(trajectory(*scenes)), resamples=50)[WAITING]


def test_bins_are_those_of_results_made_before():
    assert DISTANCES == (0, 5, 10, 15, 20, 25, 30, 35, 40)
    assert SPEEDS == (0, 2, 4, 6, 8.33)
    assert MISSES == (0, 1, 2.5, 5)


def test_a_wait_shows_in_the_next_frame():
    # the car is at 2.0, 2.5, 3.0 m in frames 4, 5, 6
    people = [
        Walk(20.0, -5.0, kerb=[4, 5, 6], waits=[5, 7], miss=1.0),  # in danger
        Walk(60.0, -5.0, kerb=[4, 5], waits=[4, 6], miss=1.0),  # far away
        Walk(-5.0, -5.0, kerb=[4], waits=[4], miss=1.0),  # past
        Walk(1.0, -5.0, kerb=[4], waits=[5], miss=1.0),  # beside the car
        Walk(20.0, -5.0, kerb=[4], miss=3.0),  # the car will miss
    ]
    found = waiting(Scene(10, people, speed=5.0))
    assert (found.danger.value, found.danger.count) == (pytest.approx(2 / 3), 3)
    assert (found.harmless.value, found.harmless.count) == (pytest.approx(1 / 3), 3)
    assert (found.other.value, found.other.count) == (0.5, 2)


@pytest.mark.parametrize(
    ("x", "speed", "miss", "setting"),
    [
        (39.9, 5.0, 2.0, DANGER),
        (40.0, 5.0, 2.0, HARMLESS),
        (0.1, 5.0, 2.0, DANGER),
        (0.0, 5.0, 2.0, OTHER),
        (-2.5, 5.0, 2.0, OTHER),
        (-2.6, 5.0, 2.0, HARMLESS),
        (10.0, 2.0, 2.0, OTHER),
        (10.0, 2.1, 2.0, DANGER),
        (10.0, 5.0, 2.4, DANGER),
        (10.0, 5.0, 2.5, OTHER),
    ],
)
def test_the_limits_of_danger(x, speed, miss, setting):
    rows = measure(trajectory(Scene(5, [Walk(x, 0.0, kerb=[0], miss=miss)], speed=speed)))
    np.testing.assert_array_equal(rows[WAITING].moments, [[s == setting for s in (DANGER, HARMLESS, OTHER)]])


def test_no_moment_in_the_last_frame_after_it_or_before_a_turn():
    scene = Scene(5, [Walk(20.0, 0.0, kerb=[4, 5, 6, 7], waits=[5, 6, 7])])
    recorded = trajectory(scene, Scene(9, [Walk(20.0, 0.0)]))
    assert measure(recorded)[WAITING].moments.sum() == 1
    turning = changed(recorded, enters_roadway=np.zeros_like(recorded.at_kerb))
    assert measure(turning)[WAITING].moments.sum() == 0


def test_rates_by_distance_and_speed_and_predicted_miss():
    people = [
        Walk(4.9, 0.0, kerb=[0, 1, 2, 3], waits=[1], miss=0.5),  # the car stands at 0 m: all in one bin
        Walk(5.0, 0.0, kerb=[0, 1], waits=[1, 2], miss=1.0),
        Walk(39.0, 0.0, kerb=[0], waits=[1], miss=7.0),
        Walk(-1.0, 0.0, kerb=[0], waits=[1], miss=0.5),  # not ahead: in no bin
        Walk(41.0, 0.0, kerb=[0], waits=[1], miss=0.5),  # nor within 40 m
    ]
    fast = Scene(5, [Walk(11.0, 0.0, kerb=[0], waits=[1], miss=2.5), *[Walk(9.0, 0.0)] * 4], speed=9.0)
    found = waiting(Scene(5, people, speed=0.0), fast)
    table = {
        (row.begin, row.end, miss): (rate.value, rate.count)
        for rows in (found.by_distance, found.by_speed)
        for row in rows
        for miss, rate in zip(MISSES, row.rates, strict=True)
        if rate.count
    }
    assert table == {
        (0, 5, 0): (0.25, 4), (5, 10, 1): (1, 2), (35, 40, 5): (1, 1), (10, 15, 2.5): (1, 1),
        (0, 2, 0): (0.25, 4), (0, 2, 1): (1, 2), (0, 2, 5): (1, 1), (6, 8.33, 2.5): (1, 1),
    }  # fmt: skip


@pytest.mark.parametrize(("x", "y", "count"), [(0.0, 3.0, 0), (0.5, 0.0, 1), (39.9, 0.0, 1), (40.0, 0.0, 0)])
def test_bins_hold_who_is_ahead_of_the_car_and_within_40_m(x, y, count):
    table = measure(trajectory(Scene(5, [Walk(x, y, kerb=[0])], speed=0.0)))[WAITING]
    assert (table.distance_moments.shape, table.speed_moments.shape) == ((1, 8, 4), (1, 4, 4))
    assert (table.distance_moments.sum(), table.speed_moments.sum()) == (count, count)


@few
@given(trajectories)
def test_counts_agree_with_the_reference(recorded):
    wide = {name: 4 * getattr(recorded, name) for name in ("car_x", "car_y", "ped_x", "ped_y", "car_speed")}
    recorded = changed(recorded, **wide)
    table = measure(recorded)[WAITING]
    expected = kerb_moments(recorded, DISTANCES, SPEEDS, MISSES)
    for name, cells in expected.items():
        counts = getattr(table, name)
        assert counts.sum() == sum(cells.values())
        assert all(counts[cell] == count for cell, count in cells.items())


def test_metres_per_second_of_all_pedestrians():
    long = Scene(20, [Walk(0.0, 9.0, vx=0.6, vy=0.8), Walk(0.0, 9.0)])
    short = Scene(10, [Walk(0.0, 9.0, vx=2.0), Walk(0.0, 9.0)])
    pace = waiting(long, short).pace
    assert (pace.value, pace.count) == (pytest.approx((2 * 1.0 + 1 * 2.0) / (2 * 2.0 + 2 * 1.0)), 4)


def test_the_share_of_all_steps_that_were_waits():
    found = waiting(Scene(8, [Walk(0.0, 9.0, waits=[0, 1, 2, 8, 9]), Walk(0.0, 9.0)]), Scene(12, [Walk(0.0, 9.0)] * 2))
    assert (found.waited.value, found.waited.count) == (pytest.approx(3 / (2 * 8 + 2 * 12)), 40)


def test_the_longest_stand_on_a_roadway():
    people = [
        Walk(0.0, 9.0, crossings=[(2, 20, CROSSWALK)], waits=[*range(1, 5), *range(10, 17), *range(18, 30)]),
        Walk(0.0, 9.0, waits=range(30)),  # on a sidewalk
    ]
    cut = Scene(14, people)  # its end comes after 5 of the 7 steps
    assert measure(trajectory(Scene(40, people), cut))[WAITING].longest_stand.tolist() == [7, 5]
    assert waiting(Scene(40, people), cut).longest_stand == 7
    assert waiting(Scene(40, [Walk(0.0, 9.0, crossings=[(2, 20, CROSSWALK)])])).longest_stand == 0


def test_intervals_are_over_episodes():
    patient, hasty = ([Walk(20.0, 0.0, kerb=range(k), waits=w, miss=1.0)] for k, w in ((3, range(9)), (2, [])))
    rows = measure(trajectory(*[Scene(9, patient), Scene(9, hasty)] * 10))
    found = summarise(Rows.join([rows, rows]))[WAITING].danger
    assert (found.value, found.count) == (0.6, 100)
    # an episode of 2.5 moments has 1.2 waits more or less than 60 % of its moments; of 100 moments apart, error 0.049
    error = 1.2 / 2.5 / 40**0.5
    assert (found.low, found.high) == pytest.approx((0.6 - 2 * error, 0.6 + 2 * error), abs=0.02)


def test_the_trials_of_what_never_happened_are_the_episodes_in_which_it_could():
    # none of n trials: the exact interval ends at 1 - 0.025^(1 / n)
    danger = [Scene(steps, [Walk(20.0, 0.0, kerb=range(steps), miss=1.0)]) for steps in (1, 3, 7)]
    found = waiting(*danger, Scene(20, [Walk(0.0, 9.0)]))
    assert (found.danger.count, found.waited.count) == (1 + 3 + 7, 1 + 3 + 7 + 20)
    assert found.danger.high == pytest.approx(1 - 0.025 ** (1 / 3))
    assert found.waited.high == pytest.approx(1 - 0.025 ** (1 / 4))


def test_what_never_happened_has_no_rate():
    found = waiting(Scene(5, [Walk(0.0, 9.0)]))
    rates = [found.danger, found.harmless, found.other, *(r for row in found.by_distance for r in row.rates)]
    assert all((rate.value, rate.count) == (None, 0) for rate in rates)
    assert found.pace.value == 0
