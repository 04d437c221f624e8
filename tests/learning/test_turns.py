"""One learner in games of two and of five people, in turns."""

from __future__ import annotations

import dataclasses

import jax
import numpy as np
import pytest

from jaxwalk.learning.checkpoint import restore, save
from jaxwalk.learning.config import RoleConfig, TrainConfig
from jaxwalk.learning.turns import init_in_turns, update_in_turns
from learning import games

ROLE = RoleConfig(actor_hidden=(16,), critic_hidden=(16,), entropy=0.003)
CONFIG = TrainConfig(
    roles={"driver": ROLE, "pedestrian": dataclasses.replace(ROLE, epochs=2, gated=True, hold=2)}, environments=32,
    steps=16, minibatches=4, updates=40, learning_rate=5e-3, discount=0.9, chunk_rows=64,
)  # fmt: skip
CROWDS = (2, 5)


@pytest.fixture
def turns(monkeypatch):
    """The games, how often their rules were traced, and a function that makes updates from one number to another."""
    traces = []

    def rule(*seen):
        traces.append(len(seen[3]))
        return games.holding(*seen)

    monkeypatch.setitem(games.RULES, "holding", rule)
    environments = [dataclasses.replace(games.game("holding", length=3), people=people) for people in CROWDS]

    def make(learner, first, last):
        told = []
        for number in range(first, last):
            learner, metrics = update_in_turns(environments, CONFIG, learner, number)
            told.append({name: float(x) for name, x in metrics.items()})
        return learner, told

    return environments, traces, make


@pytest.mark.long
def test_each_crowd_is_traced_once_and_all_are_learned(turns):
    environments, traces, make = turns
    learner, _ = make(init_in_turns(environments, CONFIG, jax.random.key(0)), 0, 2)
    assert [x.memory["pedestrian"][0].choice.shape for x in (learner.stream, *learner.parked)] == [(2, 32), (5, 32)]
    once = sorted(traces)
    assert set(once) == set(CROWDS)
    learner, told = make(learner, 2, 40)
    assert sorted(traces) == once
    assert int(learner.updates) == 40
    for line in told[-2:]:
        assert 0.4 < line["reward/pedestrian"] < 0.6, "half of the scenarios let them decide"


def test_crowds_play_other_episodes_and_wait_while_others_play(turns):
    environments, _, make = turns
    before = init_in_turns(environments, CONFIG, jax.random.key(0))
    after, _ = make(before, 0, 1)
    assert (jax.random.key_data(before.stream.key) != jax.random.key_data(before.parked[0].key)).any()
    assert (int(after.stream.step), int(after.parked[0].step)) == (16, 0)


def test_resumed_in_the_midst_of_a_cycle_it_is_as_if_never_interrupted(turns, tmp_path):
    environments, _, make = turns
    begun, _ = make(init_in_turns(environments, CONFIG, jax.random.key(0)), 0, 3)
    save(tmp_path, begun, updates=3)
    resumed = restore(tmp_path, init_in_turns(environments, CONFIG, jax.random.key(9)))
    whole, told = make(begun, 3, 6)
    again, told_again = make(resumed, 3, 6)
    assert told == told_again
    for one, other in zip(jax.tree.leaves(_plain(whole)), jax.tree.leaves(_plain(again)), strict=True):
        np.testing.assert_array_equal(one, other)


def _plain(learner):
    def plain(x):
        return jax.random.key_data(x) if jax.numpy.issubdtype(x.dtype, jax.dtypes.prng_key) else x

    return jax.tree.map(plain, learner)
