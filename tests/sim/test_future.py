"""The privileged driver's set: where everybody is going to be."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from jaxwalk import Street
from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.sim import vehicle
from jaxwalk.sim.future import MOMENTS, PLACES, SPACING, STEPS, limits
from jaxwalk.sim.manoeuvres import FAR
from jaxwalk.sim.observation import PRIVILEGED, part
from jaxwalk.sim.sim_config import WORLDS
from sim.play import ENVIRONMENTS, actions, columns, compiled, everything, reset, with_car

course = compiled(vehicle.course)


@jax.jit
def _observe(street, scenario, state):
    return street.observe(scenario, state, street.view("driver", PRIVILEGED))


def clearances(street, scenario, state):
    """The table in metres, (moment, place, env)."""
    seen = np.asarray(_observe(street, scenario, state))
    return seen[part("driver", PRIVILEGED, "clearances")].reshape(MOMENTS, PLACES, ENVIRONMENTS) * FAR


@pytest.mark.parametrize("anywhere", [False, True])
def test_the_table_is_what_happens_when_everybody_goes(street, scenarios, midway, always_go, anywhere):
    """`midway` is step 150 of an episode that was played on with everybody going."""
    driven = np.random.default_rng(0).uniform(0, 40, ENVIRONMENTS) if anywhere else np.zeros(ENVIRONMENTS)
    seen = clearances(street, scenarios, with_car(midway, along=driven))
    steps = 150 + STEPS * np.arange(1, MOMENTS + 1)
    along = driven + SPACING * np.arange(PLACES)[:, None]
    for env in range(0, ENVIRONMENTS, 5):
        route = (
            np.asarray(xy)[0, scenarios.route[env]] for xy in (street.world.maps.route_x, street.world.maps.route_y)
        )
        x, y = (np.interp(along[:, env], 0.5 * np.arange(len(xy)), xy) for xy in route)
        people_x, people_y = (always_go[name][steps][..., env] for name in ("x", "y"))
        away = np.hypot(people_x[:, None] - x[:, None], people_y[:, None] - y[:, None]).min(axis=2)
        # Between two points of a bend, the table goes along the tangent, this test along the chord.
        np.testing.assert_allclose(seen[..., env], np.minimum(away, FAR), atol=0.02 if anywhere else 1e-4)
    assert (seen < 1.5).mean() > 0.005


def test_by_footprint_the_table_is_about_the_cars_rectangle(scenarios, midway, always_go):
    """At points of the route the rectangle faces as the route does there."""
    town = Street.create(config=WORLDS["paper-footprint"])
    seen = clearances(town, scenarios, with_car(midway, along=0.0))
    steps = 150 + STEPS * np.arange(1, MOMENTS + 1)
    maps = town.world.maps
    for env in range(0, ENVIRONMENTS, 5):
        x, y, cos, sin = (
            np.asarray(column)[0, scenarios.route[env], :PLACES]
            for column in (maps.route_x, maps.route_y, maps.route_cos, maps.route_sin)
        )
        dx, dy = (always_go[name][steps][:, None, :, env] - at[:, None] for name, at in (("x", x), ("y", y)))
        ahead, left = dx * cos[:, None] + dy * sin[:, None], dy * cos[:, None] - dx * sin[:, None]
        away = np.hypot(np.maximum(abs(ahead) - 2.25, 0), np.maximum(abs(left) - 0.9, 0)).min(axis=2)
        np.testing.assert_allclose(seen[:, : len(x), env], np.minimum(away, FAR), atol=1e-4)
    assert (seen == 0).any()


def test_who_waits_is_taken_to_start_now(street, paid_street, scenarios, midway):
    waiting = midway
    for _ in range(10):
        waiting, *_ = everything(paid_street, scenarios, waiting, actions((-1.0, 0.0), 0))
    np.testing.assert_array_equal(clearances(street, scenarios, waiting), clearances(street, scenarios, midway))


def test_it_knows_jaywalks_that_nobody_has_decided_yet(street, scenarios):
    start = reset(street, scenarios)
    never, always = (with_jaywalk_multiplier(street, x) for x in (0.0, 1e9))
    with_none, with_all = clearances(never, scenarios, start), clearances(always, scenarios, start)
    differs = (np.abs(with_none - with_all) > 1).any(axis=(0, 1))
    assert differs.mean() > 0.5
    np.testing.assert_allclose(with_none[0], with_all[0], atol=2 * 2.0 * 0.1 * STEPS)  # both walked 0.2 s


def test_one_scenario_alone_sees_the_same(street, scenarios, midway):
    alone = _observe(street, *columns((scenarios, midway), 7))
    np.testing.assert_allclose(alone, np.asarray(_observe(street, scenarios, midway))[:, 7], atol=1e-5)


def test_it_knows_the_speed_limits_ahead(scenarios, midway):
    """Bends of the paper's route are limits in the world of a town; beyond the route's end its last one holds."""
    world = Street.create(config=WORLDS["town"]).world
    along = np.random.default_rng(0).uniform(0, 60, ENVIRONMENTS).astype(np.float32)
    state = with_car(midway, along=along)
    seen = np.asarray(jax.jit(limits)(world, scenarios, state))
    for place in (0, 7, 60, PLACES - 1):
        expected = course(world, scenarios, along + np.float32(SPACING * place)).limit
        np.testing.assert_allclose(seen[place], np.minimum(expected, 13.9), rtol=1e-6)
    assert seen.min() < 6
    assert seen.max() == pytest.approx(13.9)
