"""Estimate how much better actions were than expected, and the value of states. Time is the leading axis."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from jaxwalk.learning.hyperparameters import Number
from jaxwalk.shards import Axis


class Transitions(NamedTuple):
    """The steps of a rollout from one agent's perspective; arrays ``(time, ...)`` that broadcast against each other."""

    reward: Float[Array, "time ..."]
    terminated: Bool[Array, "time ..."]
    """The agent's future has value 0."""
    truncated: Bool[Array, "time ..."]
    """The episode ended, but the agent's future still has a value."""
    valid: Bool[Array, "time ..."]
    """False where the environment idles after an episode's end, until the next restart."""
    decided: Bool[Array, "time ..."] | None = None
    """Whether a decision was made; None if there was one in every step."""


class Advantages(NamedTuple):
    """Estimates from a rollout; arrays ``(time, ...)``."""

    advantage: Float[Array, "time ..."]
    """How much better the decision was than expected; meaningless where there was none."""
    target: Float[Array, "time ..."]
    """The lambda-return: the target for the critic."""


def generalised_advantage(
    steps: Transitions, value: Float[Array, "after ..."], *, discount: Number, gae_lambda: Number
) -> Advantages:
    """Estimate advantages by generalised advantage estimation (Schulman 2016, eq. 16).

    Without ``decided``, every step is a decision. With it, a decision lasts until the next one (Sutton 1999, options):
    the temporal difference spans all its steps, lambda applies once per decision, and ``value`` matters only at
    decisions, in final states, and after the last step.

    ``value[t + 1]`` is the value of the state after step t, before any reset: after an episode's last step, the
    environment idles for at least one step, which is not ``valid`` and shows the final state. So a truncated step
    bootstraps from ``value[t + 1]`` and a terminated one from 0; neither uses later steps; and an idle step has
    advantage 0.
    """
    decided = jnp.ones((), bool) if steps.decided is None else steps.decided
    ends = steps.terminated | steps.truncated
    each = tuple(jnp.broadcast_arrays(steps.reward, value[:-1], steps.terminated, ends, steps.valid, decided))

    def backwards(later: tuple[Array, Array], step: tuple[Array, ...]) -> tuple[tuple[Array, Array], Advantages]:
        reward, value, terminated, ends, valid, decided = step
        expected, advantage = later  # those of the next decision, discounted to the next step
        expected = reward + discount * jnp.where(terminated, 0.0, expected)
        surplus = discount * jnp.where(ends, 0.0, advantage)
        advantage = jnp.where(valid, expected - value + gae_lambda * surplus, 0.0)
        expected = jnp.where(valid & ~decided, expected, value)
        carried = jnp.where(valid & ~decided, surplus, advantage)
        return (expected, carried), Advantages(advantage, value + advantage)

    last = jnp.broadcast_to(value[-1], each[0].shape[1:])
    _, found = jax.lax.scan(backwards, (last, jnp.zeros_like(last)), each, reverse=True)
    return found


def normalised(
    x: Float[Array, "..."], weight: Float[Array, "..."], axis: Axis = (), unit: Float[Array, "..."] | None = None
) -> Float[Array, "..."]:
    """Return the array shifted and scaled to weighted mean 0 and standard deviation 1; 0 where the weight is 0.

    With ``axis``, mean and deviation are over the arrays of all shards. With ``unit``, its standard deviation is the
    divisor instead of the array's own.
    """
    weight = jnp.broadcast_to(weight, x.shape)
    total = jnp.maximum(jax.lax.psum(jnp.sum(weight), axis), 1.0)

    def mean_of(y: Array) -> Array:
        return jax.lax.psum(jnp.sum(weight * y), axis) / total

    mean = mean_of(x)
    variance = mean_of((x - mean) ** 2 if unit is None else (unit - mean_of(unit)) ** 2)
    return jnp.where(weight > 0, (x - mean) * jax.lax.rsqrt(variance + 1e-8), 0.0)
