"""People in the frame of the car's route."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import Street
from jaxwalk.interfaces import Moment
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.corridor import BESIDE, NEARING, PER_PERSON, WATCHED, on_route
from jaxwalk.sim.crossing_kind import CROSSWALK
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.observation import CORRIDOR, part
from jaxwalk.sim.prediction import DISTANCE
from jaxwalk.sim.sim_config import SimConfig

BATCH, STEPS = 64, 60


@pytest.fixture(scope="module")
def street():
    return Street.create(config=SimConfig(pedestrians=12))


@pytest.fixture(scope="module")
def moments(street):
    """The scenarios, and their states at several moments of a slow drive, in bends too."""
    scenarios, _ = Drawn(street, 77).take(np.arange(BATCH))
    straight = jnp.stack([jnp.full(BATCH, 0.25), jnp.zeros(BATCH)])

    @eqx.filter_jit
    def drive(street, scenarios):
        def step(state, _):
            go = jnp.ones((12, BATCH), int)
            after, _ = street.step(scenarios, state, {"driver": straight, "pedestrian": go})
            frame = on_route(Moment(street.world, scenarios, after))
            return after, (after, frame, street.observe(scenarios, after, street.view("driver", CORRIDOR)))

        return jax.lax.scan(step, street.reset(scenarios), None, STEPS)[1]

    return jax.tree.map(np.asarray, drive(street, scenarios))


def sampled(route_x, route_y):
    """Places every centimetre of the way from the car through the points of its route, with their ways along it."""
    x, y = np.append(0, route_x), np.append(0, route_y)
    lengths = np.append(0, np.cumsum(np.hypot(np.diff(x), np.diff(y))))
    along = np.arange(0, lengths[-1], 0.01)
    return along, np.interp(along, lengths, x), np.interp(along, lengths, y)


def test_people_are_where_the_nearest_place_of_the_route_is(moments):
    state, (along, left, cos, sin), _ = moments
    seen, checked = state.foresight, 0
    for episode in range(0, BATCH, 8):
        at, x, y = sampled(seen.route_x[-1, :, episode], seen.route_y[-1, :, episode])
        for person in range(12):
            dx = seen.people.ahead[-1, person, episode] - x
            dy = seen.people.left[-1, person, episode] - y
            nearest = np.argmin(np.hypot(dx, dy))
            if 0 < nearest < len(at) - 1:
                found = np.argmin(np.abs(at - along[-1, person, episode]))  # two places may be equally near
                assert np.hypot(dx, dy)[found] == pytest.approx(np.hypot(dx, dy)[nearest], abs=0.02)
                assert abs(left[-1, person, episode]) == pytest.approx(np.hypot(dx, dy)[nearest], abs=0.02)
                checked += 1
    assert checked > 10
    np.testing.assert_allclose(np.hypot(cos, sin), 1, atol=1e-4)


def rows(observation):
    shown = observation[:, part("driver", CORRIDOR, "watched")].reshape(STEPS, WATCHED, PER_PERSON, BATCH)
    return np.moveaxis(shown, 2, 0) * np.array([DISTANCE, DISTANCE, SPEED, SPEED, NEARING]).reshape(-1, 1, 1, 1)


def test_the_nearest_people_ahead_are_watched(moments):
    _, (along, left, *_), observation = moments
    near = (along > 0) & (along < DISTANCE) & (np.abs(left) < BESIDE)
    order = np.argsort(np.where(near, np.hypot(along, left), np.inf), axis=1)[:, :WATCHED]
    expected = np.take_along_axis(np.where(near, along, DISTANCE), order, axis=1)
    shown = rows(observation)
    np.testing.assert_allclose(shown[0], expected, rtol=1e-3, atol=1e-2)
    absent = shown[0] > DISTANCE - 1e-4
    assert 0.1 < absent.mean() < 0.9
    np.testing.assert_allclose(shown[1][absent], BESIDE, rtol=1e-5)
    assert not shown[2:4, absent].any()
    np.testing.assert_allclose(shown[4][absent], NEARING, rtol=1e-5)


def test_who_crosses_on_a_crosswalk_is_at_one_and_was_seen_nearing_it(moments):
    """Crosswalks that lead over the route: people on them walk across it."""
    state, (along, left, *_), observation = moments
    shown, people = rows(observation), state.pedestrian
    crosses = (
        people.on_roadway & (people.leg.crossing == CROSSWALK) & (along > 0) & (along < 40) & (np.abs(left) < BESIDE)
    )
    met = 0
    for step, person, episode in np.argwhere(crosses)[::7]:
        place = np.hypot(
            shown[0][step, :, episode] - along[step, person, episode],
            shown[1][step, :, episode] - left[step, person, episode],
        )
        if place.min() < 0.02:
            assert shown[4][step, place.argmin(), episode] == 0
            met += 1
    assert met > 10
    assert ((shown[4] > 0.5) & (shown[4] < NEARING - 0.5)).any()
