"""What ends an episode and for whom, and what is paid: states made by hand."""

from __future__ import annotations

import dataclasses

import equinox as eqx
import jax
import numpy as np
import pytest
from jax import device_put

from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.events import arrives, closes_in, closing_speed, contact_gap, touches, touching
from jaxwalk.sim.manoeuvres import HOLD
from jaxwalk.sim.reward import DRIVER_TERMS, PEDESTRIAN_TERMS
from jaxwalk.sim.sim_config import SimConfig
from pytrees import as_numpy
from sim import play
from sim.play import ENVIRONMENTS, actions, alike, columns, goal, reset, with_car

BRAKE = (-1.0, 0.0)
COAST = (0.0, 0.0)


def everything(street, scenario, state, actions):
    """All but the next state as NumPy arrays."""
    after, *found = play.everything(street, scenario, state, actions)
    return after, *as_numpy(found)


def test_distances_are_exact():
    assert not touches(1.5, 0.0, 1.5)
    assert not touches(0.9, 1.2, 1.5)
    assert touches(np.nextafter(1.5, 0), 0.0, 1.5)
    assert arrives(3.0, 0.0, 3.0)
    assert not arrives(np.nextafter(3.0, 4), 0.0, 3.0)
    assert arrives(-3.0, 4.0, 5.0) and not arrives(3.0, -4.1, 5.0)


def test_gaps_by_hand():
    # of a car 4 m long and 2 m wide: 3 m before its bumper and 4 m beside its door are 5 m; then it faces north
    car = SimConfig(contact="footprint", car_length=4.0, car_width=2.0, body_radius=0.25)
    gaps = [contact_gap(car, 5, -5, 1, 0), contact_gap(car, -4, 2, 0, 1), contact_gap(car, 0.5, 0.5, 1, 0)]
    assert gaps == [4.75, 2.75, -0.25]
    assert touching(car, 2.24, 0, 1, 0) and not touching(car, 2.25, 0, 1, 0)
    assert (contact_gap(SimConfig(), 3, 4, 1, 0), touching(SimConfig(), 1.5, 0, 1, 0)) == (3.5, False)


def test_closing_in_by_hand():
    # 3-4-5: nearing at (3 x 1 + 4 x 2) / 5
    assert closing_speed(3.0, 4.0, -1.0, -2.0) == pytest.approx(2.2)
    assert closing_speed(3.0, 4.0, 4.0, -3.0) == pytest.approx(0)
    assert closes_in(12.0, 16.0, -0.1, -0.1)  # 20 m away, nearing at 0.14 m/s
    assert not closes_in(12.0, 16.1, -1.0, -1.0)
    assert not closes_in(12.0, 16.0, -0.06, -0.06)
    assert not closes_in(10.0, 0.0, 5.0, 0.0)


def at_step(state, step):
    return eqx.tree_at(lambda s: s.step, state, np.broadcast_to(np.asarray(step, np.int32), state.step.shape))


def test_a_collision_terminates_the_car_and_whom_it_touches(paid_street, crossing_person):
    scenario, state, p = crossing_person
    away = np.full(ENVIRONMENTS, 1.6, np.float32)
    away[:2] = 1.499, 1.501
    state = with_car(state, x=np.asarray(state.pedestrian.x)[p] - away, y=np.asarray(state.pedestrian.y)[p], speed=0.0)
    _, outcome, _, _ = everything(paid_street, scenario, state, actions(BRAKE, 0))
    assert outcome.events.collision[0]
    assert not outcome.events.collision[1:].any()
    touched = np.zeros((12, ENVIRONMENTS), bool)
    touched[p, 0] = True
    np.testing.assert_array_equal(outcome.events.touched, touched)
    np.testing.assert_array_equal(outcome.terminated["driver"], np.arange(ENVIRONMENTS) == 0)
    np.testing.assert_array_equal(outcome.terminated["pedestrian"], touched)
    expected = np.zeros((12, ENVIRONMENTS), bool)
    expected[:, 0] = True
    np.testing.assert_array_equal(outcome.truncated["pedestrian"], expected & ~touched)
    assert not outcome.truncated["driver"].any()
    np.testing.assert_array_equal(outcome.ended, np.arange(ENVIRONMENTS) == 0)
    assert outcome.rewards["driver"]["collision"][0] == 1
    np.testing.assert_array_equal(outcome.rewards["pedestrian"]["collision"] > 0, touched)


def test_the_goal_terminates_the_car_and_truncates_the_people(paid_street, scenarios):
    state = reset(paid_street, scenarios)
    goal_x, goal_y = goal(paid_street.world, scenarios)
    maps = as_numpy(paid_street.world.maps)
    last = np.round(maps.route_length[0][scenarios.route] / 0.5).astype(int)
    cos, sin = (axis[0][scenarios.route, last] for axis in (maps.route_cos, maps.route_sin))
    short = np.where(np.arange(ENVIRONMENTS) % 2, 3.002, 2.998)
    state = with_car(state, x=goal_x - short * cos, y=goal_y - short * sin, cos=cos, sin=sin, speed=0.0)
    _, outcome, _, _ = everything(paid_street, scenarios, state, actions(BRAKE, 0))
    clear = ~outcome.events.collision
    assert clear.mean() > 0.9
    arrived = np.arange(ENVIRONMENTS) % 2 == 0
    np.testing.assert_array_equal(outcome.events.goal[clear], arrived[clear])
    np.testing.assert_array_equal(outcome.terminated["driver"][clear], arrived[clear])
    np.testing.assert_array_equal(outcome.rewards["driver"]["goal"][clear], arrived[clear])
    assert not outcome.terminated["pedestrian"][:, clear].any()
    expected = np.broadcast_to(arrived, (12, ENVIRONMENTS))[:, clear]
    np.testing.assert_array_equal(outcome.truncated["pedestrian"][:, clear], expected)


def test_the_timeout_truncates_everybody_at_step_500(paid_street, scenarios):
    steps = np.where(np.arange(ENVIRONMENTS) % 2, 499, 498)
    state = at_step(reset(paid_street, scenarios), steps)
    after, outcome, _, _ = everything(paid_street, scenarios, state, actions(BRAKE))
    late = steps == 499
    np.testing.assert_array_equal(after.step, steps + 1)
    np.testing.assert_array_equal(outcome.events.timeout, late)
    np.testing.assert_array_equal(outcome.truncated["driver"], late)
    np.testing.assert_array_equal(outcome.truncated["pedestrian"], np.broadcast_to(late, (12, ENVIRONMENTS)))
    assert not outcome.terminated["driver"].any()
    assert not outcome.terminated["pedestrian"].any()


def test_collision_before_goal_before_timeout(paid_street, scenarios, midway):
    # The car where somebody crosses, on a route with its goal there.
    people = midway.pedestrian
    p, env = np.nonzero(np.asarray(people.on_roadway))
    x, y = (np.asarray(axis)[p, env] for axis in (people.x, people.y))
    routes = np.arange(np.asarray(paid_street.world.maps.route_count)[0], dtype=np.int32)
    every = eqx.tree_at(lambda s: (s.map, s.route), columns(scenarios, np.zeros(routes.size, int)),
                        (device_put(np.zeros_like(routes)), device_put(routes)))  # fmt: skip
    goal_x, goal_y = goal(paid_street.world, every)
    who, route = np.nonzero(np.hypot(goal_x[None] - x[:, None], goal_y[None] - y[:, None]) < 2.8)
    assert who.size > 0
    who, route = who[:ENVIRONMENTS], route[:ENVIRONMENTS]
    pad = np.resize(np.arange(who.size), ENVIRONMENTS)
    chosen, place = env[who[pad]], who[pad]
    scenario = eqx.tree_at(lambda s: s.route, columns(scenarios, chosen), device_put(routes[route[pad]]))
    state = with_car(at_step(columns(midway, chosen), 499), x=x[place], y=y[place], speed=0.0)
    _, outcome, _, _ = everything(paid_street, scenario, state, actions(BRAKE, 0))
    assert outcome.events.collision.all()
    assert not (outcome.events.goal | outcome.events.timeout).any()
    assert not outcome.truncated["driver"].any()
    # The same without anybody near: an arrival, and no timeout.
    far = columns(midway, np.zeros(ENVIRONMENTS, int))
    scenario = eqx.tree_at(lambda s: s.route, columns(scenarios, np.zeros(ENVIRONMENTS, int)),
                           device_put(np.resize(routes, ENVIRONMENTS)))  # fmt: skip
    goal_x, goal_y = goal(paid_street.world, scenario)
    _, outcome, _, _ = everything(paid_street, scenario, with_car(at_step(far, 499), x=goal_x, y=goal_y, speed=0.0),
                                  actions(BRAKE, 0))  # fmt: skip
    assert (outcome.events.goal ^ outcome.events.collision).all()
    assert outcome.events.goal.any()
    assert not outcome.events.timeout.any()


def test_every_term_is_its_weight_times_the_unweighted_one(street, paid_street, scenarios, midway):
    state = with_car(midway, speed=5.0)
    _, once, _, _ = everything(paid_street, scenarios, state, actions((0.3, 0.1)))
    double = dataclasses.replace(paid_street, weights=jax.tree.map(lambda w: -2 * w, paid_street.weights))
    _, other, _, _ = everything(double, scenarios, state, actions((0.3, 0.1)))
    assert set(once.rewards["driver"]) == set(DRIVER_TERMS)
    assert set(once.rewards["pedestrian"]) == set(PEDESTRIAN_TERMS)
    for role in ("driver", "pedestrian"):
        for name, term in once.rewards[role].items():
            np.testing.assert_allclose(other.rewards[role][name], -2 * term, rtol=1e-6)


def test_a_reward_that_does_not_exist_is_refused():
    from jaxwalk import Street

    with pytest.raises(ValueError, match=r"rewards\.driver\.goals is no reward term; there are: goal"):
        Street.create(driver_weights={"goals": 1.0})
    with pytest.raises(ValueError, match=r"rewards\.driver\.goal must be a number up to 1e\+06, not 1000001"):
        Street.create(driver_weights={"goal": 1_000_001.0})
    assert Street.create(driver_weights={"goal": -1e6}).weights["driver"]["goal"] == -1e6


def test_driving_along_the_route(paid_street, scenarios):
    """Half a metre in a step, straight on, in the lane or beside it, straight or aslant."""
    routes = np.asarray(scenarios.route)
    env = int(np.flatnonzero(routes == routes[0])[0])
    scenario, state = alike(scenarios, env), alike(reset(paid_street, scenarios), env)
    car = as_numpy(state.vehicle)
    aside = np.zeros(ENVIRONMENTS, np.float32)
    aside[:4] = 0, 1, -1, 3
    turn = np.zeros(ENVIRONMENTS)
    turn[4] = np.pi / 3
    cos, sin = np.cos(turn), np.sin(turn)
    state = with_car(state, x=car.x - aside * car.sin, y=car.y + aside * car.cos, speed=5.0,
                     cos=car.cos * cos - car.sin * sin, sin=car.sin * cos + car.cos * sin)  # fmt: skip
    moved, outcome, _, _ = everything(paid_street, scenario, state, actions(COAST, 0))
    paid = outcome.rewards["driver"]
    _, outcome, _, _ = everything(paid_street, scenario, moved, actions(COAST, 0))
    np.testing.assert_allclose(outcome.rewards["driver"]["progress"][:3], 0.5, atol=1e-3)
    np.testing.assert_allclose(paid["progress"][:4], 0.5, atol=1e-4)
    np.testing.assert_allclose(paid["progress"][4], 0.25, atol=1e-3)
    np.testing.assert_allclose(paid["off_lane"][:4], [0, 1, 1, 4], atol=1e-3)
    np.testing.assert_allclose(paid["misaligned"][[0, 4]], [0, 0.5], atol=1e-4)
    np.testing.assert_allclose(paid["time"], 1)
    goal_x, goal_y = (v[0] for v in goal(paid_street.world, scenario))
    x, y = np.asarray(state.vehicle.x)[0], np.asarray(state.vehicle.y)[0]
    before = np.hypot(goal_x - x, goal_y - y)
    after = np.hypot(goal_x - x - 0.5 * car.cos[0], goal_y - y - 0.5 * car.sin[0])
    np.testing.assert_allclose(paid["crow_progress"][0], before - after, atol=1e-4)


@pytest.mark.parametrize(("term", "kind"), [("crosswalk_speeding", CROSSWALK), ("jaywalker_speeding", JAYWALK)])
def test_speeding_is_about_people_on_the_roadway_ahead(term, kind, paid_street, scenarios, midway):
    """Against the words: above 3 m/s, somebody who crosses so, on the roadway, 0 to 15 m ahead, within 6 m aside."""
    random = np.random.default_rng(3)
    angle = random.uniform(-np.pi, np.pi, ENVIRONMENTS)
    speed = random.uniform(2, 8, ENVIRONMENTS)
    people = midway.pedestrian
    crosses = np.asarray(people.on_roadway) & (np.asarray(people.crossing) == kind)
    who, env = crosses.argmax(axis=0), np.arange(ENVIRONMENTS)
    back, aside = random.uniform(-5, 20, ENVIRONMENTS), random.uniform(-8, 8, ENVIRONMENTS)
    x = np.asarray(people.x)[who, env] - back * np.cos(angle) + aside * np.sin(angle)
    y = np.asarray(people.y)[who, env] - back * np.sin(angle) - aside * np.cos(angle)
    state = with_car(midway, cos=np.cos(angle), sin=np.sin(angle), speed=speed, x=x, y=y)
    _, outcome, _, seen = everything(paid_street, scenarios, state, actions(COAST))
    seen = {name: x.astype(float) for name, x in seen.items()}
    dx, dy = seen["x"] - seen["car_x"], seen["y"] - seen["car_y"]
    ahead = dx * seen["car_cos"] + dy * seen["car_sin"]
    left = dy * seen["car_cos"] - dx * seen["car_sin"]
    there = (ahead > 0) & (ahead < 15) & (np.abs(left) < 6) & (seen["on_roadway"] > 0) & (seen["crossing"] == kind)
    expected = np.where(there.any(axis=0), np.maximum(seen["car_speed"] - 3, 0) / 8.33, 0)
    assert (expected > 0).sum() >= 3
    np.testing.assert_allclose(outcome.rewards["driver"][term], expected, atol=1e-5)


def test_speeding_by_hand(paid_street, crossing_person):
    scenario, state, p = crossing_person
    people = state.pedestrian
    x, y = np.asarray(people.x)[p], np.asarray(people.y)[p]
    kind = "crosswalk_speeding" if np.asarray(people.crossing)[p, 0] == CROSSWALK else "jaywalker_speeding"
    # The others stand where they stand; one after the other: 10 m before, 16 m before, past it, slow.
    side = 1.0 if x[0] > 20 else -1.0
    back, speed = np.full(ENVIRONMENTS, 40.0), np.full(ENVIRONMENTS, 5.0)
    back[:4] = 10, 16, -10, 10
    speed[3] = 2.9
    car = with_car(state, x=np.clip(x - side * back, 1, 119), y=56.0, cos=side, sin=0.0, speed=speed)
    _, outcome, _, _ = everything(paid_street, scenario, car, actions(COAST, 0))
    paid = outcome.rewards["driver"][kind]
    assert abs(y[0] - 56) < 6
    assert paid[0] == pytest.approx((5 - 3) / 8.33, abs=1e-5)
    assert paid[3] == 0


def test_waiting_is_paid_at_the_kerb_only(paid_street, scenarios, midway):
    """For a car within 8 m, faster than 2 m/s and closing in: against the words, with the car near somebody."""
    people = midway.pedestrian
    x, y = np.asarray(people.x), np.asarray(people.y)
    _, _, _, seen = everything(paid_street, scenarios, midway, actions(BRAKE, 0))
    kerb, env, counted = seen["at_kerb"], np.arange(ENVIRONMENTS), np.zeros(5, int)
    for random in map(np.random.default_rng, range(6)):
        chosen = np.where(kerb.any(axis=0), kerb.argmax(axis=0), random.integers(12, size=ENVIRONMENTS))
        angle = random.uniform(-np.pi, np.pi, ENVIRONMENTS)
        speed = random.uniform(1, 6, ENVIRONMENTS)
        away = random.uniform(-12, 12, (2, ENVIRONMENTS))
        state = with_car(
            midway, x=x[chosen, env] + away[0], y=y[chosen, env] + away[1],
            cos=np.cos(angle), sin=np.sin(angle), speed=speed,
        )  # fmt: skip
        go = random.integers(2, size=(12, ENVIRONMENTS))
        _, outcome, _, _ = everything(paid_street, scenarios, state, actions(COAST, go))
        dx, dy = np.asarray(state.vehicle.x) - x, np.asarray(state.vehicle.y) - y
        near, closing = np.hypot(dx, dy) < 8, -(dx * np.cos(angle) + dy * np.sin(angle)) > 0
        needed = np.array([near, closing, np.broadcast_to(speed > 2, near.shape), kerb, go == 0])
        np.testing.assert_array_equal(outcome.rewards["pedestrian"]["waiting"] > 0, needed.all(axis=0))
        anywhere = np.delete(needed, 3, axis=0).all(axis=0)
        np.testing.assert_array_equal(outcome.rewards["pedestrian"]["waiting_anywhere"] > 0, anywhere)
        counted += [np.delete(needed, i, axis=0).all(axis=0)[~one].sum() for i, one in enumerate(needed)]
        assert not outcome.rewards["pedestrian"]["waiting"][np.asarray(people.on_roadway)].any()
        np.testing.assert_array_equal(outcome.rewards["pedestrian"]["waited"], go == 0)
        walked = np.where(go, 0.1 * (1 + np.asarray(scenarios.traits)[1]), 0)
        np.testing.assert_allclose(outcome.rewards["pedestrian"]["walked"], walked, rtol=1e-5)
    assert counted.min() >= 5  # for each condition, there were some whom it alone left without


def test_an_arrival_is_paid_once(paid_street, scenarios):
    state = reset(paid_street, scenarios)
    total = np.zeros((12, ENVIRONMENTS))
    for _ in range(200):
        state, outcome, _, _ = everything(paid_street, scenarios, state, actions(BRAKE))
        total += outcome.rewards["pedestrian"]["arrival"]
    np.testing.assert_array_equal(total, state.pedestrian.arrivals)
    assert total.sum() > 100


def test_closeness_is_the_shortfall_from_3_m_times_the_share_of_top_speed(paid_street, scenarios, midway):
    for speed in (0.0, 4.0, 8.33):
        after, outcome, _, _ = everything(paid_street, scenarios, with_car(midway, speed=speed), actions(COAST))
        clearance = np.asarray(after.foresight.clearance)[HOLD]
        expected = np.clip(1 - clearance / 3, 0, 1) * np.asarray(after.vehicle.speed) / 8.33
        np.testing.assert_allclose(outcome.rewards["driver"]["closeness"], expected, atol=1e-6)
        assert (expected > 0).any() == (speed > 0)
