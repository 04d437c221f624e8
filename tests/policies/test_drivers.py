from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.interfaces import Policy
from jaxwalk.policies import DRIVERS, POPULATIONS, RouteFollower, RuleBased, RuleBasedBraking
from jaxwalk.policies.drivers import Careless
from jaxwalk.scenarios import Drawn
from jaxwalk.sim import vehicle
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.observation import OBSERVATIONS, part, size
from jaxwalk.sim.prediction import DISTANCE, NEIGHBOURS
from pytrees import as_numpy

KEYS = jax.random.split(jax.random.key(3), 7)
ONE = KEYS[0]
SIZES = {name: size("driver", name) for name in OBSERVATIONS["driver"]}


@eqx.filter_jit
def act(policy, *now):
    """What a policy does, in a program as a whole: each operation by itself would be one."""
    return policy.act(*now)


@pytest.mark.parametrize("name", [name for name, make in DRIVERS.items() if make().view.name in SIZES])
def test_every_driver_of_an_observation_set_keeps_the_contract(name):
    driver = DRIVERS[name]()
    assert isinstance(driver, Policy)
    seen = np.asarray(jax.random.normal(jax.random.key(1), (SIZES[driver.view.name], 7)))
    memory = driver.init((), (7,))
    action, after = act(driver, KEYS, memory, seen)
    assert action.shape == (2, 7)
    assert action.dtype == jnp.float32
    action = np.asarray(action)
    assert np.abs(action).max() <= 1
    assert jax.tree.structure(after) == jax.tree.structure(memory)
    np.testing.assert_array_equal(act(driver, KEYS, memory, seen)[0], action)
    alone, _ = act(driver, KEYS[4], driver.init((), ()), seen[:, 4])
    np.testing.assert_array_equal(alone, action[:, 4])


def test_always_go_says_go_for_everybody():
    population = POPULATIONS["always-go"]()
    assert isinstance(population, Policy)
    action, _ = act(population, KEYS, None, np.zeros((20, 12, 7), np.float32))
    assert action.shape == (12, 7)
    assert (np.asarray(action) == 1).all()


def test_random_actions_are_uniform_and_differ_between_episodes():
    keys = jax.random.split(jax.random.key(0), 20_000)
    action, _ = act(DRIVERS["random"](), keys, None, np.zeros((SIZES["paper"], len(keys)), np.float32))
    action = np.asarray(action)
    np.testing.assert_allclose(action.mean(axis=1), 0, atol=0.02)
    np.testing.assert_allclose(action.var(axis=1), 1 / 3, atol=0.01)
    assert abs(np.corrcoef(action)[0, 1]) < 0.03


def paper(goal=(30.0, 0.0), people=()):
    """What a driver sees with the set "paper"; positions [m] ahead and to the left."""
    seen = np.zeros(SIZES["paper"], np.float32)
    seen[part("driver", "paper", "goal")] = np.array(goal) / DISTANCE
    absent = [(DISTANCE, 0.0)] * (NEIGHBOURS - len(people))
    seen[part("driver", "paper", "people")] = np.array(
        [(x / DISTANCE, y / DISTANCE, 0, 0) for x, y in [*people, *absent]]
    ).ravel()
    return seen


@pytest.mark.parametrize(
    ("goal", "steering"), [((30, 0), 0), ((30, 3), 0.0997 / 0.52), ((0, 9), 1), ((0, -9), -1), ((-9, -1), -1)]
)
def test_rule_based_steers_at_the_goal(goal, steering):
    action, _ = act(RuleBased(), ONE, None, paper(goal))
    np.testing.assert_allclose(action, [1, steering], atol=1e-3)


@pytest.mark.parametrize(
    ("person", "brakes"),
    [((12.9, 0), 1), ((13.1, 0), 0), ((10, 3.6), 1), ((10, 3.7), 0), ((10, -3.6), 1), ((-5, 0), 0)],
)
def test_braking_rule_brakes_in_its_cone_only(person, brakes):
    action, _ = act(RuleBasedBraking(), ONE, None, paper(people=[(-3.0, 1.0), person]))
    np.testing.assert_allclose(action, [-1 if brakes else 1, 0])


@pytest.mark.parametrize("radius", [5.0, -8.0, 50.0])
def test_route_follower_steers_along_the_circle_to_the_point_ahead(radius):
    """A point on the circle that a bicycle with constant steering would drive: that steering is commanded."""
    angle = POINT_SPACING / abs(radius)
    slip = np.arcsin(1.25 / radius)  # turning radius = (wheelbase / 2) / sin(slip)
    chord, bearing = 2 * abs(radius) * np.sin(angle / 2), slip + np.sign(radius) * angle / 2
    seen = np.zeros(SIZES["route"], np.float32)
    begin = part("driver", "route", "route").start
    seen[begin : begin + 2] = chord * np.cos(bearing) / POINT_SPACING, chord * np.sin(bearing) / POINT_SPACING
    action, _ = act(RouteFollower(), ONE, None, seen)
    np.testing.assert_allclose(action, [1, np.arctan(2 * np.tan(slip)) / 0.52], rtol=1e-4)


def test_route_follower_keeps_every_route_s_lane_and_arrives(street):
    scenarios, keys = Drawn(street, 1).take(np.arange(256))
    driver = RouteFollower()

    @eqx.filter_jit
    def drive(street, scenarios):
        def body(state, _):
            action, _ = driver.act(keys, None, street.observe(scenarios, state, street.view("driver", "route")))
            standing = jnp.zeros(scenarios.start.shape, jnp.int32)
            state, outcome = street.step(scenarios, state, {"driver": action, "pedestrian": standing})
            return state, (vehicle.route_frame(state.vehicle)[0], outcome.events.goal)

        return jax.lax.scan(body, street.reset(scenarios), None, length=180)[1]

    lateral, goal = map(np.asarray, drive(street, scenarios))
    under_way = np.cumsum(goal, axis=0) == 0
    assert len(np.unique(scenarios.route)) > 80
    assert goal.any(axis=0).all()
    assert np.abs(lateral[under_way]).max() < 0.5


@pytest.fixture(scope="module")
def moving(street):
    """Three scenarios, and their starts with cars that move already."""
    scenarios, _ = Drawn(street, 0).take(np.arange(3))
    state = eqx.filter_jit(street.reset)(scenarios)
    return scenarios, eqx.tree_at(lambda s: s.vehicle.speed, state, np.full(3, 4.0, np.float32))


SETS = [(role, name) for role, sets in OBSERVATIONS.items() for name in sets]


@pytest.fixture(scope="module")
def observed(street, moving):
    """What everybody sees there, by role and name of the set: one program for all."""

    @eqx.filter_jit
    def observe(street, scenarios, state):
        return {(role, name): street.observe(scenarios, state, street.view(role, name)) for role, name in SETS}

    return as_numpy(observe(street, *moving))


@pytest.mark.parametrize(("role", "name"), SETS)
def test_layouts_say_where_things_are(moving, observed, role, name):
    (scenarios, state), seen = moving, observed[role, name]
    assert seen.shape[0] == size(role, name)
    if role == "pedestrian":
        shown = {"paper": [0, 1, 2, 3], "kerb": [0, 2, 3]}[name]  # the walking speed, 1, shows as a pace there
        np.testing.assert_array_equal(seen[part(role, name, "traits")], np.asarray(scenarios.traits)[shown])
        return
    np.testing.assert_allclose(seen[part(role, name, "speed")], [[4 / SPEED] * 3])
    if name not in ("privileged", "corridor"):  # which show people in another way
        people = seen[part(role, name, "people")].reshape(NEIGHBOURS, 4, 3)
        dx, dy = (np.asarray(getattr(state.pedestrian, x)) - getattr(state.vehicle, x) for x in ("x", "y"))
        away = np.hypot(dx, dy)
        np.testing.assert_allclose(
            np.hypot(people[:, 0], people[:, 1]), np.sort(away, axis=0)[:NEIGHBOURS] / DISTANCE, rtol=1e-4
        )
    if name != "paper":
        route = seen[part(role, name, "route")].reshape(len(POINTS), 2, 3)
        scale = DISTANCE / np.array([[[2.5]], [[5]]]) if name == "surroundings" else 1
        np.testing.assert_allclose(
            route[:2] * scale, [[[1] * 3, [0] * 3]] * 2, atol=1e-4
        )  # routes begin straight ahead
    with pytest.raises(KeyError):
        part(role, name, "traits of others")


def test_careless_cars_keep_to_speeds_of_their_own(street):
    driver = Careless()
    speeds = np.asarray(jax.jit(lambda: driver.init((), (1000,)))())
    assert 3 <= speeds.min() < 3.1 < 8.2 < speeds.max() <= 8.33
    assert np.abs(np.sort(speeds[:100]) - np.linspace(3, 8.33, 100)).max() < 0.2  # any stretch holds all of them
    seen = np.zeros((SIZES["route"], 2), np.float32)
    seen[part("driver", "route", "speed")] = 5 / SPEED
    own = np.array([4.9, 5.1], np.float32)
    action, memory = act(driver, jax.random.split(jax.random.key(3)), own, seen)
    np.testing.assert_array_equal(np.asarray(action)[0], [0, 1])
    np.testing.assert_array_equal(memory, own)
