"""Ghosts: people like the others, on the same map and route, who touch nothing and depend on nobody."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from jaxwalk.evaluation import draw_scenarios, evaluate, play, walk_ghosts
from jaxwalk.policies import AlwaysGo, ConstantSpeed, RouteFollower
from jaxwalk.rollout import SCENARIO_KEYS

BATCH = 16


@pytest.fixture(scope="module")
def drawn(street):
    return draw_scenarios(street, seed=7, first=0, count=BATCH)


def test_ghosts_walk_as_always_go_does(street, drawn):
    """A game of the ghosts' own scenarios, with a car that does not matter to them, moves them the same way."""
    scenarios, keys = drawn
    ghosts = walk_ghosts(street, scenarios, keys, frames=130)
    second = jax.vmap(lambda key: jax.random.fold_in(jax.random.fold_in(key, SCENARIO_KEYS), 1))(keys)
    others = jax.vmap(street.draw, in_axes=(0, -1), out_axes=-1)(second, scenarios)
    played = play(street, ConstantSpeed(throttle=0.0), AlwaysGo(), others, keys)
    for name, column in vars(ghosts).items():
        assert column.shape == (130, BATCH, street.config.pedestrians)
        for episode, length in enumerate(np.minimum(played.length, 129)):
            expected = getattr(played, name)[: length + 1, episode]
            np.testing.assert_allclose(column[: length + 1, episode], expected, atol=1e-4, err_msg=name)


def test_ghosts_are_others_on_the_same_route(street, drawn):
    scenarios, keys = drawn
    others = jax.vmap(street.draw, in_axes=(0, -1), out_axes=-1)(keys, scenarios)
    np.testing.assert_array_equal(others.route, scenarios.route)
    np.testing.assert_array_equal(others.map, scenarios.map)
    assert (np.asarray(others.traits) != np.asarray(scenarios.traits)).all()


def test_ghosts_change_nothing_of_the_episode_and_are_the_same_for_every_driver(street):
    fast, slow = (
        evaluate(street, driver, AlwaysGo(), episodes=BATCH, seed=7, batch=BATCH)
        for driver in (RouteFollower(), ConstantSpeed(throttle=0.0))
    )
    assert fast.placebo.ghost_frames.sum() > 0 or slow.placebo.ghost_frames.sum() > 0
    again = evaluate(street, RouteFollower(), AlwaysGo(), episodes=BATCH, seed=7, batch=BATCH)
    np.testing.assert_array_equal(fast.placebo.ghost_frames, again.placebo.ghost_frames)
    np.testing.assert_array_equal(fast.episodes.steps, again.episodes.steps)


def test_asking_for_fewer_episodes_changes_no_ghost(street):
    many, few = (evaluate(street, RouteFollower(), AlwaysGo(), episodes=n, seed=7, batch=BATCH) for n in (24, 20))
    np.testing.assert_array_equal(many.placebo.ghost_speed_sum[:20], few.placebo.ghost_speed_sum)
