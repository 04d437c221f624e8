"""The terms of PPO's objective, one value for each entry, and the sums over them.

Every loss is a weighted *sum*, so that sums over chunks add up to the sum over the minibatch; the caller divides by the
summed weight.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.learning.actor import Actor
from jaxwalk.learning.hyperparameters import Number
from jaxwalk.shards import Axis

LOG_RATIO_BOUND = 20.0
"""Bound of log-ratios: they stay within +- this, so that no ratio overflows; PPO's clip is far inside."""


class Actions(eqx.Module):
    """An actor's actions and their advantages: arrays ``(..., *agents, *batch)``, or with time in front."""

    observation: Float[Array, "..."]
    """The observation, features first."""
    raw: Array
    """The sample before clipping or squashing."""
    log_prob: Float[Array, "..."]
    """Log-probability of the sample when it was drawn."""
    advantage: Float[Array, "..."]
    """How much better the action was than expected."""
    weight: Float[Array, "..."]
    """1 for entries that count; 0 where the environment idles or a gated role has nothing to learn."""


class Targets(eqx.Module):
    """A critic's inputs and targets."""

    views: Any
    """The critic's inputs."""
    target: Float[Array, "..."]
    """The target return: ``(*agents, *batch)``."""
    weight: Float[Array, "..."]
    """1 for entries that count; 0 where the environment idles or a gated role has nothing to learn."""


def actor_loss(actor: Actor, actions: Actions, *, clip: Number, entropy: Number) -> tuple[Array, dict[str, Array]]:
    """Return an actor's summed loss: minus the clipped surrogate and the entropy bonus (Schulman 2017, eq. 9)."""
    choice = actor(actions.observation)
    ratio = log_ratio(choice.log_prob(actions.raw), actions.log_prob)
    surrogate = clipped_surrogate(ratio, actions.advantage, clip=clip)
    spread = choice.entropy(actions.raw)
    sums = {
        "policy_loss": weighted_sum(-surrogate, actions.weight),
        "entropy": weighted_sum(spread, actions.weight),
        "kl": weighted_sum(approximate_kl(ratio), actions.weight),
        "clip_fraction": weighted_sum(beyond_clip(ratio, clip=clip), actions.weight),
        "weight": jnp.sum(jnp.broadcast_to(actions.weight, ratio.shape)),
    }
    return sums["policy_loss"] - entropy * sums["entropy"], sums


def critic_loss(
    critic: Callable[[Any], Array], targets: Targets, *, coefficient: Number
) -> tuple[Array, dict[str, Array]]:
    """Return a critic's summed loss: its squared error (Schulman 2017, eq. 9)."""
    value = critic(targets.views)
    error = weighted_sum(squared_error(value, targets.target), targets.weight)
    weight = jnp.sum(jnp.broadcast_to(targets.weight, value.shape))
    return coefficient * error, {"loss": error, "weight": weight}


def log_ratio(log_prob: Float[Array, "..."], old_log_prob: Float[Array, "..."]) -> Float[Array, "..."]:
    """Return the log of the probability ratio between the new and the old policy."""
    return jnp.clip(log_prob - old_log_prob, -LOG_RATIO_BOUND, LOG_RATIO_BOUND)


def clipped_surrogate(
    log_ratio: Float[Array, "..."], advantage: Float[Array, "..."], *, clip: Number
) -> Float[Array, "..."]:
    """Return min(ratio A, clip(ratio, 1 - clip, 1 + clip) A), to be maximised (Schulman 2017, eq. 7)."""
    ratio = jnp.exp(log_ratio)
    return jnp.minimum(ratio * advantage, jnp.clip(ratio, 1.0 - clip, 1.0 + clip) * advantage)


def squared_error(value: Float[Array, "..."], target: Float[Array, "..."]) -> Float[Array, "..."]:
    """Return the critic's loss of one value; plain, without clipping (Schulman 2017, eq. 9)."""
    return (value - target) ** 2


def approximate_kl(log_ratio: Float[Array, "..."]) -> Float[Array, "..."]:
    """Return (ratio - 1) - log ratio: its mean over old samples is KL(old || new), and each entry is at least 0."""
    return jnp.expm1(log_ratio) - log_ratio


def beyond_clip(log_ratio: Float[Array, "..."], *, clip: Number) -> Float[Array, "..."]:
    """Return 1 where the ratio is outside [1 - clip, 1 + clip], else 0."""
    return (jnp.abs(jnp.expm1(log_ratio)) > clip).astype(jnp.float32)


def weighted_sum(x: Float[Array, "..."], weight: Float[Array, "..."]) -> Float[Array, ""]:
    """Return the sum of ``x`` times ``weight``, which broadcasts; entries of weight 0 may be infinite or NaN."""
    weight = jnp.broadcast_to(weight, x.shape)
    return jnp.sum(jnp.where(weight > 0, x * weight, 0.0))


def weighted_mean(x: Float[Array, "..."], weight: Float[Array, "..."], axis: Axis = ()) -> Float[Array, ""]:
    """Return the weighted mean over the whole array, with ``axis`` over those of all shards; 0 without any weight."""
    total = jnp.sum(jnp.broadcast_to(weight, x.shape))
    return jax.lax.psum(weighted_sum(x, weight), axis) / jnp.maximum(jax.lax.psum(total, axis), 1e-8)


def explained_variance(
    value: Float[Array, "..."], target: Float[Array, "..."], weight: Float[Array, "..."], axis: Axis = ()
) -> Float[Array, ""]:
    """Return 1 - var(target - value) / var(target): 1 for a perfect critic, 0 for a constant one.

    With ``axis``, variances are over the arrays of all shards.
    """

    def variance(x: Array) -> Array:
        return weighted_mean((x - weighted_mean(x, weight, axis)) ** 2, weight, axis)

    return 1.0 - variance(target - value) / jnp.maximum(variance(target), 1e-8)
