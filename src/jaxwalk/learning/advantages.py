"""How much better an action was than expected, and what a state was worth. Time is the leading axis."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float


def temporal_difference(
    reward: Float[Array, "..."], value: Float[Array, "..."], next_value: Float[Array, "..."],
    terminated: Bool[Array, "..."], *, discount: float,
) -> Float[Array, "..."]:  # fmt: skip
    """The residual ``r + discount V' - V``, 0 for V' after a terminating step (Schulman 2016, eq. 9)."""
    return reward + discount * jnp.where(terminated, 0.0, next_value) - value


def generalised_advantage(
    reward: Float[Array, "time ..."], value: Float[Array, "time+1 ..."], terminated: Bool[Array, "time ..."],
    truncated: Bool[Array, "time ..."], valid: Bool[Array, "time ..."], *, discount: float, gae_lambda: float,
) -> Float[Array, "time ..."]:  # fmt: skip
    """Sums of residuals, each later one weighted by ``discount x gae_lambda`` (Schulman 2016, eq. 16).

    ``value[t + 1]`` is the value of the state that step t led to, before any reset: a rollout shows a final state in
    the step after it, which only restarts and is not ``valid``. So a truncated step bootstraps from ``value[t + 1]``,
    a terminated one from 0; neither takes anything from the steps after; and a restarting step has advantage 0.
    """
    residual = temporal_difference(reward, value[:-1], value[1:], terminated, discount=discount)
    residual, terminated, truncated, valid = jnp.broadcast_arrays(residual, terminated, truncated, valid)

    def backwards(later: Array, step: tuple[Array, Array, Array]) -> tuple[Array, Array]:
        residual, ends, valid = step
        advantage = residual + discount * gae_lambda * jnp.where(ends, 0.0, later)
        advantage = jnp.where(valid, advantage, 0.0)
        return advantage, advantage

    steps = (residual, terminated | truncated, valid)
    _, advantage = jax.lax.scan(backwards, jnp.zeros_like(residual[0]), steps, reverse=True)
    return advantage


def normalised(x: Float[Array, "..."], weight: Float[Array, "..."]) -> Float[Array, "..."]:
    """Shifted and scaled to weighted mean 0 and standard deviation 1 over the whole array; 0 where weightless."""
    weight = jnp.broadcast_to(weight, x.shape)
    total = jnp.maximum(jnp.sum(weight), 1.0)
    mean = jnp.sum(weight * x) / total
    variance = jnp.sum(weight * (x - mean) ** 2) / total
    return jnp.where(weight > 0, (x - mean) * jax.lax.rsqrt(variance + 1e-8), 0.0)
