"""Every game is learned by the very `init` and `update` that train cars."""

from __future__ import annotations

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning.actor import decide
from jaxwalk.learning.casting import whole
from jaxwalk.learning.checkpoint import CheckpointError, latest, restore, save
from jaxwalk.learning.config import RoleConfig, TrainConfig
from jaxwalk.learning.critics import blended_reward
from jaxwalk.learning.experience import gather_views
from jaxwalk.learning.mappo import init, update
from jaxwalk.shards import ShardsError
from learning import games
from pytrees import the_same

SHARED = pytest.param("shared", marks=pytest.mark.long)
ROLE = RoleConfig(actor_hidden=(16,), critic_hidden=(16,), entropy=0.003)
CONFIG = TrainConfig(
    roles={"driver": ROLE, "pedestrian": dataclasses.replace(ROLE, epochs=2)}, environments=32, steps=16, minibatches=4,
    updates=40, learning_rate=5e-3, discount=0.9, shared_critic_hidden=(16,), chunk_rows=64,
)  # fmt: skip


def in_one_chunk(shards=1):
    """CONFIG in one chunk, which changes nothing; the first test to use it sees that it is traced once."""
    return dataclasses.replace(CONFIG, chunk_rows=10**6, shards=shards)


def both(config, **changes):
    """The configuration with the same changes in both roles."""
    return games.with_roles(config, **{role: dataclasses.replace(x, **changes) for role, x in config.roles.items()})


def play(game, config=CONFIG, *, updates=40, seed=0):
    learner = init(game, config, jax.random.key(seed))
    for _ in range(updates):
        learner, metrics = update(game, config, learner)
    return learner, {name: float(x) for name, x in metrics.items()}


@eqx.filter_jit
def judged(game, config, critic, stream):
    return critic(gather_views(game, whole(config), stream.scenario, stream.state))


def values(game, config, learner, critic):
    """What a critic says of its environments' present states."""
    return np.asarray(judged(game, config, learner.critics[critic], learner.stream))


class AlwaysGo(eqx.Module):
    """A fixed policy that remembers how often it was asked since the episode began."""

    choice: jax.Array = eqx.field(default_factory=lambda: jnp.int32(1))
    view: games.Shown = eqx.field(static=True, default=games.Shown((2,)))

    def init(self, agents, batch):
        return jnp.zeros((*agents, *batch), jnp.int32)

    def act(self, key, memory, observation):
        return jnp.broadcast_to(self.choice, observation.shape[1:]), memory + 1


@pytest.mark.parametrize("credit", ["individual", SHARED])
def test_bandit(credit):
    config = dataclasses.replace(CONFIG, credit=credit)
    learner, metrics = play(games.game("bandit"), config)
    assert metrics["reward/driver/pay"] > 0.95
    assert metrics["reward/pedestrian"] > 0.95
    assert set(learner.critics) == ({"shared"} if credit == "shared" else {"driver", "pedestrian"})


def test_gated_people_decide_only_where_they_may():
    config = games.with_roles(CONFIG, pedestrian=dataclasses.replace(CONFIG.roles["pedestrian"], gated=True))
    learner, metrics = play(games.game("holding"), config)
    actor, may = learner.actors["pedestrian"], np.float32([[1, -1], [0, 0], [0, 0]])  # the first one may
    wait, _ = eqx.filter_jit(decide)(actor, jax.random.key(0), actor.init((2,), ()), may, sample=False)
    assert wait.action.tolist() == [0, 1]
    assert wait.decided.tolist() == [True, False]
    assert np.exp(wait.log_prob)[0] > 0.95
    assert 0.4 < metrics["reward/pedestrian"] < 0.6  # half of the scenarios let them decide


def test_values_follow_the_observation():
    game = games.game("given")
    learner, metrics = play(game)
    scenario = np.asarray(learner.stream.scenario)
    final = np.asarray(learner.stream.ended)
    driver, people = (values(game, CONFIG, learner, role) for role in ("driver", "pedestrian"))
    np.testing.assert_allclose(driver[~final], scenario[~final], atol=0.2)
    np.testing.assert_allclose(people[:, ~final], 2 * np.stack([scenario, scenario])[:, ~final], atol=0.3)
    assert metrics["driver/explained_variance"] > 0.95


def test_credit_reaches_back_over_two_steps():
    _, metrics = play(games.game("delayed", length=2))
    assert metrics["goal_rate"] > 0.95


@pytest.mark.parametrize("noise", [pytest.param("clipped", marks=pytest.mark.long), "tanh"])
def test_continuous_tracking(noise):
    _, metrics = play(games.game("tracking", driver=Box(1)), both(CONFIG, noise=noise, initial_std=0.4))
    assert metrics["reward/driver"] > -0.05
    assert metrics["reward/pedestrian"] > 0.95
    assert metrics["driver/std"] < 0.3


@pytest.mark.parametrize("timeout", [True, False])
def test_only_a_truncated_future_is_worth_something(timeout):
    game = games.game("steady", size=0.1, length=2, timeout=timeout, shows=False)
    learner, metrics = play(game, updates=80)
    # 0.1 / (1 - 0.9), against the mean of 0.19 and 0.1
    for role in ("driver", "pedestrian"):
        assert values(game, CONFIG, learner, role).mean() == pytest.approx(1 if timeout else 0.145, abs=0.03)
    assert metrics["timeout_rate"] == timeout
    assert metrics["episode_steps"] == pytest.approx(2, rel=0.1)


def test_the_driver_learns_to_match_what_people_do():
    _, metrics = play(games.game("matching"))
    assert metrics["reward/driver"] > 0.95
    assert metrics["reward/pedestrian"] > 0.95


@pytest.mark.parametrize("credit", ["individual", SHARED])
def test_a_role_that_does_not_learn_has_no_networks_and_pays_nobody(credit):
    config = games.with_roles(
        dataclasses.replace(CONFIG, credit=credit), pedestrian=dataclasses.replace(ROLE, fixed=1.0)
    )
    game = games.game("bandit", length=3)
    learner = init(game, config, jax.random.key(0), others={"pedestrian": AlwaysGo()})
    for _ in range(3):
        learner, metrics = update(game, config, learner)
    assert set(learner.actors) == {"driver"}
    assert set(learner.critics) == {"shared" if credit == "shared" else "driver"}
    assert float(metrics["reward/pedestrian"]) == 1
    # its memory starts anew with every episode
    asked, time = learner.stream.memory["pedestrian"][0], learner.stream.state["time"]
    assert (np.asarray(asked) == np.asarray(time)).all()


def test_who_plays_must_be_said_exactly_once():
    game, idle = games.game("bandit"), dataclasses.replace(ROLE, fixed=1.0)
    with pytest.raises(ValueError, match="pedestrian learns"):
        init(game, CONFIG, jax.random.key(0), others={"pedestrian": AlwaysGo()})
    with pytest.raises(ValueError, match="must play the pedestrian"):
        init(game, games.with_roles(CONFIG, pedestrian=idle), jax.random.key(0))
    with pytest.raises(ValueError, match="others: no role is called pedestrians; there are: driver, pedestrian"):
        init(game, CONFIG, jax.random.key(0), others={"pedestrians": AlwaysGo()})


@pytest.mark.parametrize("action", [Box(1), Box(2), Discrete(3)])
def test_only_a_choice_between_0_and_1_can_be_gated(action):
    game = games.game("tracking", driver=action)
    gated = games.with_roles(CONFIG, driver=dataclasses.replace(ROLE, gated=True))
    with pytest.raises(ValueError, match="gated: the driver doesn't choose between 0 and 1"):
        init(game, gated, jax.random.key(0))


def test_blended_reward_by_hand():
    rewards = {"driver": np.float32([[4]]), "pedestrian": np.float32([[[1], [3]]])}
    assert jax.jit(blended_reward)(rewards).tolist() == [[3.0]]


@pytest.mark.parametrize("shards", [pytest.param(1, marks=pytest.mark.long), 2])
def test_one_program_and_equal_seeds_equal_results(shards, monkeypatch, tmp_path, caplog):
    """Another game, another seed and a resumed training trace and compile nothing anew."""
    traces = []

    def rule(*seen):
        traces.append(None)
        return games.bandit(*seen)

    monkeypatch.setitem(games.RULES, "bandit", rule)
    config = in_one_chunk(shards)
    learner, first = play(games.game("bandit"), config, updates=1)
    once = len(traces)
    save(tmp_path, learner, updates=1)
    resumed = restore(tmp_path, learner)
    with jax.log_compiles():
        learner, _ = update(games.game("bandit"), config, update(games.game("bandit"), config, resumed)[0])
    assert "Compiling" not in caplog.text
    update(games.game("given"), config, learner)
    _, again = play(games.game("bandit"), config, updates=1)
    _, other = play(games.game("bandit"), config, updates=1, seed=1)
    assert len(traces) == once > 0
    assert first == again
    assert first != other


@pytest.mark.parametrize("credit", ["individual", SHARED])
def test_shared_out_environments_learn_the_same(credit):
    """With individual credit also in one chunk instead of many."""
    config = dataclasses.replace(CONFIG, credit=credit)
    learner, metrics = play(games.game("holding"), config, updates=3)
    halves = in_one_chunk(2) if credit == "individual" else dataclasses.replace(config, shards=2)
    shared, of_both = play(games.game("holding"), halves, updates=3)
    for name in metrics:
        assert of_both[name] == pytest.approx(metrics[name], rel=1e-3, abs=1e-4), name
    for one, other in zip(jax.tree.leaves(learner.actors), jax.tree.leaves(shared.actors), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-3, atol=1e-4)


@pytest.mark.long
def test_every_shard_has_its_stand_ins():
    role = dataclasses.replace(CONFIG.roles["pedestrian"], fixed=0.5)
    config = games.with_roles(dataclasses.replace(CONFIG, shards=2), pedestrian=role)
    learner = init(games.game("bandit"), config, jax.random.key(0), others={"pedestrian": AlwaysGo()})
    learner, _ = update(games.game("bandit"), config, learner)
    (asked,) = (x for x in jax.tree.leaves(learner.stream.memory["pedestrian"]) if x.dtype == jnp.int32)
    half = config.environments // 2
    for share in (asked[..., :half], asked[..., half:]):
        assert (share[..., : half // 2] == 0).all()
        assert (share[..., half // 2 :] > 0).all()
    for choice, sound in ((1, 1), (-1, 0), (2, 0)):
        others = {"pedestrian": AlwaysGo(jnp.int32(choice))}
        _, metrics = update(
            games.game("bandit"), config, eqx.tree_at(lambda x: x.others, learner, others | {"driver": None})
        )
        assert (metrics["fixed/pedestrian"], metrics["finite"]) == (sound, sound)
        assert "fixed/driver" not in metrics


def test_without_so_many_devices_it_is_said_what_to_do():
    config = dataclasses.replace(CONFIG, shards=32)
    with pytest.raises(ShardsError, match=r"32 devices are needed, and JAX has 2 \(cpu\); .*JAX_NUM_CPU_DEVICES=32"):
        init(games.game("bandit"), config, jax.random.key(0))


def test_nonsense_is_reported():
    _, sound = play(games.game("bandit"), updates=1)
    _, unsound = play(games.game("bandit", size=float("nan")), updates=1)
    assert (sound["finite"], unsound["finite"]) == (1, 0)


@pytest.mark.parametrize("config", [CONFIG, in_one_chunk(shards=2)], ids=["alone", "two shards"])
def test_resumed_training_equals_uninterrupted_training(config, tmp_path):
    game = games.game("bandit", length=3)
    learner = init(game, config, jax.random.key(0))
    for number in range(1, 4):
        learner, _ = update(game, config, learner)
        save(tmp_path, learner, updates=number)
    resumed = restore(tmp_path, init(game, config, jax.random.key(7)), updates=2)
    resumed, _ = update(game, config, resumed)
    newest = restore(tmp_path, init(game, config, jax.random.key(7)))
    kept = sorted(folder.name for folder in tmp_path.iterdir())
    assert (latest(tmp_path), kept) == (3, ["2", "3"])
    for one in (resumed, newest):
        assert the_same(one, learner)


def test_checkpoints_that_do_not_fit_are_refused(tmp_path):
    game = games.game("bandit")
    learner = init(game, CONFIG, jax.random.key(0))
    with pytest.raises(CheckpointError, match="holds no checkpoint"):
        restore(tmp_path, learner)
    save(tmp_path, learner, updates=1)
    wider = both(CONFIG, actor_hidden=(17,))
    with pytest.raises(CheckpointError, match="has shape"):
        restore(tmp_path, init(game, wider, jax.random.key(0)))
    shared = dataclasses.replace(CONFIG, credit="shared")
    with pytest.raises(CheckpointError, match=r"the checkpoint (lacks|has an unexpected)"):
        restore(tmp_path, init(game, shared, jax.random.key(0)))
