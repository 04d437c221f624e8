"""Contacts of the car's rectangle with people's bodies: worked out by hand, and beside a simulation in small steps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jaxwalk.metrics import measure, summarise
from jaxwalk.metrics.contacts import MEASURED_CONTACTS, touched_while_moving
from jaxwalk.metrics.footprint import FRONT, REAR, SIDE, reach, time_to_collision, time_to_contact, touched_part
from jaxwalk.sim import events
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK, ContactKind
from jaxwalk.sim.sim_config import SimConfig
from metrics.scenes import Scene, Walk, changed, trajectory

CAR = SimConfig()
number = st.integers(-1000, 1000).map(lambda n: n / 100)


def contacts(*scenes, config=CAR):
    return measure(trajectory(*scenes), config=config)[MEASURED_CONTACTS]


def summary(*scenes, config=CAR):
    return summarise(measure(trajectory(*scenes), config=config), resamples=50)[MEASURED_CONTACTS]


def touching(ahead, left):
    return events.to_rectangle(ahead, left, CAR.car_length, CAR.car_width) < CAR.body_radius


def when(ahead, left, v_ahead, v_left):
    return time_to_contact(*(np.array([float(x)]) for x in (ahead, left, v_ahead, v_left)), CAR)[0]


@pytest.mark.parametrize(
    ("ahead", "left", "metres"),
    [(0, 0, 0), (2.25, 0.9, 0), (5.25, 0, 3), (-5.25, 0.9, 3), (0, 1.9, 1), (0, -1.9, 1), (5.25, 4.9, 5)],
)
def test_the_distance_to_the_rectangle(ahead, left, metres):
    assert events.to_rectangle(ahead, left, 4.5, 1.8) == pytest.approx(metres)


def test_times_to_contact_by_hand():
    assert when(12.5, 0, -5, 0) == pytest.approx(2)  # 2.5 m are the front and the body
    assert when(12.5, 0.9, -5, 0) == pytest.approx(2)  # straight in front of the corner
    assert when(12.5, 1.1, -5, 0) == pytest.approx((12.5 - 2.4) / 5)  # the corner meets a round body, 0.2 m aside
    assert when(12.5, 1.16, -5, 0) == math.inf


def test_times_to_contact_of_the_fast_and_the_slanting():
    assert when(4.5, 0, -20, 0) == pytest.approx(0.1)  # and out again at the rear after 0.35 s
    assert when(3.5, 1, -1, -1) == pytest.approx(1)  # at the middle of the front, far from its corners
    assert when(3.5, 1, -0.5, -0.5) == pytest.approx(2)
    assert when(3.6, 0, -1, 1) == math.inf  # 0.32 m past the corner
    assert when(-4.5, 0, -20, 0) == math.inf  # it was touched before


def test_who_just_touches_the_side_touches_it_now():
    wide = SimConfig(car_width=2.0, body_radius=0.25)
    now, never = (time_to_contact(*np.array([[0.0], [y], [0.0], [0.0]]), wide)[0] for y in (1.25, 1.2501))
    assert (now, never) == (0, math.inf)


@pytest.mark.parametrize(
    ("place", "velocity", "seconds"),
    [
        ((3, 1), (-1, 0), 3),  # it grazes the disc of 1 m
        ((3, 0), (-0.1, 0), 20),
        ((1.2, 0), (-1, 0), 0.2),
        ((0.9, 0), (1, 0), 0),  # within it
        ((1, 0), (1, 0), math.inf),  # at its edge, and off
        ((3, 0), (0, 0), math.inf),
    ],
)
def test_times_to_collision_of_discs_by_hand(place, velocity, seconds):
    found = time_to_collision(*(np.array([float(x)]) for x in (*place, *velocity)), 1.0)[0]
    assert found == pytest.approx(seconds)


def test_a_body_beside_the_car():
    assert when(0, 3.15, 0, -1) == pytest.approx(2)
    assert when(0, -3.15, 0, 1) == pytest.approx(2)
    assert when(0, 3.15, 0, 1) == math.inf
    assert when(0, 1, 0, 0) == 0
    assert when(0, 3, 0, 0) == math.inf


@given(number, number, number, number)
def test_the_time_to_contact_is_that_of_small_steps(ahead, left, v_ahead, v_left):
    found = when(ahead, left, v_ahead, v_left)
    times = np.linspace(0, 4, 4001)
    touched = np.flatnonzero(touching(ahead + v_ahead * times, left + v_left * times))
    if len(touched):
        assert found == pytest.approx(times[touched[0]], abs=2e-3)
    elif found < 4:  # between two steps it may graze a corner
        place = np.array([ahead + v_ahead * found, left + v_left * found])
        assert events.to_rectangle(*place, CAR.car_length, CAR.car_width) == pytest.approx(CAR.body_radius, abs=1e-6)


@pytest.mark.parametrize(
    ("before", "after", "part", "place"),
    [
        ((3, 0), (2, 0), FRONT, 50),
        ((3, 0.45), (2, 0.45), FRONT, 75),
        ((3, -0.9), (2, -0.9), FRONT, 0),
        ((3, -1.1), (2, -1.1), FRONT, 0),  # its body reaches beyond the edge
        ((3, 0.5), (2, -0.5), FRONT, 50),  # half of the way is made when the front touches it
        ((-3, 0.45), (-2, 0.45), REAR, 75),
        ((0, 1.3), (0, 1.1), SIDE, math.nan),
        ((1, -2), (1.5, -1), SIDE, math.nan),
        ((3, 1.3), (2, 1.1), SIDE, math.nan),  # in front after half of the way, but wide of the side until 3/4 of it
    ],
)
def test_which_part_is_touched_and_where(before, after, part, place):
    found, where = touched_part(*(np.array([float(x)]) for x in (*after, *before)), CAR)
    assert found[0] == part
    assert where[0] == pytest.approx(place, nan_ok=True)


def test_a_corner_that_is_met_from_both_sides_at_once_belongs_to_the_front():
    # the front and the body reach 2.5 m, the side and the body 1 m: both after half of the way
    narrow = SimConfig(car_length=4.5, car_width=1.5, body_radius=0.25)
    part, place = touched_part(*np.array([[2.0], [0.5], [3.0], [1.5]]), narrow)
    assert (part[0], place[0]) == (FRONT, 100)


def test_a_body_in_front_is_touched_before_the_disc_and_counts_once():
    # at 5 m/s the front (2.25 m) and the body (0.25 m) reach somebody standing 10 m ahead after 1.5 s, within the step
    # to frame 16; the centres are nearer than 1.5 m from frame 18 on (1.0 m)
    table = contacts(Scene(60, [Walk(10, 0, crossings=[(3, 60, JAYWALK)])]))
    assert table.rule.tolist() == [0, 1]
    assert table.frame.tolist() == [18, 16]
    assert table.part.tolist() == [FRONT, FRONT]
    assert table.hit_point == pytest.approx([50, 50])
    assert table.car_speed == pytest.approx([5, 5])
    assert table.relative_speed == pytest.approx([5, 5])
    assert table.type.tolist() == [JAYWALK, JAYWALK]
    assert table.moving.all()


def test_who_is_passed_at_arms_length_is_touched_by_neither():
    assert len(contacts(Scene(60, [Walk(10, 1.6)])).episode) == 0
    beside = contacts(Scene(60, [Walk(10, 1.4)]))  # within 1.5 m of the centre, but 0.25 m beside the car
    assert beside.rule.tolist() == [0]
    assert beside.type.tolist() == [ContactKind.SIDEWALK]


def test_who_walks_into_a_standing_car_is_told_apart():
    # from 4 m to the left at 1 m/s: the side of the car and the body are 1.15 m wide
    walker = Scene(60, [Walk(0, 4, vy=-1, crossings=[(1, 60, CROSSWALK)])], speed=0)
    found = summary(walker, Scene(60, [Walk(10, 0, crossings=[(3, 60, JAYWALK)])]))
    footprint = found.footprint
    assert (footprint.contacts, footprint.standing, footprint.episodes.successes) == (2, 1, 2)
    assert (footprint.moving.successes, footprint.moving.trials) == (1, 2)
    assert (footprint.crosswalk, footprint.jaywalk, footprint.sidewalk) == (1, 1, 0)
    assert (footprint.front, footprint.side, footprint.rear) == (1, 0, 0)
    assert footprint.hit_points == (0, 0, 0, 0, 0, 1, 0, 0, 0, 0)
    assert (footprint.car_speed.value, footprint.car_speed.count) == (pytest.approx(5), 1)
    assert found.disc.standing == 1


def test_without_contacts_there_are_no_speeds():
    found = summary(Scene(20, [Walk(50, 9)]))
    assert (found.disc.contacts, found.footprint.car_speed.value) == (0, None)


def test_a_larger_body_reaches_further():
    assert reach(SimConfig(car_length=6.0, car_width=8.0, body_radius=1.0)) == 6
    assert contacts(Scene(60, [Walk(10, 1.6)]), config=SimConfig(body_radius=0.75)).rule.tolist() == [1]


def test_the_relative_speed_is_that_of_both():
    towards, away = (contacts(Scene(60, [Walk(10, 0, vx=vx)])).relative_speed for vx in (-1, 1))
    assert (towards, away) == (pytest.approx([6, 6]), pytest.approx([4, 4]))


def test_the_hit_point_is_that_of_the_last_step():
    """The centres are 2.5 m apart in frame 15, so that the touch is at the beginning of the next step, 0.45 m to the
    left. A step before, the body was on the right, and a step later it is in the middle."""
    recorded = trajectory(Scene(60, [Walk(10, 0)]))
    y = np.zeros_like(recorded.ped_y)
    y[14], y[15] = -0.9, 0.45
    table = measure(changed(recorded, ped_y=y))[MEASURED_CONTACTS]
    assert (table.frame[table.rule == 1].tolist(), table.hit_point[table.rule == 1]) == ([16], pytest.approx([75]))


def test_a_contact_in_the_first_step_comes_from_frame_0():
    # from 2.75 to 2.25 m ahead, and from 0.45 m left to 0.45 m right: touched at 2.5 m, in the middle
    table = contacts(Scene(1, [Walk(2.75, 0.45, vy=-9)]))
    assert (table.frame.tolist(), table.hit_point) == ([1], pytest.approx([50]))


def test_the_left_edge_is_in_the_last_part():
    found = summary(Scene(60, [Walk(10, 1.0)]))
    assert found.footprint.hit_points == (0, 0, 0, 0, 0, 0, 0, 0, 0, 1)


def test_a_car_at_the_limit_moves():
    limit, slower = (contacts(Scene(9, [Walk(2.5, 0)], speed=speed)).moving.tolist() for speed in (0.5, 0.49))
    assert (limit, slower) == ([True], [False])


def test_the_rules_are_told_apart():
    rows = measure(trajectory(Scene(60, [Walk(10, 1.4)])))  # within 1.5 m of the centre, but 0.25 m beside the car
    found = summarise(rows, resamples=20)[MEASURED_CONTACTS]
    assert (found.disc.contacts, found.footprint.contacts) == (1, 0)
    assert (touched_while_moving(rows, "disc").tolist(), touched_while_moving(rows).tolist()) == ([True], [False])


def test_one_of_three_walked_into_a_standing_car():
    walker = Scene(60, [Walk(0, 4, vy=-1)], speed=0)
    hits = [Scene(60, [Walk(3, 0)], speed=speed) for speed in (1, 5)]
    found = summary(walker, *hits).footprint
    assert (found.contacts, found.standing, found.moving.successes) == (3, 1, 2)
    # 3 -+ 12.7 * 2, and no speed is below 0
    assert (found.car_speed.value, found.car_speed.low) == (pytest.approx(3), 0)
