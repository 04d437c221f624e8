from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning import losses
from jaxwalk.learning.actor import make_actor
from jaxwalk.learning.config import RoleConfig


def surrogate(ratio, advantage):
    return float(losses.clipped_surrogate(jnp.log(ratio), jnp.float32(advantage), clip=0.2))


@pytest.mark.parametrize(
    ("ratio", "advantage", "expected"),
    [(1.0, 2.0, 2.0), (1.5, 2.0, 2.4), (0.5, 2.0, 1.0), (1.5, -2.0, -3.0), (0.5, -2.0, -1.6)],
)
def test_surrogate_by_hand(ratio, advantage, expected):
    assert surrogate(ratio, advantage) == pytest.approx(expected, rel=1e-6)


def test_surrogate_stops_pushing_beyond_the_clip():
    slope = jax.grad(lambda r: losses.clipped_surrogate(r, jnp.float32(1.0), clip=0.2))
    assert float(slope(jnp.log(1.5))) == 0
    assert float(slope(jnp.log(1.1))) == pytest.approx(1.1, rel=1e-5)


def test_ratios_never_overflow():
    ratio = losses.log_ratio(jnp.float32(0.0), jnp.float32(-1e9))
    assert np.isfinite(losses.clipped_surrogate(ratio, jnp.float32(-1.0), clip=0.2))
    assert np.isfinite(losses.approximate_kl(ratio))


@eqx.filter_jit
def saturated(action, config):
    """An actor that always chooses the limit, what it sees, its choices, and what they stand for and how likely."""
    actor = make_actor(jax.random.key(0), 3, action, config)
    actor = eqx.tree_at(lambda a: a.network.biases[-1], actor, jnp.array([1e4, -1e4]))
    seen, keys = jax.random.normal(jax.random.key(1), (3, 64)), jax.random.split(jax.random.key(2), 64)
    choice = actor(seen)
    raw = choice.sample(keys)
    return actor, seen, raw, choice.action(raw), choice.log_prob(raw)


slopes_of = eqx.filter_jit(eqx.filter_value_and_grad(losses.actor_loss, has_aux=True))


@pytest.mark.parametrize("kind", ["clipped", "tanh", "discrete"])
@pytest.mark.parametrize("surprised", [False, True])
def test_gradients_are_finite_when_policies_saturate(kind, surprised):
    """Every action at its limit, every other choice impossible; or played by a policy that did just the opposite."""
    action = Discrete(2) if kind == "discrete" else Box(2)
    config = RoleConfig(actor_hidden=(8,), noise="clipped" if kind == "discrete" else kind, initial_std=0.01)
    actor, seen, raw, limits, old = saturated(action, config)
    assert (limits == 0).all() if kind == "discrete" else np.abs(limits).mean() > 0.98
    if surprised:
        raw, old = (1 - raw if kind == "discrete" else -raw), jnp.zeros(64)
    advantage = jnp.asarray(np.where(np.arange(64) % 2 == 0, 1.0, -1.0), jnp.float32)
    actions = losses.Actions(seen, raw, old, advantage, jnp.ones(64))
    (loss, sums), slopes = slopes_of(actor, actions, clip=0.2, entropy=0.01)
    assert np.isfinite([loss, *sums.values()]).all()
    assert all(np.isfinite(x).all() for x in jax.tree.leaves(slopes))


def test_loss_of_an_actor_by_hand():
    actor = make_actor(jax.random.key(0), 3, Discrete(2), RoleConfig(actor_hidden=(8,)))
    actor = eqx.tree_at(lambda a: a.network.biases[-1], actor, jnp.log(jnp.array([3.0, 1.0])))  # 3/4 and 1/4 unseeing
    seen, weight = jnp.zeros((3, 2)), jnp.array([1.0, 0.5])
    old = jnp.log(jnp.array([0.5, 0.25]))  # so the first choice became likelier by half, the second is as it was
    actions = losses.Actions(seen, jnp.array([0, 1]), old, jnp.array([1.0, -4.0]), weight)
    loss, sums = losses.actor_loss(actor, actions, clip=0.2, entropy=0.1)
    spread = -(0.75 * np.log(0.75) + 0.25 * np.log(0.25)) * 1.5
    expected = {"policy_loss": -1.2 + 2, "entropy": spread, "kl": 0.5 - np.log(1.5), "clip_fraction": 1, "weight": 1.5}
    assert {name: float(x) for name, x in sums.items()} == pytest.approx(expected, rel=1e-5)
    assert float(loss) == pytest.approx(0.8 - 0.1 * spread, rel=1e-5)


def test_loss_of_a_critic_by_hand():
    targets = losses.Targets(jnp.array([1.0, 5.0]), jnp.array([3.0, 4.0]), jnp.array([1.0, 0.5]))
    loss, sums = losses.critic_loss(lambda views: 2 * views, targets, coefficient=0.25)  # errors -1 and 6
    assert {name: float(x) for name, x in sums.items()} == {"loss": 1 + 36 / 2, "weight": 1.5}
    assert float(loss) == 19 / 4


def test_kl_estimate_is_right_on_average_and_never_negative():
    old, new = np.array([0.7, 0.3]), np.array([0.4, 0.6])
    entries = np.asarray(losses.approximate_kl(jnp.log(new / old)))
    assert (entries >= 0).all()
    assert old @ entries == pytest.approx(old @ np.log(old / new), rel=1e-5)


def test_beyond_clip():
    assert losses.beyond_clip(jnp.log(jnp.array([0.7, 0.9, 1.1, 1.3])), clip=0.2).tolist() == [1, 0, 0, 1]


def test_sums_ignore_what_has_no_weight():
    x = jnp.array([[1.0, 2.0], [jnp.nan, jnp.inf]])
    assert float(losses.weighted_sum(x, jnp.array([[1.0], [0.0]]))) == 3
    assert float(losses.weighted_mean(x, jnp.array([[1.0], [0.0]]))) == 1.5
    assert float(losses.weighted_mean(jnp.array([3.0]), jnp.array([0.25]))) == 3


def test_explained_variance():
    target, weight = jnp.array([1.0, 2.0, 3.0, 100.0]), jnp.array([1.0, 1.0, 1.0, 0.0])
    assert float(losses.explained_variance(target, target, weight)) == 1
    assert float(losses.explained_variance(jnp.full(4, 5.0), target, weight)) == pytest.approx(0, abs=1e-6)
    assert float(losses.explained_variance(-target, target, weight)) == pytest.approx(-3, abs=1e-5)
