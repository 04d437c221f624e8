"""Scalars that monitor training: reward terms, how episodes ended, and whether all numbers are finite.

With ``axis``, they cover the environments of all shards.
"""

from __future__ import annotations

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.flatten_util import ravel_pytree
from jaxtyping import Array, Bool, Float

from jaxwalk.interfaces import Outcome
from jaxwalk.learning.losses import weighted_mean
from jaxwalk.shards import Axis

ENDINGS = ("goal", "collision", "timeout")
"""Events that are counted over the episodes that ended, if the environment's ``events`` has them."""


def by_agent(x: Array, like: Array) -> Array:
    """Return an array ``(time, env)`` with axes inserted, so that it broadcasts against ``(time, *agents, env)``."""
    return x.reshape(x.shape[0], *(1,) * (like.ndim - 2), x.shape[-1])


def reward_metrics(role: str, terms: dict[str, Array], valid: Array, axis: Axis = ()) -> dict[str, Float[Array, ""]]:
    """Return the mean of each named term per agent and step, and of their sum, unscaled."""
    means = {name: weighted_mean(term, by_agent(valid, term), axis) for name, term in terms.items()}
    total = jnp.sum(jnp.stack(list(means.values()))) if means else jnp.zeros(())
    return {f"reward/{role}/{name}": mean for name, mean in means.items()} | {f"reward/{role}": total}


def episode_metrics(outcome: Outcome, valid: Array, axis: Axis = ()) -> dict[str, Float[Array, ""]]:
    """Return the episodes that ended in the rollout, their mean length (in a steady state) and the rate of each ending.

    If no episode ended, the rates are 0: check ``episodes`` first.
    """
    ended = outcome.ended & (valid > 0)
    episodes = jax.lax.psum(jnp.sum(ended, dtype=jnp.float32), axis)
    steps = jax.lax.psum(jnp.sum(valid), axis)
    metrics = {"episodes": episodes, "episode_steps": steps / jnp.maximum(episodes, 1.0)}
    for name in ENDINGS:
        happened = _event(outcome.events, name)
        if happened is not None:
            times = jax.lax.psum(jnp.sum(happened & ended), axis)
            metrics[f"{name}_rate"] = times / jnp.maximum(episodes, 1.0)
    return metrics


def all_finite(tree: Any) -> Float[Array, ""]:
    """Return 1 if every number in a pytree is finite, else 0."""
    numbers, _ = ravel_pytree(eqx.filter(tree, eqx.is_inexact_array))
    return jnp.isfinite(numbers).all().astype(jnp.float32)


def all_true(each: Bool[Array, "..."], axis: Axis = ()) -> Float[Array, ""]:
    """Return 1 if all are true, else 0."""
    return (jax.lax.psum(jnp.sum(~each, dtype=jnp.int32), axis) == 0).astype(jnp.float32)


def _event(events: Any, name: str) -> Array | None:
    found = events.get(name) if isinstance(events, dict) else getattr(events, name, None)
    return found if hasattr(found, "dtype") else None
