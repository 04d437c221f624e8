"""Other numbers compile nothing anew, and each of them matters; `test_mappo.py` sees what some of them do."""

from __future__ import annotations

import dataclasses

import equinox as eqx
import jax
import pytest

from jaxwalk.learning.config import RoleConfig, TrainConfig
from jaxwalk.learning.hyperparameters import NAMES, hyperparameters, without_hyperparameters
from jaxwalk.learning.mappo import init, update
from learning import games

ROLE = RoleConfig(actor_hidden=(16,), critic_hidden=(16,), entropy=0.003)
CONFIG = TrainConfig(
    roles={"driver": ROLE, "pedestrian": ROLE}, environments=32, steps=16, minibatches=4, updates=40, anneal=True,
    learning_rate=5e-3, discount=0.9, chunk_rows=64,
)  # fmt: skip
CHANGED = {
    "learning_rate": 1e-3, "adam_epsilon": 0.1, "max_grad_norm": 1e-3, "discount": 0.5, "gae_lambda": 0.1,
    "clip": 1e-4, "value_coefficient": 9.0, "reward_scale": 3.0, "updates": 2,
}  # fmt: skip


@pytest.fixture
def told(monkeypatch):
    """A function that makes two updates and returns the last metrics, and how often the game's rules were traced."""
    traces = []

    def rule(*seen):
        traces.append(seen)
        return games.holding(*seen)

    monkeypatch.setitem(games.RULES, "holding", rule)
    game = games.game("holding", length=3)

    def tell(config):
        learner = init(game, config, jax.random.key(0))
        for _ in range(2):
            learner, metrics = update(game, config, learner)
        return {name: float(x) for name, x in metrics.items() if name != "learning_rate"}, len(traces)

    return tell


def test_each_number_matters_and_none_compiles_anew(told):
    assert CHANGED.keys() == {*NAMES, "updates"}
    changed = {name: dataclasses.replace(CONFIG, **{name: value}) for name, value in CHANGED.items()}
    keen = dataclasses.replace(ROLE, entropy=1.0)
    changed["entropy"] = dataclasses.replace(CONFIG, roles={"driver": keen, "pedestrian": ROLE})
    before, traced = told(CONFIG)
    for name, config in changed.items():
        after, traces = told(config)
        assert traces == traced, name
        assert after != before, name
    assert told(CONFIG) == (before, traced)


def test_an_update_can_be_traced():
    game, config = games.game("bandit"), dataclasses.replace(CONFIG, clip=0.123)  # nobody else's
    learner = init(game, config, jax.random.key(0))
    _, metrics = eqx.filter_eval_shape(update, game, config, learner)
    assert metrics["learning_rate"].shape == ()


def test_a_program_is_compiled_for_what_is_left():
    bare = without_hyperparameters(CONFIG)
    assert bare == without_hyperparameters(dataclasses.replace(CONFIG, **CHANGED))
    assert (bare.environments, bare.minibatches, bare.anneal, bare.updates) == (32, 4, True, 1)
    assert float(hyperparameters(CONFIG).discount) == pytest.approx(0.9)
