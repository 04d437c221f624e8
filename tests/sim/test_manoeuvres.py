"""How near braking, holding the speed and accelerating are predicted to come to people, worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import jax
import numpy as np
import pytest
from jax import device_put

from jaxwalk import Street
from jaxwalk.interfaces import Moment
from jaxwalk.scenarios import Drawn
from jaxwalk.sim import events, manoeuvres, what_if
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.manoeuvres import BRAKE, HOLD, MOMENTS
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.prediction import foresee
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.state import Course, Motion, VehicleState
from pytrees import as_numpy
from sim.play import compiled

AWAY = np.array(POINTS) * POINT_SPACING
RULES = SimConfig(contact="footprint")
clearance_and_conflict = compiled(manoeuvres.clearance_and_conflict)
walking_speed = compiled(Scenario.walking_speed)


@compiled
def squared_clearance(world, driven, route, person):
    return manoeuvres.squared_clearance(world, driven, route, "footprint")(person)


@pytest.fixture(scope="module")
def world():
    return Street.create(config=RULES).world


def car(x, y, ahead_x, ahead_y, *, heading=0.0, speed=5.0):
    """A car beside a route that begins at (0, 0) to the east; one environment."""
    ahead_x, ahead_y = (array(place[:, None]) for place in (ahead_x, ahead_y))
    course = Course(*(array([value]) for value in (0, 0, 1, 0, 99)), ahead_x, ahead_y)
    pose = (x, y, np.cos(heading), np.sin(heading), speed, 0, 0, 0)
    return VehicleState(*(array([value]) for value in pose), course)


def array(numbers):
    return device_put(np.asarray(numbers, np.float32))


def standing(ahead, left):
    return Motion(*(array([[value]]) for value in (ahead, left, 0.0, 0.0)))


def test_a_car_beside_its_route_comes_back_to_it_at_the_last_point(world):
    driven = car(0, 1, AWAY, 0 * AWAY)
    route = (array(AWAY[:, None]), array(-np.ones((8, 1))))
    squared = squared_clearance(world, driven, route, standing(10.0, 1.3))
    clearance, conflict = clearance_and_conflict(world, squared, "footprint")
    # Held speed: 9.25 m ahead after 1.85 s, 0.37 m farther right; its front, 11.5 m ahead, is 0.09 m right of that.
    np.testing.assert_allclose(clearance[HOLD, 0], 1.3 + 0.37 - 0.9 - 0.25 + 0.03, atol=0.02)
    np.testing.assert_allclose(clearance[BRAKE, 0], 10 - 25 / 6 - 2.25 - 0.25, atol=0.1)  # it stops 4.17 m ahead
    np.testing.assert_allclose(conflict[:, 0], 3.0)
    squared = squared_clearance(world, driven, route, standing(10.0, 0.0))
    _, conflict = clearance_and_conflict(world, squared, "footprint")
    np.testing.assert_allclose(conflict[:, 0], [3.0, 1.45, 1.15])


def test_in_a_bend_it_is_where_a_driven_car_would_be(world):
    """The rectangle's corners too: a car in a bend points out of it by the angle to its rear axle's way."""
    radius, speed = 8.0, 5.0
    slip = np.arcsin(RULES.wheelbase / 2 / radius)
    ahead_x, ahead_y = radius * np.sin(AWAY / radius), radius * (1 - np.cos(AWAY / radius))
    begins = car(0, 0, ahead_x, ahead_y, heading=-slip, speed=speed)
    seen_x, seen_y = (array(x[:, None]) for x in to_frame(ahead_x, ahead_y, np.cos(slip), -np.sin(slip)))
    for number, moment in enumerate(MOMENTS["footprint"][:9]):
        angle = speed * moment / radius
        for corner in [(2.6, 1.2), (2.6, -1.2), (-2.6, 1.2), (-2.6, -1.2), (3.0, 0.0)]:
            place = to_frame(*corner, np.cos(angle - slip), -np.sin(angle - slip))
            x, y = place[0] + radius * np.sin(angle), place[1] + radius * (1 - np.cos(angle))
            person = standing(*to_frame(x, y, np.cos(slip), -np.sin(slip)))
            found = np.sqrt(squared_clearance(world, begins, (seen_x, seen_y), person)[number, HOLD, 0])
            true = events.to_rectangle(*corner, RULES.car_length, RULES.car_width)
            assert found == pytest.approx(true, abs=0.3)


def test_people_beside_the_roadway_may_turn_to_the_route():
    """They stand when an episode begins, as the car does."""
    street = Street.create(config=RULES)
    scenarios, _ = Drawn(street, 5, 32).take(np.arange(32))
    state = street.reset(scenarios)
    moment = Moment(street.world, scenarios, state)
    clearance, _ = compiled(what_if.clearance_if_they_turn)(moment, "footprint")
    seen = as_numpy(state.foresight)
    people = np.stack([seen.people.ahead, seen.people.left])
    corners = np.stack([np.concatenate([0 * of[:1], of]) for of in (seen.route_x, seen.route_y)])
    share = np.linspace(0, 1, 500).reshape(-1, 1, 1, 1)
    way = np.concatenate(corners[:, :-1] + share * (corners[:, 1:] - corners[:, :-1]), axis=1)
    steps = way[:, :, None] - people[:, None]
    nearest = np.hypot(*steps).argmin(axis=0)
    step = np.take_along_axis(steps, nearest[None, None], axis=1)[:, 0]
    time = np.array(MOMENTS["footprint"]).reshape(-1, 1, 1)
    at = people[:, None] + step[:, None] / np.hypot(*step) * what_if.SETTING_OUT * time
    away = events.to_rectangle(at[0], at[1], RULES.car_length, RULES.car_width).min(axis=(0, 1)) - RULES.body_radius
    assert not np.asarray(state.pedestrian.on_roadway).any() and (away < 9).sum() > 3
    np.testing.assert_allclose(clearance[HOLD], np.clip(away, 0, 9.75), atol=0.05)


def with_numbers(of, **numbers):
    """``of`` with these numbers in some of its arrays."""
    return replace(of, **{name: array(np.full(getattr(of, name).shape, number)) for name, number in numbers.items()})


@compiled
def clearance_if_they_cross(world, scenario, state, driven, people):
    known = replace(state, vehicle=driven, pedestrian=people, foresight=foresee(world, scenario, driven, people))
    return what_if.clearance_if_they_cross(Moment(world, scenario, known), "footprint")


@pytest.mark.parametrize(("aside", "turns"), [(0.0, True), (0.9, True), (1.1, False)])
def test_people_who_walk_to_a_crosswalk_may_take_it(aside, turns):
    """The car stands half-way between the crosswalk's ends, beyond it by 6 m; one person is 2 m before an end."""
    street = Street.create(config=replace(RULES, pedestrians=1))
    scenario = street.draw(jax.random.key(1))
    state, maps = street.reset(scenario), as_numpy(street.world.maps)
    ends = np.stack([maps.node_x[0], maps.node_y[0]], -1)[maps.side_landing[0, :2]]
    across = (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0]))
    along = np.array([across[1], -across[0]])  # the way beside the road
    begin = ends[0] - 2 * along + aside * across
    seat = ends.mean(axis=0) + 6 * along
    end = begin + 9 * along
    leg = with_numbers(state.pedestrian.leg, end_x=end[0], end_y=end[1], cos=along[0], sin=along[1])
    people = with_numbers(replace(state.pedestrian, leg=leg), remaining=9.0)
    ahead = [array(seat[i] + AWAY * along[i]) for i in (0, 1)]
    course = replace(with_numbers(state.vehicle.course, x=seat[0], y=seat[1]), ahead_x=ahead[0], ahead_y=ahead[1])
    driven = with_numbers(replace(state.vehicle, course=course), x=seat[0], y=seat[1], cos=along[0], sin=along[1])

    clearance, conflict = clearance_if_they_cross(street.world, scenario, state, driven, people)

    pace, time = float(walking_speed(scenario, street.world)[0]), np.array(MOMENTS["footprint"])
    straight = begin + np.minimum(pace * time, 2.0 if turns else 99)[:, None] * along
    at = straight + np.maximum(pace * time - 2, 0)[:, None] * across * turns
    away = events.to_rectangle(*((at - seat) @ np.stack([along, across], -1)).T, RULES.car_length, RULES.car_width)
    np.testing.assert_allclose(clearance[HOLD], away.min() - RULES.body_radius, atol=1e-3)
    np.testing.assert_allclose(conflict[HOLD], 3.0)
