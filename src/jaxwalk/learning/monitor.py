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

from jaxwalk.acting import ALL, part_of
from jaxwalk.interfaces import Outcome, Policy, Roles
from jaxwalk.learning.casting import Shard
from jaxwalk.learning.losses import weighted_mean
from jaxwalk.rollout import Step
from jaxwalk.shards import SHARDS, Axis

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


def rollout_metrics(shard: Shard, played: Step) -> dict[str, Array]:
    """Return each role's rewards where its learner plays, and the endings where the first learning role plays."""
    metrics = {}
    for role, columns in shard.columns.items():
        own = columns.own if shard.config.roles[role].learns else ALL
        valid = played.valid[:, own].astype(jnp.float32)
        metrics |= reward_metrics(role, part_of(played.outcome.rewards[role], own), valid, SHARDS)
    own = shard.columns[shard.config.learning_roles[0]].own
    return metrics | episode_metrics(part_of(played.outcome, own), played.valid[:, own].astype(jnp.float32), SHARDS)


def sound_metrics(shard: Shard, played: Step, others: Roles[Policy | None]) -> dict[str, Array]:
    """Return whether every action was in its space: in all environments, and in those of each fixed policy."""
    metrics = {"sound": jnp.ones(())}
    for role, sound in played.record.sound.items():
        metrics["sound"] *= all_true(sound | ~played.valid, SHARDS)
        if others[role] is not None:
            own = shard.columns[role].fixed
            metrics[f"fixed/{role}"] = all_true((sound | ~played.valid)[:, own], SHARDS)
    return metrics
