"""A policy that can be trained: a network and the distribution that it parametrises."""

from __future__ import annotations

import math

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Key

from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning.config import RoleConfig
from jaxwalk.learning.distributions import Categorical, ClippedGaussian, Distribution, Gated, TanhGaussian
from jaxwalk.learning.networks import MLP, make_mlp

DISCRETE, GATED = "discrete", "gated"
"""The kinds of policy that choose among n, everywhere or where the first feature of the observation is above 0; the
kinds of continuous policies are `RoleConfig.noise`."""


GLANCE_PART = 16
"""A gated network sees this part (1 / 16) of the agents at once: somewhat more than have to decide at a time."""


class Actor(eqx.Module):
    """All agents of a role share one."""

    network: MLP
    """From observation to logits or means."""
    log_std: Float[Array, " size"] | None
    """Log standard deviation of each number of a continuous action, the same everywhere."""
    observes: str = eqx.field(static=True)
    """The observation set it reads."""
    kind: str = eqx.field(static=True)
    """``discrete``, ``gated``, ``clipped`` or ``tanh``."""

    def __call__(self, observation: Float[Array, "feature *rest"]) -> Distribution:
        """The distribution of every agent's action."""
        out = self.network(observation)
        if self.log_std is None:
            return Gated(Categorical(out), observation[0] > 0) if self.kind == GATED else Categorical(out)
        if self.kind == "clipped":
            return ClippedGaussian(jnp.tanh(out), self.log_std)
        return TanhGaussian(out, self.log_std)


def glance(actor: Actor, observation: Float[Array, "feature *rest"]) -> Distribution:
    """It says the same as ``actor(observation)``, sooner, but can't be differentiated.

    Few of a gated role's agents have anything to decide at a time, so its network sees only those, some columns at
    once, until all are seen. Logits are 0 where there is nothing to decide.
    """
    if actor.kind != GATED:
        return actor(observation)
    columns = observation.reshape(observation.shape[0], -1)
    count = columns.shape[1]
    places = -(-count // GLANCE_PART)

    def some(left: tuple[Array, Array]) -> tuple[Array, Array]:
        waiting, logits = left
        (chosen,) = jnp.nonzero(waiting, size=places, fill_value=count)  # beyond the last: nobody
        seen = actor.network(columns.at[:, chosen].get(mode="fill", fill_value=0))
        return waiting.at[chosen].set(False, mode="drop"), logits.at[:, chosen].set(seen, mode="drop")

    outputs = actor.network.sizes[-1]
    begin = (columns[0] > 0, jnp.zeros((outputs, count), columns.dtype))
    _, logits = jax.lax.while_loop(lambda left: left[0].any(), some, begin)
    return Gated(Categorical(logits.reshape(outputs, *observation.shape[1:])), observation[0] > 0)


def make_actor(key: Key[Array, ""], observation_size: int, action: Box | Discrete, config: RoleConfig) -> Actor:
    """An untrained actor, whose actions hardly depend on what it sees."""
    discrete = isinstance(action, Discrete)
    outputs = action.n if isinstance(action, Discrete) else action.size
    network = make_mlp(key, (observation_size, *config.actor_hidden, outputs), final_scale=0.01)
    log_std = None if discrete else jnp.full(outputs, math.log(config.initial_std), jnp.float32)
    kind = (GATED if config.gated else DISCRETE) if discrete else config.noise
    return Actor(network, log_std, observes=config.observes, kind=kind)
