"""All chance of an episode, drawn from one key."""

from __future__ import annotations

from functools import partial

import equinox as eqx
import jax
import numpy as np
import pytest

from jaxwalk.rollout import EVALUATION, TRAINING, draw_batch, environment_keys, seed_key
from jaxwalk.sim import scenario
from pytrees import as_numpy
from sim.play import ENVIRONMENTS, columns, compiled, play, reset


@pytest.fixture(scope="module")
def maps(street):
    return as_numpy(street.world.maps)


@partial(jax.jit, static_argnums=(0, 1))
def training_keys(first, count):
    return jax.random.key_data(environment_keys(seed_key(1, TRAINING), first, count))


def assert_equal(a, b):
    for x, y in zip(jax.tree.leaves(a), jax.tree.leaves(b), strict=True):
        np.testing.assert_array_equal(np.asarray(x), np.asarray(y))


def test_the_same_key_gives_the_same_scenario(draw, scenarios):
    assert_equal(draw(), scenarios)


def test_keys_go_by_global_index(draw, scenarios):
    # Drawn from 100 on, the first 156 are the last 156 of those drawn from 0 on.
    assert_equal(columns(draw(100), slice(0, 156)), columns(scenarios, slice(100, 256)))
    halves = [training_keys(first, 32) for first in (0, 32)]
    np.testing.assert_array_equal(np.concatenate(halves), training_keys(0, 64))


def test_scenarios_differ(scenarios):
    traits = np.asarray(scenarios.traits).reshape(-1, ENVIRONMENTS)
    assert len(np.unique(traits, axis=1).T) == ENVIRONMENTS
    draws = np.asarray(scenarios.jaywalk_draw).reshape(len(scenarios.jaywalk_draw), -1)  # (crossing, person)
    assert len(np.unique(draws, axis=1).T) == draws.shape[1]


@pytest.mark.parametrize(("domain", "seed"), [(EVALUATION, 1), (TRAINING, 2)])
def test_training_evaluation_and_seeds_have_scenarios_of_their_own(draw, scenarios, domain, seed):
    other = draw(domain=domain, seed=seed)
    both = np.concatenate([np.asarray(s.traits).reshape(-1, ENVIRONMENTS) for s in (other, scenarios)], axis=1)
    assert len(np.unique(both, axis=1).T) == 2 * ENVIRONMENTS


def test_what_is_drawn_is_uniform(scenarios):
    for drawn in (scenarios.traits, scenarios.jaywalk_draw, scenarios.zone_draw):
        drawn = np.asarray(drawn, float).ravel()
        assert drawn.min() >= 0
        assert drawn.max() < 1
        # Three standard errors, and a Kolmogorov-Smirnov bound at about 0.1 %.
        assert abs(drawn.mean() - 0.5) < 3 / np.sqrt(12 * drawn.size)
        steps = np.abs(np.sort(drawn) - np.arange(drawn.size) / drawn.size).max()
        assert steps < 2 / np.sqrt(drawn.size)


def test_every_route_and_waypoint_is_used(maps, draw):
    several = [draw(first) for first in (0, 256, 512)]
    routes = np.concatenate([np.asarray(s.route) for s in several])
    assert (np.unique(routes) == np.arange(maps.route_count[0])).all()
    goals = np.concatenate([np.asarray(s.goals).ravel() for s in several])
    assert set(np.unique(goals)) == set(np.flatnonzero(~maps.node_is_midpoint[0]))


def test_nobody_starts_close_to_the_car(street, maps, scenarios):
    start = reset(street, scenarios)
    x, y = np.asarray(start.pedestrian.x), np.asarray(start.pedestrian.y)
    away = np.hypot(x - np.asarray(start.vehicle.x), y - np.asarray(start.vehicle.y))
    assert away.min() >= 10 - 1e-4
    assert away.min() < 12  # though some may start near
    np.testing.assert_array_equal(x, maps.node_x[0][scenarios.start])
    np.testing.assert_array_equal(y, maps.node_y[0][scenarios.start])


def test_goals_are_twenty_metres_apart_on_foot(maps, scenarios):
    stops = np.concatenate([np.asarray(scenarios.start)[None], scenarios.goals])
    walks = maps.distance[0][stops[:-1], stops[1:]]
    assert walks.min() >= 20 - 1e-4
    assert np.isfinite(walks).all()


def test_tables_last_for_the_fastest_walkers(street, draw):
    for first in (0, 256, 512, 768):
        drawn = draw(first)
        traits = np.array(drawn.traits)
        traits[1] = 1.0
        played = play(street, eqx.tree_at(lambda s: s.traits, drawn, traits))
        # Strictly below: also the row after the last one in use may be looked at.
        assert played["decisions"].max() < drawn.jaywalk_draw.shape[0]
        assert played["arrivals"].max() + 1 < drawn.goals.shape[0]


def test_tables_last_however_close_the_goals_are(street, maps, scenarios):
    # Back and forth over a crosswalk, or between the two nearest possible goals, for ever.
    distance = maps.distance[0]
    waypoints = np.flatnonzero(~maps.node_is_midpoint[0]).astype(np.int32)
    far_enough = np.where(distance >= 20 - 1e-4, distance, np.inf)[np.ix_(waypoints, waypoints)]
    here, there = np.divmod(np.argsort(far_enough, axis=None)[:ENVIRONMENTS], len(waypoints))
    here, there = waypoints[here], waypoints[there]
    rows = np.arange(scenarios.goals.shape[0])[:, None, None] % 2
    shape = scenarios.start.shape
    busy = eqx.tree_at(
        lambda s: (s.start, s.goals, s.traits),
        scenarios,
        (
            np.broadcast_to(here, shape),
            np.broadcast_to(np.where(rows == 0, there, here), scenarios.goals.shape),
            np.ones(scenarios.traits.shape, np.float32),
        ),
    )
    played = play(street, busy)
    assert played["arrivals"].max() >= 4  # 100 m of walking, some of the pairs 20 to 25 m apart
    assert played["arrivals"].max() + 1 < scenarios.goals.shape[0]
    assert played["decisions"].max() < scenarios.jaywalk_draw.shape[0]


def test_a_scenario_is_a_function_of_its_uniform_numbers(street):
    world, keys = street.world, jax.random.split(jax.random.key(5), 8)
    numbers = np.asarray(jax.jit(jax.vmap(lambda key: scenario.uniforms(key, scenario.dimensions(world))))(keys))
    assert ((numbers > 0) & (numbers < 1)).all()
    assert_equal(
        jax.jit(jax.vmap(lambda u: scenario.from_uniforms(world, u), out_axes=-1))(numbers),
        eqx.filter_jit(draw_batch)(street, keys),
    )


def test_every_corner_of_the_unit_cube_is_a_scenario(street, maps):
    world, from_uniforms = street.world, compiled(scenario.from_uniforms)
    for corner in (0.0, np.nextafter(np.float32(1), np.float32(0))):
        drawn = from_uniforms(world, np.full(scenario.dimensions(world), corner, np.float32))
        assert 0 <= drawn.route < maps.route_count[0]
        stops = np.concatenate([drawn.start[None], drawn.goals])
        assert not maps.node_is_midpoint[0][stops].any()
        assert (np.asarray(drawn.traits) == np.float32(corner)).all()


def test_another_map_and_route_leave_the_people_alone_but_their_places(street, scenarios):
    world, key, draw = street.world, jax.random.key(3), compiled(scenario.draw)
    like = as_numpy(columns(scenarios, 0))
    free, bound = draw(world, key), draw(world, key, like)
    assert (bound.map, bound.route) == (like.map, like.route)
    assert_equal((free.traits, free.jaywalk_draw, free.zone_draw), (bound.traits, bound.jaywalk_draw, bound.zone_draw))
