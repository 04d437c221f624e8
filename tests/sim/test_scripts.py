"""Scripted scenarios: where people walk and when, who is hidden, and contacts between two moments, by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import device_put

from jaxwalk.scenarios import Scripted
from jaxwalk.scenarios.crash_file import parse_crash_suite
from jaxwalk.sim.recording import parked_boxes
from sim.play import compiled

BRAKES, KEEPS = -1.0, 0.0
TESTS = """
name = "scripts"
title = "scripts"
source = "this test"
[[tests]]
name = "walks round a corner after a second"
title = "of three"
speeds = [36]
meets = 100.0
[[tests.people]]
path = [[-1.0, -6.0], [-1.0, -2.0], [9.0, -2.0]]
speed = 7.2
run_up = 1.0
time = 1.03
[[tests.people]]
path = [[0.0, -8.0], [0.0, -7.0]]
speed = 3.6
distance = 20.0
[[tests.people]]
path = [[30.0, -8.0], [30.0, 8.0]]
speed = 3.6
time_to_collision = 1.5
[[tests]]
name = "stands"
title = "in the way"
speeds = [36, 54]
meets = 100.0
[[tests.people]]
path = [[0.25, 0.0]]
speed = 0.0
[[tests]]
name = "hidden"
title = "behind a vehicle"
speeds = [36]
meets = 100.0
[[tests.people]]
path = [[0.0, -4.0]]
speed = 0.0
[[tests.parked]]
at = [-5.0, -2.8]
heading = 5.0
"""


@pytest.fixture(scope="module")
def scripted():
    return Scripted.of(parse_crash_suite(TESTS, "scripts.toml"), "scripts.toml")


class Walks(NamedTuple):
    """Where people are, and who walks: arrays (step, ped, case)."""

    x: np.ndarray
    y: np.ndarray
    going: np.ndarray


def evenly(number, count=4):
    return np.full(count, number, np.float32)


def everybody_goes(people, count=4):
    return np.ones((people, count), np.int32)


@compiled
def drive(street, scenarios, pedal, go, steps=60):
    """The states and collisions of some steps, along a leading axis; the car keeps to its lane."""
    state = street.reset(scenarios)
    actions = {"driver": jnp.stack([pedal, jnp.zeros_like(pedal)]), "pedestrian": go}

    def step(state, _):
        after, outcome = street.step(scenarios, state, actions)
        people = after.pedestrian
        walks = Walks(people.x, people.y, people.going)
        return after, (after.vehicle, walks, after.perceived, outcome.events)

    return state, jax.lax.scan(step, state, None, steps)[1]


@pytest.fixture(scope="module")
def played(scripted):
    """Cars that keep their speed, and cars that brake fully, among people who go."""
    scenarios, _ = scripted.take(np.arange(len(scripted)))
    count = len(scripted)
    return {
        pedal: drive(scripted.street, scenarios, evenly(pedal, count), everybody_goes(3, count))
        for pedal in (KEEPS, BRAKES)
    }


def test_a_car_begins_where_and_as_fast_as_the_script_says(scripted, played):
    first, _ = played[KEEPS]
    script = scripted.script
    np.testing.assert_allclose(first.vehicle.x, 5 + np.asarray(script.start), atol=1e-4)
    np.testing.assert_allclose(first.vehicle.y, 68.25, atol=1e-4)
    np.testing.assert_allclose(first.vehicle.speed, np.array([36, 36, 54, 36]) / 3.6, rtol=1e-6)
    np.testing.assert_array_equal(first.vehicle.course.limit, script.limit)


def test_a_car_is_no_faster_than_its_script(scripted):
    scenarios, _ = scripted.take(np.zeros(4, int))
    _, (car, *_) = drive(scripted.street, scenarios, evenly(1), everybody_goes(3))
    assert car.speed.max() == pytest.approx(10.0)


def test_people_walk_along_their_way_from_their_moment_on(played):
    """2 m/s after a metre, which takes 1 s: at 1.03 s it sets out, at 2.03 s it has walked 1 m, at 4.0 s 4.94 m.

    Its way is 4 m to the north and 10 m to the east; the place of the meeting is (105, 68.25).
    """
    _, (_, people, _, _) = played[KEEPS]
    x, y = people.x[:, 0, 0], people.y[:, 0, 0]
    assert (x[9], y[9]) == pytest.approx((104.0, 62.25))
    assert y[19] == pytest.approx(62.25 + (1.0 * 0.97**2), abs=2e-3)
    assert (x[39], y[39]) == pytest.approx((104 + 0.94, 66.25), abs=2e-3)
    assert not people.going[9, 0, 0]
    assert people.going[39, 0, 0]


def test_people_wait_for_the_car(played):
    """At 10 m/s from 40 m before the meeting: 20 m away after 2.0 s, and 1.5 s away after 2.5 s."""
    _, (_, people, _, _) = played[KEEPS]
    walked = people.y[:, 1:, 0] - np.array([60.25, 60.25])
    np.testing.assert_allclose(walked[[19, 24, 29], 0], [0, 0.5, 1.0], atol=5e-3)
    np.testing.assert_allclose(walked[[24, 29, 34], 1], [0, 0.5, 1.0], atol=5e-3)
    assert walked[-1, 0] == pytest.approx(1.0)  # its way ends there
    assert not people.going[-1, 1, 0]


def test_who_doesn_t_go_stands_and_walks_on_later(scripted):
    scenarios, _ = scripted.take(np.zeros(4, int))
    waits = everybody_goes(3)
    waits[0] = 0
    _, (_, people, _, _) = drive(scripted.street, scenarios, evenly(0), waits)
    assert np.ptp(people.y[:, 0]) < 0.05  # it had set out for less than a part of a step
    assert np.ptp(people.y[:, 1]) == pytest.approx(1.0)


def test_a_contact_is_where_body_and_front_meet(played):
    """The unbraked car touches the body when its centre is 2.5 m before the person's, within a millimetre or so."""
    for pedal in (KEEPS, BRAKES):
        _, (car, people, _, events) = played[pedal]
        for case in (1, 2):
            met = int(events.collision[:, case].argmax())
            if not events.collision[met, case]:
                continue
            assert people.x[met, 0, case] - car.x[met, case] == pytest.approx(2.5 - 1e-3, abs=2e-3)
            assert events.touched[met, 0, case]
    assert played[KEEPS][1][3].collision[:, 1:3].any(axis=0).all()


def test_the_speed_of_an_impact_is_that_of_the_moment_of_the_contact(scripted):
    """v^2 = v0^2 - 2 a s: braking at 7.6 m/s2 over the last 10 m, from 15 m/s, leaves 8.54 m/s."""
    scenarios, _ = scripted.take(np.full(4, 2))
    gap, at_contact = 10.0, 100.25 - 0.25 - 2.25
    script = replace(scenarios.script, start=device_put(evenly(at_contact - gap)))
    near = replace(scenarios, script=script)
    _, (car, _, _, events) = drive(scripted.street, near, evenly(BRAKES), everybody_goes(3))
    met = int(events.collision[:, 0].argmax())
    assert car.speed[met, 0] == pytest.approx((15**2 - 2 * 7.6 * gap) ** 0.5, abs=0.06)


def test_a_vehicle_of_the_script_hides_who_is_behind_it(scripted, played):
    """Its nearest corner decides; shapely isn't needed: the line from the eye passes the corner, or not."""
    boxes = parked_boxes(scripted.street.world, scripted.take(np.arange(4))[0])
    assert boxes is not None
    assert np.isnan(boxes[:3]).all()
    x, y, cos, sin, half_length, half_width = boxes[3, 0]
    assert np.degrees(np.arctan2(sin, cos)) == pytest.approx(5.0, abs=1e-4)
    ahead, left = np.array([cos, sin]), np.array([-sin, cos])
    corners = [np.array([x, y]) + a * half_length * ahead + b * half_width * left for a in (-1, 1) for b in (-1, 1)]
    _, (car, _, perceived, _) = played[KEEPS]
    eye = np.stack([car.x[:, 3] + 1.25, car.y[:, 3]], axis=1)
    person = np.array([105.0, 64.25])
    to_x, to_y = (person - eye).T
    sides = np.array([to_x * (corner - eye)[:, 1] - to_y * (corner - eye)[:, 0] for corner in corners])
    apart = (sides > 0.05).all(axis=0) | (sides < -0.05).all(axis=0)
    crosses = ((sides > 0.05).any(axis=0)) & ((sides < -0.05).any(axis=0)) & (eye[:, 0] < x - half_length - 0.3)
    near = np.hypot(*(person - eye).T) < 59.5
    assert crosses.any()
    assert not perceived.now.seen[crosses, 0, 3].any()
    assert perceived.now.seen[apart & near, 0, 3].all()


TIMED = """
name = "timed"
title = "timed"
source = "this test"
[[tests]]
name = "waits on the way"
title = "a second later"
speeds = [36]
meets = 100.0
starts_at = 20.0
begins = 18.0
[[tests.people]]
path = [[0.0, -8.0], [0.0, -6.0], [0.0, -6.0], [3.0, -2.0]]
times = [0.0, 1.0, 2.0, 4.0]
time = 1.0
[[tests.people]]
path = [[0.0, -8.0], [0.0, -7.0]]
speed = 3.6
time = 1.0
"""


def test_who_has_times_is_there_at_these_times_and_stands_between():
    """They set out after 1 s: 2 m to the north in a second, a second of rest, then 5 m in 2 s."""
    timed = Scripted.of(parse_crash_suite(TIMED, "timed.toml"), "timed.toml")
    scenarios, _ = timed.take(np.zeros(1, int))
    first, (_, people, _, _) = drive(timed.street, scenarios, evenly(0, 1), everybody_goes(2, 1))
    np.testing.assert_allclose([first.vehicle.x[0], first.vehicle.speed[0]], [25, 5], atol=1e-4)
    steps = np.array([9, 14, 19, 24, 29, 39, 49, 59])
    x, y = people.x[steps, :, 0] - 105, people.y[steps, :, 0] - 68.25
    np.testing.assert_allclose(y[:, 0], [-8, -7, -6, -6, -6, -4, -2, -2], atol=5e-3)
    np.testing.assert_allclose(x[:, 0], [0, 0, 0, 0, 0, 1.5, 3, 3], atol=5e-3)
    np.testing.assert_allclose(y[:, 1], [-8, -7.5, -7, -7, -7, -7, -7, -7], atol=5e-3)
    assert people.going[[14, 24, 39, 59], 0, 0].tolist() == [True, False, True, False]
