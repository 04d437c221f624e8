"""A policy that can be trained: a network, and the distribution with its outputs as parameters."""

from __future__ import annotations

import math

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, Key

from jaxwalk.columns import apply_where
from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning.config import RoleConfig
from jaxwalk.learning.distributions import Categorical, ClippedGaussian, Distribution, TanhGaussian
from jaxwalk.learning.networks import MLP, make_mlp

DISCRETE, GATED = "discrete", "gated"
"""The kinds of policy with discrete actions: one decides everywhere, the other only where the observation's first
feature is above 0. The kinds with continuous actions are those of `RoleConfig.noise`."""
OTHERWISE = 1
"""A gated policy's action where there is nothing to decide."""
NO_CHOICE = -1
"""A choice that is in no space, in place of one from logits that aren't finite. A continuous action is NaN instead."""
CHOSEN_PART = 16
"""A gated network runs on one part in 16 of the columns at once: slightly more than a step usually selects."""


class Actor(eqx.Module):
    """The policy that all agents of a role share."""

    network: MLP
    """The network from observations to logits or means."""
    log_std: Float[Array, " size"] | None
    """Log standard deviation of each component of a continuous action; it does not depend on the observation."""
    observes: str = eqx.field(static=True)
    """Name of the observation set that the policy reads."""
    kind: str = eqx.field(static=True)
    """``discrete``, ``gated``, ``clipped`` or ``tanh``."""
    hold: int = eqx.field(static=True, default=1)
    """Steps for which a gated policy keeps a decision."""

    def __call__(self, observation: Float[Array, "feature *rest"]) -> Distribution:
        """Return the distribution of every agent's action; for a gated policy, of its decisions."""
        return self.distribution(self.network(observation))

    def distribution(self, outputs: Float[Array, "out *rest"]) -> Distribution:
        """Return the distribution with the network's outputs as parameters."""
        if self.log_std is None:
            return Categorical(outputs)
        if self.kind == "clipped":
            return ClippedGaussian(jnp.tanh(outputs), self.log_std)
        return TanhGaussian(outputs, self.log_std)

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Held | None:
        """Return the memory at the start of an episode; None unless the policy is gated."""
        nothing = jnp.zeros((*agents, *batch), jnp.int32)
        return Held(nothing, nothing) if self.kind == GATED else None


class Held(eqx.Module):
    """A gated policy's memory: arrays ``(*agents, *batch)``."""

    choice: Int[Array, "*rest"]
    """The last decision."""
    steps_left: Int[Array, "*rest"]
    """Steps for which the decision is still valid, as long as there is something to decide."""


class Choice(eqx.Module):
    """An actor's action, and how it was chosen."""

    action: Array
    """The action that the environment gets."""
    raw: Array
    """The sample before clipping or squashing."""
    log_prob: Float[Array, "*rest"]
    """Log-probability of the sample, where a decision was made now."""
    decided: Bool[Array, "*rest"] | None
    """Whether a decision was made now; None if there is one in every step."""


def decide(
    actor: Actor, key: Key[Array, "*batch"], memory: Held | None, observation: Float[Array, "feature *rest"], *,
    sample: bool, checked: bool = False,
) -> tuple[Choice, Held | None]:  # fmt: skip
    """Return every agent's action and the new memory; without ``sample``, the likeliest action. Not differentiable.

    If ``checked``, an action is in no space (NaN, or `NO_CHOICE`) where the network's outputs or the sample aren't
    finite. A learner doesn't check its own, whose losses tell.
    """
    check = _if_finite if checked else _unchecked
    if memory is None:
        outputs = actor.network(observation)
        choice = actor.distribution(outputs)
        raw = choice.sample(key) if sample else choice.mode()
        return Choice(check(choice.action(raw), outputs, raw), raw, choice.log_prob(raw), None), None
    may = observation[0] > 0
    now = may & (memory.steps_left == 0)
    logits = apply_where(actor.network, observation, now, CHOSEN_PART)
    choice = Categorical(logits)
    raw = choice.sample(key) if sample else choice.mode()
    new = check(raw, logits, raw)
    kept = jnp.where(now, new, memory.choice)
    steps_left = jnp.where(now, actor.hold - 1, memory.steps_left - 1)
    action = jnp.where(may, kept, OTHERWISE)
    return Choice(action, action, choice.log_prob(action), now), Held(kept, jnp.where(may, steps_left, 0))


def _if_finite(action: Array, outputs: Float[Array, "out *rest"], raw: Array) -> Array:
    """Return the action where outputs and sample are finite, else one in no space: argmax and tanh would hide it."""
    finite = (jnp.isfinite(outputs) & jnp.isfinite(raw)).all(axis=0)
    return jnp.where(finite, action, NO_CHOICE if jnp.issubdtype(action.dtype, jnp.integer) else jnp.nan)


def _unchecked(action: Array, outputs: Float[Array, "out *rest"], raw: Array) -> Array:
    return action


def make_actor(key: Key[Array, ""], observation_size: int, action: Box | Discrete, config: RoleConfig) -> Actor:
    """Return an untrained actor; its actions hardly depend on the observation."""
    discrete = isinstance(action, Discrete)
    outputs = action.n if isinstance(action, Discrete) else action.size
    network = make_mlp(key, (observation_size, *config.actor_hidden, outputs), final_scale=0.01)
    log_std = None if discrete else jnp.full(outputs, math.log(config.initial_std), jnp.float32)
    kind = (GATED if config.gated else DISCRETE) if discrete else config.noise
    return Actor(network, log_std, observes=config.observes, kind=kind, hold=config.hold)
