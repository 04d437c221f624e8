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
from pytrees import floats

# Compiled as wholes: one operation after the other, each would be a program.
actor_loss, critic_loss, make_small_actor = map(eqx.filter_jit, (losses.actor_loss, losses.critic_loss, make_actor))
approximate_kl, beyond_clip, clipped_surrogate = map(
    jax.jit, (losses.approximate_kl, losses.beyond_clip, losses.clipped_surrogate)
)
explained_variance, log_ratio, weighted_mean, weighted_sum = map(
    jax.jit, (losses.explained_variance, losses.log_ratio, losses.weighted_mean, losses.weighted_sum)
)


def surrogate(ratio, advantage):
    return float(clipped_surrogate(np.log(np.float32(ratio)), np.float32(advantage), clip=0.2))


@pytest.mark.parametrize(
    ("ratio", "advantage", "expected"),
    [(1.0, 2.0, 2.0), (1.5, 2.0, 2.4), (0.5, 2.0, 1.0), (1.5, -2.0, -3.0), (0.5, -2.0, -1.6)],
)
def test_surrogate_by_hand(ratio, advantage, expected):
    assert surrogate(ratio, advantage) == pytest.approx(expected, rel=1e-6)


def test_surrogate_stops_pushing_beyond_the_clip():
    slope = jax.jit(jax.grad(lambda r: losses.clipped_surrogate(r, jnp.float32(1.0), clip=0.2)))
    assert float(slope(np.log(np.float32(1.5)))) == 0
    assert float(slope(np.log(np.float32(1.1)))) == pytest.approx(1.1, rel=1e-5)


def test_ratios_never_overflow():
    ratio = log_ratio(np.float32(0.0), np.float32(-1e9))
    assert np.isfinite(clipped_surrogate(ratio, np.float32(-1.0), clip=0.2))
    assert np.isfinite(approximate_kl(ratio))
    assert (float(ratio), float(log_ratio(np.float32(-1e9), np.float32(0.0)))) == (20, -20)


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
    actor, *played = saturated(action, config)
    seen, raw, limits, old = map(np.asarray, played)
    assert (limits == 0).all() if kind == "discrete" else np.abs(limits).mean() > 0.98
    if surprised:
        raw, old = (1 - raw if kind == "discrete" else -raw), np.zeros(64, np.float32)
    advantage = np.where(np.arange(64) % 2 == 0, 1.0, -1.0).astype(np.float32)
    actions = losses.Actions(*jax.device_put((seen, raw, old, advantage, np.ones(64, np.float32))))
    (loss, sums), slopes = slopes_of(actor, actions, clip=0.2, entropy=0.01)
    assert np.isfinite([loss, *sums.values()]).all()
    assert all(np.isfinite(x).all() for x in jax.tree.leaves(slopes))


def test_loss_of_an_actor_by_hand():
    actor = make_small_actor(jax.random.key(0), 3, Discrete(2), RoleConfig(actor_hidden=(8,)))
    actor = eqx.tree_at(lambda a: a.network.biases[-1], actor, floats(np.log(3), 0))  # 3/4 and 1/4 unseeing
    seen, weight = floats([0, 0], [0, 0], [0, 0]), floats(1, 0.5)
    old = floats(np.log(0.5), np.log(0.25))  # so the first choice became likelier by half, the second is as it was
    actions = losses.Actions(seen, jax.device_put(np.array([0, 1], np.int32)), old, floats(1, -4), weight)
    loss, sums = actor_loss(actor, actions, clip=0.2, entropy=0.1)
    spread = -(0.75 * np.log(0.75) + 0.25 * np.log(0.25)) * 1.5
    expected = {"policy_loss": -1.2 + 2, "entropy": spread, "kl": 0.5 - np.log(1.5), "clip_fraction": 1, "weight": 1.5}
    assert {name: float(x) for name, x in sums.items()} == pytest.approx(expected, rel=1e-5)
    assert float(loss) == pytest.approx(0.8 - 0.1 * spread, rel=1e-5)


def test_loss_of_a_critic_by_hand():
    targets = losses.Targets(floats(1, 5), floats(3, 4), floats(1, 0.5))
    loss, sums = critic_loss(lambda views: 2 * views, targets, coefficient=0.25)  # errors -1 and 6
    assert {name: float(x) for name, x in sums.items()} == {"loss": 1 + 36 / 2, "weight": 1.5}
    assert float(loss) == 19 / 4


def test_kl_estimate_is_right_on_average_and_never_negative():
    old, new = np.array([0.7, 0.3]), np.array([0.4, 0.6])
    entries = np.asarray(approximate_kl(floats(*np.log(new / old))))
    assert (entries >= 0).all()
    assert old @ entries == pytest.approx(old @ np.log(old / new), rel=1e-5)


def test_beyond_clip():
    assert beyond_clip(floats(*np.log([0.7, 0.9, 1.1, 1.3])), clip=0.2).tolist() == [1, 0, 0, 1]
    assert beyond_clip(floats(0.0), clip=0.0).tolist() == [0]  # exactly at the clip


def test_sums_ignore_what_has_no_weight():
    x = floats([1, 2], [np.nan, np.inf])
    assert float(weighted_sum(x, floats([1], [0]))) == 3
    assert float(weighted_mean(x, floats([1], [0]))) == 1.5
    assert float(weighted_mean(floats(3), floats(0.25))) == 3
    assert float(weighted_mean(floats(3), floats(0))) == 0


def test_explained_variance():
    target, weight = np.float32([1, 2, 3, 100]), np.float32([1, 1, 1, 0])
    assert float(explained_variance(target, target, weight)) == 1
    assert float(explained_variance(np.full(4, 5, np.float32), target, weight)) == pytest.approx(0, abs=1e-6)
    assert float(explained_variance(-target, target, weight)) == pytest.approx(-3, abs=1e-5)
