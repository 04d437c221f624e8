"""Stand-ins: who plays where, and that a learner learns only from what it did itself."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.acting import fresh_memory
from jaxwalk.interfaces import Discrete
from jaxwalk.learning.actor import make_actor
from jaxwalk.learning.casting import learning_cast, remember, whole
from jaxwalk.learning.config import SNAPSHOTS, RoleConfig, TrainConfig
from jaxwalk.learning.experience import recording_act
from jaxwalk.learning.mappo import init, update
from jaxwalk.rollout import rollout
from learning import games
from pytrees import the_same

ROLE = RoleConfig(actor_hidden=(8,), critic_hidden=(8,))
CONFIG = TrainConfig(
    roles={"driver": replace(ROLE, fixed=0.25, early=0.25), "pedestrian": replace(ROLE, fixed=0.5)},
    environments=16, steps=8, minibatches=4, learning_rate=1e-2, discount=0.9,
)  # fmt: skip


class Always(eqx.Module):
    """Always the same choice; remembers how often it was made."""

    choice: int
    view: games.Shown = eqx.field(static=True, default=games.Shown((2,)))

    def init(self, agents, batch):
        return jnp.zeros((*agents, *batch), jnp.int32)

    def act(self, key, memory, observation):
        return jnp.full(observation.shape[1:], self.choice, jnp.int32), memory + 1


OTHERS = {"driver": Always(0, games.Shown(())), "pedestrian": Always(1)}


def test_stand_ins_of_the_two_roles_are_at_different_ends():
    driver, pedestrian = whole(CONFIG).columns.values()
    assert (driver.fixed, driver.own) == (slice(0, 4), slice(8, 16))
    assert driver.early == (slice(4, 6), slice(6, 8))
    assert (pedestrian.own, pedestrian.fixed) == (slice(0, 8), slice(8, 16))
    assert whole(games.with_roles(CONFIG, driver=ROLE)).columns["driver"].own == slice(0, 16)


@eqx.filter_jit
def two_steps(game, learner):
    """What was played and recorded."""
    shard = whole(CONFIG)
    cast = learning_cast(game, shard, learner.actors, learner.early, OTHERS)
    act, memory = recording_act(game, shard, cast), fresh_memory(game, cast, (CONFIG.environments,))
    _, played = rollout(game, act, learner.stream, 2, fresh_memory=memory)
    return played


def test_each_plays_its_environments_and_only_the_learners_are_recorded():
    game = games.game("bandit", length=3)
    played = two_steps(game, init(game, CONFIG, jax.random.key(0), others=OTHERS))
    paid = {role: np.asarray(terms["pay"]) for role, terms in played.outcome.rewards.items()}
    assert not paid["driver"][:, :4].any()
    assert paid["pedestrian"][..., 8:].all()
    for role, own in (("driver", slice(8, 16)), ("pedestrian", slice(0, 8))):
        np.testing.assert_array_equal(played.record.choices[role].raw, paid[role][..., own])
        assert played.record.views[role]["paper"].shape[-1] == 8


@pytest.mark.long
def test_learning_goes_on_beside_stand_ins():
    game = games.game("bandit", length=3)
    learner = init(game, CONFIG, jax.random.key(0), others=OTHERS)
    for _ in range(40):
        learner, metrics = update(game, CONFIG, learner)
    assert float(metrics["reward/driver/pay"]) > 0.9
    assert float(metrics["reward/pedestrian/pay"]) > 0.9
    fixed, *_ = learner.stream.memory["driver"]
    assert (fixed[:4] == learner.stream.state["time"][:4]).all()  # a stand-in's memory starts anew with every episode
    assert len(learner.early["driver"]) == len(SNAPSHOTS)
    assert learner.early["pedestrian"] == ()


def test_a_snapshot_follows_until_its_time_has_come():
    make, follow = eqx.filter_jit(make_actor), eqx.filter_jit(remember)
    first, second = (make(jax.random.key(k), 3, Discrete(2), ROLE) for k in (0, 1))
    until, after = (follow((first, first), second, np.int32(SNAPSHOTS[0] + more)) for more in (0, 1))
    assert the_same(until, (second, second))
    assert the_same(after, (first, second))
    assert not the_same(first, second)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"fixed": 1.5}, "fixed must lie"),
        ({"fixed": 0.5, "early": 0.5}, "early leaves nothing"),
        ({"hold": 2}, "hold must be 1"),
        ({"gated": True, "hold": 0}, "hold must be 1"),
    ],
)
def test_impossible_shares(changes, message):
    with pytest.raises(ValueError, match=message):
        RoleConfig(**changes)


def test_shared_credit_goes_without_stand_ins():
    with pytest.raises(ValueError, match="fixed"):
        replace(CONFIG, credit="shared", roles={"driver": replace(ROLE, fixed=0.25), "pedestrian": ROLE})
    with pytest.raises(ValueError, match="early"):
        replace(CONFIG, credit="shared", roles={"driver": replace(ROLE, early=0.25), "pedestrian": ROLE})
