"""The car against a second bicycle model, and what the road does to it."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import numpy as np
import pytest
from jax import device_put

from jaxwalk import Street
from jaxwalk.maps.network import Lane, LaneRoute
from jaxwalk.maps.network_routes import sampled_route
from jaxwalk.sim import vehicle
from jaxwalk.sim.map_tables import speed_limits
from jaxwalk.sim.sim_config import WORLDS, SimConfig
from maps.networks import bend
from pytrees import as_numpy
from sim.maps import rectangles
from sim.play import (
    ENVIRONMENTS,
    STEPS,
    actions,
    compiled,
    goal,
    inside,
    play,
    reset,
    with_car,
)

CONFIG = SimConfig()
place, drive = eqx.filter_jit(vehicle.place), eqx.filter_jit(vehicle.drive)
course, throttle = compiled(vehicle.course), compiled(vehicle.throttle)
PLACES = np.array([(10, 56), (30, 56), (90, 56), (110, 56), (56, 10), (56, 30), (56, 100), (56, 110), (80, 86),
                   (100, 86)])  # fmt: skip


def bicycle(x, y, heading, speed, acceleration, steering):
    """Polack et al. (2017), about the centre, as it is written there."""
    speed = np.clip(speed + 3.0 * acceleration * 0.1, 0, 8.33)
    beta = np.arctan(0.5 * np.tan(0.52 * steering))
    x = x + speed * np.cos(heading + beta) * 0.1
    y = y + speed * np.sin(heading + beta) * 0.1
    return x, y, heading + speed / 1.25 * np.sin(beta) * 0.1, speed


def nearest_place_inside(roads, x, y):
    """Brute force: the nearest point of any road, half a metre from its edges."""
    points = [(np.clip(x, a + 0.5, c - 0.5), np.clip(y, b + 0.5, d - 0.5)) for a, b, c, d in roads]
    away = np.stack([np.hypot(px - x, py - y) for px, py in points])
    best = away.argmin(axis=0)
    return tuple(np.choose(best, [p[i] for p in points]) for i in (0, 1)), np.sort(away, axis=0)[:2]


@pytest.fixture(scope="module")
def roads():
    return rectangles("roads")


def test_each_step_is_the_bicycle_models(driven, roads):
    (drive, _), played = driven
    now = {k: played[k].astype(float) for k in ("car_x", "car_y", "car_cos", "car_sin", "car_speed")}
    heading = np.arctan2(now["car_sin"], now["car_cos"])
    x, y, turned, speed = bicycle(now["car_x"][:-1], now["car_y"][:-1], heading[:-1], now["car_speed"][:-1],
                                  drive[:, 0].astype(float), drive[:, 1].astype(float))  # fmt: skip
    on = inside(roads, x, y, margin=1e-3)
    assert on.mean() > 0.5
    np.testing.assert_allclose(now["car_x"][1:][on], x[on], atol=1e-4)
    np.testing.assert_allclose(now["car_y"][1:][on], y[on], atol=1e-4)
    np.testing.assert_allclose(now["car_speed"][1:][on], speed[on], atol=1e-4)
    np.testing.assert_allclose(now["car_cos"][1:], np.cos(turned), atol=1e-4)
    np.testing.assert_allclose(now["car_sin"][1:], np.sin(turned), atol=1e-4)
    np.testing.assert_allclose(played["car_acceleration"][1:], 3 * drive[:, 0], rtol=1e-5)
    np.testing.assert_allclose(played["car_steering"][1:], 0.52 * drive[:, 1], rtol=1e-5)


def test_errors_do_not_add_up(driven, roads):
    (drive, _), played = driven
    x, y = played["car_x"][0].astype(float), played["car_y"][0].astype(float)
    heading = np.arctan2(played["car_sin"][0].astype(float), played["car_cos"][0])
    speed, on = np.zeros(ENVIRONMENTS), np.ones(ENVIRONMENTS, bool)
    together = 0
    for t in range(STEPS):
        x, y, heading, speed = bicycle(x, y, heading, speed, drive[t, 0].astype(float), drive[t, 1].astype(float))
        on &= inside(roads, x, y, margin=1e-2)
        together += on.sum()
        np.testing.assert_allclose(played["car_x"][t + 1][on], x[on], atol=1e-3)
        np.testing.assert_allclose(played["car_y"][t + 1][on], y[on], atol=1e-3)
    assert together > 30 * ENVIRONMENTS


def test_off_the_road_is_put_back_half_a_metre_inside_and_slowed(driven, roads):
    (drive, _), played = driven
    heading = np.arctan2(played["car_sin"][:-1].astype(float), played["car_cos"][:-1])
    x, y, _, speed = bicycle(played["car_x"][:-1].astype(float), played["car_y"][:-1], heading,
                             played["car_speed"][:-1], drive[:, 0], drive[:, 1])  # fmt: skip
    off = ~inside(roads, x, y, margin=-1e-3)
    assert off.sum() > 1000
    (back_x, back_y), (nearest, second) = nearest_place_inside(roads, x[off], y[off])
    mouth = (x[off] > 59) & (x[off] < 61) & (np.abs(y[off] - 86) < 6)  # of the branch, which is a piece of road now
    clear = (second - nearest > 1e-2) & ~mouth  # where two roads are as near, either will do
    assert clear.mean() > 0.9
    np.testing.assert_allclose(played["car_x"][1:][off][clear], back_x[clear], atol=1e-3)
    np.testing.assert_allclose(played["car_y"][1:][off][clear], back_y[clear], atol=1e-3)
    np.testing.assert_allclose(played["car_speed"][1:][off], 0.3 * speed[off], atol=1e-4)
    assert inside(roads, played["car_x"], played["car_y"], margin=-1e-4).all()


def test_speed_and_heading_stay_in_bounds(driven):
    _, played = driven
    assert played["car_speed"].min() >= 0
    assert played["car_speed"].max() <= 8.33 + 1e-5
    np.testing.assert_allclose(played["car_cos"] ** 2 + played["car_sin"] ** 2, 1, atol=5e-7)


def test_actions_beyond_their_limits_are_clipped(street, scenarios):
    start = with_car(reset(street, scenarios), speed=4.0)
    drive, beyond = np.zeros((2, STEPS, 2, ENVIRONMENTS), np.float32)
    drive[:] = [[1.0], [-1.0]]
    beyond[:] = [[7.0], [-30.0]]
    one, other = (play(street, scenarios, x, state=start) for x in (drive, beyond))
    np.testing.assert_array_equal(one["car_x"], other["car_x"])
    np.testing.assert_array_equal(one["car_sin"], other["car_sin"])
    np.testing.assert_allclose(one["car_speed"][1], 4.3, rtol=1e-6)


def test_full_throttle_straight_ahead(street, scenarios):
    drive = np.zeros((STEPS, 2, ENVIRONMENTS), np.float32)
    drive[:, 0] = 1
    played = play(street, scenarios, drive)
    speed = np.minimum(0.3 * np.arange(36), 8.33)[:, None]
    travelled = (0.1 * speed).cumsum(axis=0)
    assert 18 < travelled.max() < 21
    x, y, cos, sin = (played[name][:36] for name in ("car_x", "car_y", "car_cos", "car_sin"))
    clear = inside(rectangles("roads"), x[0] + 21 * cos[0], y[0] + 21 * sin[0])
    assert clear.mean() > 0.5
    dx, dy = x - x[0], y - y[0]
    np.testing.assert_allclose((played["car_speed"][:36] - speed)[:, clear], 0, atol=1e-4)
    np.testing.assert_allclose((dx * cos[0] + dy * sin[0] - travelled)[:, clear], 0, atol=1e-3)
    np.testing.assert_allclose((dy * cos[0] - dx * sin[0])[:, clear], 0, atol=1e-3)


def test_the_smallest_turning_circle(street, scenarios):
    # Round the middle of the intersection: 2.5 / tan 0.52 at the rear axle, half a wheelbase more by Pythagoras.
    radius = np.hypot(2.5 / np.tan(0.52), 1.25)
    beta = np.arctan(0.5 * np.tan(0.52))
    start = with_car(
        reset(street, scenarios), x=56 + radius, y=56.0, cos=np.cos(np.pi / 2 - beta), sin=np.sin(np.pi / 2 - beta),
        speed=3.0,
    )  # fmt: skip
    drive = np.zeros((STEPS, 2, ENVIRONMENTS), np.float32)
    drive[:, 1] = 1
    played = play(street, scenarios, drive, state=start)
    x, y = played["car_x"][:, 0], played["car_y"][:, 0]
    assert np.ptp(x) / 2 == pytest.approx(radius, abs=0.02)
    assert np.ptp(y) / 2 == pytest.approx(radius, abs=0.02)
    np.testing.assert_allclose(played["car_speed"], 3, rtol=1e-5)


def test_it_starts_in_the_right_hand_lane_and_is_sent_to_one(street, scenarios):
    maps = as_numpy(street.world.maps)
    pairs = maps.route_places[0][scenarios.route]
    start = reset(street, scenarios).vehicle
    x, y, cos, sin = (np.asarray(v, float) for v in (start.x, start.y, start.cos, start.sin))
    assert np.isin(np.round(np.stack([cos, sin]), 5), (-1, 0, 1)).all()
    # Two metres to the right of the centre line.
    np.testing.assert_allclose(x - PLACES[pairs[:, 0], 0], 2 * sin, atol=1e-4)
    np.testing.assert_allclose(y - PLACES[pairs[:, 0], 1], -2 * cos, atol=1e-4)
    assert (np.asarray(start.speed) == 0).all()
    goal_x, goal_y = goal(street.world, scenarios)
    end = np.round(maps.route_length[0][scenarios.route] / 0.5).astype(int)
    where = (scenarios.route, end)
    cos, sin = maps.route_cos[0][where], maps.route_sin[0][where]
    np.testing.assert_allclose(goal_x - PLACES[pairs[:, 1], 0], 2 * sin, atol=1e-3)
    np.testing.assert_allclose(goal_y - PLACES[pairs[:, 1], 1], -2 * cos, atol=1e-3)


def test_progress_never_jumps(driven):
    _, played = driven
    assert np.abs(np.diff(played["along"], axis=0)).max() <= 1 + 1e-4
    assert played["along"].min() >= 0


@pytest.mark.parametrize(
    ("config", "steps", "travelled"),
    [
        (SimConfig(max_speed=13.9, max_acceleration=50.0), 8, 0.5 + 1.0 + 6 * 1.39),
        (SimConfig(dt=1.0), 3, 3 + 6 + 8.33),
    ],
    ids=["a fast car", "a long step"],
)
def test_progress_keeps_up(scenarios, config, steps, travelled):
    """Straight ahead at full throttle, by more than a metre a step."""
    world = Street.create(config=config).world
    car = place(world, scenarios)
    ahead = course(world, scenarios, np.full(ENVIRONMENTS, 20.0, np.float32))
    straight = np.hypot(ahead.x - np.asarray(car.x), ahead.y - np.asarray(car.y)) > 20 - 1e-3
    assert straight.mean() > 0.3
    full = actions((1.0, 0.0))["driver"]
    for _ in range(steps):
        car = drive(world, scenarios, car, full)
    np.testing.assert_allclose(np.asarray(car.along)[straight], travelled, atol=1e-3)


def test_a_town_car_brakes_harder_than_it_accelerates(scenarios):
    world = Street.create(config=WORLDS["town"]).world
    car = place(world, scenarios)
    speeds = []
    for pedal in (1.0, 1.0, 0.5, -0.25, -1.0):
        car = drive(world, scenarios, car, actions((pedal, 0.0))["driver"])
        speeds.append(float(np.asarray(car.speed)[0]))
    np.testing.assert_allclose(speeds, [0.3, 0.6, 0.75, 0.56, 0.0], atol=1e-5)
    assert float(np.asarray(car.acceleration)[0]) == pytest.approx(-7.6)
    np.testing.assert_allclose(throttle(world, car), -1.0, rtol=1e-6)


def test_speed_limits_are_those_of_lanes_and_bends():
    """Two lanes of 8 and 9.42 m with limits of 10 and 6 m/s; the second one bends with a radius of 6 m."""
    angle = np.linspace(np.pi, 1.5 * np.pi, 91)
    quarter = np.stack([16 + 6 * np.cos(angle), 10 + 6 * np.sin(angle)], axis=1)
    lanes = (Lane([[10, 20], [10, 10]], 4, 10.0, (1,)), Lane(quarter, 4, 6.0))
    route = sampled_route(replace(bend(), lanes=lanes), LaneRoute((0, 1), 2.0, 3 * np.pi), 37)
    found = speed_limits(*route.tangents.T, route.limits, WORLDS["town"])
    in_bend = np.sqrt(WORLDS["town"].max_lateral * 6)
    np.testing.assert_allclose(found[18:34], in_bend, rtol=0.02)
    before = np.arange(15, -1, -1) * 0.5 + 0.5  # metres to the first point of the bend
    np.testing.assert_allclose(found[:16], np.minimum(np.sqrt(in_bend**2 + 2 * 3 * before), 10), rtol=0.1)
    loose = speed_limits(*route.tangents.T, route.limits, SimConfig())
    np.testing.assert_allclose(loose[16:], 6.0)
    np.testing.assert_allclose(loose[15], np.sqrt(36 + 2 * 3 * 0.5))


def test_no_speed_limit_binds_on_the_papers_street(street):
    assert (np.asarray(street.world.tables.course)[..., 4] > street.config.max_speed).all()


def test_a_car_above_the_limit_brakes(scenarios):
    world = Street.create(config=replace(WORLDS["town"], max_lateral=0.01)).world  # it may hardly move in a bend
    ten, five = (device_put(np.full(ENVIRONMENTS, speed, np.float32)) for speed in (10, 5))
    car = replace(place(world, scenarios), speed=ten)
    car = replace(car, course=replace(car.course, limit=five))
    after = drive(world, scenarios, car, actions((1.0, 0.0))["driver"])
    np.testing.assert_allclose(after.speed, 10 - 0.76, rtol=1e-6)
