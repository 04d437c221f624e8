"""The terms of PPO's objective, one value for each entry, and the sums over them.

Every loss is a weighted *sum*, so that sums over chunks add up to that over the minibatch; whoever adds them divides by
the summed weight.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.learning.actor import Actor
from jaxwalk.shards import Axis

LOG_RATIO_BOUND = 20.0
"""Log-ratios are kept within +- this, so that no ratio overflows; PPO's clip is far inside."""


class Actions(eqx.Module):
    """What an actor did and how good it was: arrays ``(..., *agents, *batch)``, or with time in front."""

    observation: Float[Array, "..."]
    """What it saw: features first."""
    raw: Array
    """What it sampled, before clipping or squashing."""
    log_prob: Float[Array, "..."]
    """How likely it was to."""
    advantage: Float[Array, "..."]
    """How much better that was than expected."""
    weight: Float[Array, "..."]
    """1 where it counts, 0 where the environment only restarted or, of a gated role, nothing was to be learned."""


class Targets(eqx.Module):
    """What a critic saw and should have said."""

    views: Any
    """What it reads."""
    target: Float[Array, "..."]
    """The return it should have expected: ``(*agents, *batch)``."""
    weight: Float[Array, "..."]
    """1 where it counts, 0 where the environment only restarted or, of a gated role, nothing was to be learned."""


def actor_loss(actor: Actor, actions: Actions, *, clip: float, entropy: float) -> tuple[Array, dict[str, Array]]:
    """PPO's loss of an actor: minus the clipped surrogate and the entropy bonus (Schulman 2017, eq. 9), summed."""
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
    critic: Callable[[Any], Array], targets: Targets, *, coefficient: float
) -> tuple[Array, dict[str, Array]]:
    """A critic's loss: its squared error (Schulman 2017, eq. 9), summed."""
    value = critic(targets.views)
    error = weighted_sum(squared_error(value, targets.target), targets.weight)
    weight = jnp.sum(jnp.broadcast_to(targets.weight, value.shape))
    return coefficient * error, {"loss": error, "weight": weight}


def log_ratio(log_prob: Float[Array, "..."], old_log_prob: Float[Array, "..."]) -> Float[Array, "..."]:
    """Log of how much likelier the action has become."""
    return jnp.clip(log_prob - old_log_prob, -LOG_RATIO_BOUND, LOG_RATIO_BOUND)


def clipped_surrogate(
    log_ratio: Float[Array, "..."], advantage: Float[Array, "..."], *, clip: float
) -> Float[Array, "..."]:
    """min(ratio A, clip(ratio, 1 - clip, 1 + clip) A), to be raised (Schulman 2017, eq. 7)."""
    ratio = jnp.exp(log_ratio)
    return jnp.minimum(ratio * advantage, jnp.clip(ratio, 1.0 - clip, 1.0 + clip) * advantage)


def squared_error(value: Float[Array, "..."], target: Float[Array, "..."]) -> Float[Array, "..."]:
    """The critic's loss of one value; plain, without clipping (Schulman 2017, eq. 9)."""
    return (value - target) ** 2


def approximate_kl(log_ratio: Float[Array, "..."]) -> Float[Array, "..."]:
    """(ratio - 1) - log ratio: its mean over old samples is KL(old || new), and each entry is at least 0."""
    return jnp.expm1(log_ratio) - log_ratio


def beyond_clip(log_ratio: Float[Array, "..."], *, clip: float) -> Float[Array, "..."]:
    """1 where the ratio has left [1 - clip, 1 + clip]."""
    return (jnp.abs(jnp.expm1(log_ratio)) > clip).astype(jnp.float32)


def weighted_sum(x: Float[Array, "..."], weight: Float[Array, "..."]) -> Float[Array, ""]:
    """Sum of ``x`` times ``weight``, which broadcasts; weightless entries don't count even if they aren't finite."""
    weight = jnp.broadcast_to(weight, x.shape)
    return jnp.sum(jnp.where(weight > 0, x * weight, 0.0))


def weighted_mean(x: Float[Array, "..."], weight: Float[Array, "..."], axis: Axis = ()) -> Float[Array, ""]:
    """Weighted mean over the whole array, with ``axis`` over those of all shards; 0 if nothing has weight."""
    total = jnp.sum(jnp.broadcast_to(weight, x.shape))
    return jax.lax.psum(weighted_sum(x, weight), axis) / jnp.maximum(jax.lax.psum(total, axis), 1e-8)


def explained_variance(
    value: Float[Array, "..."], target: Float[Array, "..."], weight: Float[Array, "..."], axis: Axis = ()
) -> Float[Array, ""]:
    """1 - var(target - value) / var(target): 1 for a perfect critic, 0 for a constant one.

    With ``axis``, over the arrays of all shards.
    """

    def variance(x: Array) -> Array:
        return weighted_mean((x - weighted_mean(x, weight, axis)) ** 2, weight, axis)

    return 1.0 - variance(target - value) / jnp.maximum(variance(target), 1e-8)
