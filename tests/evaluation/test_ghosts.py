"""Ghosts: people like the others, on the same map and route, who touch nothing and depend on nobody."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from jaxwalk.evaluation import evaluate, play, walk_ghosts
from jaxwalk.metrics import OUTCOMES, PLACEBO
from jaxwalk.policies import AlwaysGo, ConstantSpeed, RouteFollower
from jaxwalk.rollout import SCENARIO_KEYS
from jaxwalk.scenarios import Drawn

BATCH = 16


@pytest.fixture(scope="module")
def drawn(street):
    return Drawn(street, 7).take(np.arange(BATCH))


def test_ghosts_walk_as_always_go_does(street, drawn):
    """A game of the ghosts' own scenarios, with a car that does not matter to them, moves them the same way."""
    scenarios, keys = drawn
    ghosts = walk_ghosts(street, scenarios, keys, frames=130)
    second = jax.vmap(lambda key: jax.random.fold_in(jax.random.fold_in(key, SCENARIO_KEYS), 1))(keys)
    others = jax.vmap(street.draw, in_axes=(0, -1), out_axes=-1)(second, scenarios)
    played = play(street, {"driver": ConstantSpeed(throttle=0.0), "pedestrian": AlwaysGo()}, others, keys)
    for name, column in vars(ghosts).items():
        assert column.shape == (130, BATCH, street.world.rules.pedestrians)
        for episode, length in enumerate(np.minimum(played.length, 129)):
            expected = getattr(played, name)[: length + 1, episode]
            np.testing.assert_allclose(column[: length + 1, episode], expected, atol=1e-4, err_msg=name)


def test_ghosts_are_others_than_the_people(street, drawn):
    scenarios, keys = drawn
    ghosts = walk_ghosts(street, scenarios, keys, frames=1)
    people = play(street, {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, scenarios, keys)
    assert (ghosts.ped_x[0] != people.ped_x[0]).any(axis=1).all()


def test_the_number_of_frames_changes_no_ghost(street, drawn):
    scenarios, keys = drawn
    few, many = (walk_ghosts(street, scenarios, keys, frames=frames) for frames in (50, 150))
    for name, column in vars(few).items():
        np.testing.assert_array_equal(column, getattr(many, name)[:50], err_msg=name)


def test_ghosts_change_nothing_of_the_episodes(street, drawn):
    scenarios, keys = drawn
    played = play(street, {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, scenarios, keys)
    rows = evaluate(street, {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, Drawn(street, 7, BATCH), batch=BATCH)
    np.testing.assert_array_equal(rows[OUTCOMES].steps, played.length)
    assert rows[PLACEBO].ghost_frames.sum() > 0


def test_asking_for_fewer_episodes_changes_no_ghost(street):
    many, few = (
        evaluate(street, {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, Drawn(street, 7, n), batch=BATCH)
        for n in (24, 20)
    )
    np.testing.assert_array_equal(many[PLACEBO].ghost_speed_sum[:20], few[PLACEBO].ghost_speed_sum)
