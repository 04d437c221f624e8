"""The unit cube and normal scores, there and back."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.stats import kstest

from jaxwalk.rollout import EVALUATION, scenario_key, seed_key
from jaxwalk.scenarios import Drawn
from jaxwalk.scenarios.archived import keys_of, scenarios_at
from jaxwalk.search.cube import Candidates, ordinary, ordinary_distance, stepped, to_normal, to_uniform
from jaxwalk.sim.scenario import dimensions, parts, uniforms


def test_points_survive_normal_scores_to_the_last_bit():
    points = np.random.default_rng(0).random((100, 1000), np.float32)
    points[0, :4] = 2.0**-24, 2.0**-17, np.float32(1 - 2.0**-24), 0.5
    points = np.clip(points, 2.0**-24, None)
    assert (to_uniform(to_normal(points)) == points).all()
    assert (to_normal(np.array([[0.5]], np.float32)) == 0).all()


def test_the_edges_of_the_cube_stay_inside():
    found = to_uniform(np.array([[-50.0, -8.0, 8.0, 50.0]]))
    assert ((found > 0) & (found < 1)).all() and found.dtype == np.float32


def test_steps_leave_ordinary_points_ordinary():
    rng = np.random.default_rng(1)
    points = ordinary(rng, 200, 50)
    assert kstest(stepped(rng, points, 0.7).ravel(), "uniform").pvalue > 0.01
    only = rng.random(points.shape) < 0.2
    moved = stepped(rng, points, 0.0, only)
    assert (moved != points)[only].mean() > 0.99 and (moved == points)[~only].all()
    assert (stepped(rng, points, 1.0) == points).all()
    assert ordinary_distance(points).mean() == pytest.approx(1.0, abs=0.02)


def test_a_point_is_the_scenario_that_was_drawn_from_it(street):
    """The source of a seed and the cube agree: the same numbers are the same scenario, with the same key."""
    numbers = np.array([3, 11])
    drawn, keys = Drawn(street, 5, 20).take(numbers)
    own = scenario_key(keys, jnp.zeros(2, jnp.int32))
    count = dimensions(street.world)
    points = np.stack([np.asarray(uniforms(key, count)) for key in own])
    found = scenarios_at(street, points)
    for one, other in zip(jax.tree.leaves(drawn), jax.tree.leaves(found), strict=True):
        np.testing.assert_array_equal(one, other)
    assert (jax.random.key_data(keys) == jax.random.key_data(keys_of(5, numbers))).all()
    assert (jax.random.key_data(keys_of(5, numbers))[0] != jax.random.key_data(seed_key(5, EVALUATION))).any()


def test_every_number_has_one_place(street):
    where = parts(street.world, np.arange(dimensions(street.world)))
    every = np.concatenate([np.asarray(part).ravel() for part in where])
    assert sorted(every.tolist()) == list(range(dimensions(street.world)))


def test_candidates_can_be_chosen_and_joined():
    one = Candidates(np.eye(3, dtype=np.float32), np.array([4, 5, 6]))
    both = Candidates.joined([one.some(slice(1)), one.some(np.array([2, 1]))])
    assert both.keys.tolist() == [4, 6, 5] and len(both) == 3
