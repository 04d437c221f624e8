"""A gated actor: its network sees only those who decide, and what was decided stands for a while."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning import actor as actors
from jaxwalk.learning.config import RoleConfig
from jaxwalk.rollout import environment_keys

AGENTS, BATCH = 12, 16
KEYS = environment_keys(jax.random.key(1), 0, BATCH)
decide, make_actor = eqx.filter_jit(actors.decide), eqx.filter_jit(actors.make_actor)


def gated(hold=1):
    return make_actor(jax.random.key(0), 5, Discrete(2), RoleConfig(gated=True, hold=hold, actor_hidden=(8,)))


def observations(deciding):
    """Random ones, (feature, agent, batch), of which so many have something to decide."""
    random = np.random.default_rng(deciding)
    seen = random.normal(size=(5, AGENTS * BATCH)).astype(np.float32)
    seen[0] = 0
    seen[0, random.choice(AGENTS * BATCH, deciding, replace=False)] = 1
    return jnp.asarray(seen.reshape(5, AGENTS, BATCH))


def test_a_gated_choice_is_as_likely_as_the_network_says_and_go_elsewhere():
    seen, actor = observations(60), gated()
    choice, _ = decide(actor, KEYS, actor.init((AGENTS,), (BATCH,)), seen, sample=True)
    where = np.asarray(seen[0] > 0)
    np.testing.assert_array_equal(choice.decided, where)
    np.testing.assert_allclose(choice.log_prob[where], actor(seen).log_prob(choice.raw)[where], atol=1e-6)
    assert np.asarray(choice.action)[~where].all()
    assert 0 < int(np.asarray(choice.action)[where].sum()) < where.sum()


def test_a_decision_stands_for_its_time_and_no_longer_than_there_is_anything_to_decide():
    actor = gated(hold=3)
    may = np.array([[1, 1], [1, 1], [1, 0], [1, 1], [1, 1], [1, 1], [1, 1]])  # (step, agent)
    memory, decided, actions = actor.init((2,), ()), [], []
    for step, row in enumerate(may):
        seen = jnp.concatenate([jnp.asarray(row[None], jnp.float32), jnp.full((4, 2), float(step))])
        choice, memory = decide(actor, jax.random.key(step), memory, seen, sample=True)
        decided.append(choice.decided.tolist()), actions.append(choice.action.tolist())
    assert np.array(decided)[:, 0].tolist() == [True, False, False, True, False, False, True]
    assert np.array(decided)[:, 1].tolist() == [True, False, False, True, False, False, True]
    actions = np.array(actions)
    assert actions[0, 0] == actions[1, 0] == actions[2, 0]
    assert actions[3, 0] == actions[4, 0] == actions[5, 0]
    assert actions[0, 1] == actions[1, 1]
    assert actions[2, 1] == 1


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("sample", [False, True])
def test_outputs_that_are_not_finite_give_no_action(value, sample):
    """Nobody takes argmax of NaN for "wait", or tanh of infinity for full throttle."""
    makers = {
        "discrete": (Discrete(2), RoleConfig(actor_hidden=(8,))),
        "gated": (Discrete(2), RoleConfig(actor_hidden=(8,), gated=True)),
        "clipped": (Box(2), RoleConfig(actor_hidden=(8,), noise="clipped")),
        "tanh": (Box(2), RoleConfig(actor_hidden=(8,), noise="tanh")),
    }
    seen = jnp.ones((5, AGENTS, BATCH))
    for kind, (space, config) in makers.items():
        actor = make_actor(jax.random.key(0), 5, space, config)
        broken = eqx.tree_at(lambda x: x.network.biases[-1], actor, jnp.array([0.0, value]))
        for policy, sound in ((actor, True), (broken, False)):
            choice, _ = decide(policy, KEYS, policy.init((AGENTS,), (BATCH,)), seen, sample=sample, checked=True)
            assert (np.asarray(space.contains(choice.action)) == sound).all(), kind


def test_other_kinds_decide_always_and_remember_nothing():
    actor = make_actor(jax.random.key(0), 5, Box(2), RoleConfig(actor_hidden=(8,)))
    assert actor.init((), (BATCH,)) is None
    seen = observations(3)[:, 0]
    choice, memory = decide(actor, KEYS, None, seen, sample=False)
    np.testing.assert_array_equal(choice.raw, actor(seen).mean)
    assert memory is None
    assert choice.decided is None
