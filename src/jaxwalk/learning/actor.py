"""A policy that can be trained: a network and the distribution that it parametrises."""

from __future__ import annotations

import math

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int, Key

from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning.config import RoleConfig
from jaxwalk.learning.distributions import Categorical, ClippedGaussian, Distribution, TanhGaussian
from jaxwalk.learning.networks import MLP, make_mlp

DISCRETE, GATED = "discrete", "gated"
"""The kinds of policy that choose among n, everywhere or where the first feature of the observation is above 0; the
kinds of continuous policies are `RoleConfig.noise`."""
OTHERWISE = 1
"""What a gated policy does where there is nothing to decide."""
CHOSEN_PART = 16
"""`run_where` runs a network on this part (1 / 16) of the columns at once: somewhat more than are chosen in a step."""


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
    hold: int = eqx.field(static=True, default=1)
    """Steps for which a gated policy's decision stands."""

    def __call__(self, observation: Float[Array, "feature *rest"]) -> Distribution:
        """The distribution of every agent's action; of a gated policy, where it decides."""
        outputs = self.network(observation)
        if self.log_std is None:
            return Categorical(outputs)
        if self.kind == "clipped":
            return ClippedGaussian(jnp.tanh(outputs), self.log_std)
        return TanhGaussian(outputs, self.log_std)

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Held | None:
        """Return what it remembers at the start of an episode; None unless it is gated."""
        nothing = jnp.zeros((*agents, *batch), jnp.int32)
        return Held(nothing, nothing) if self.kind == GATED else None


class Held(eqx.Module):
    """What a gated policy remembers: arrays ``(*agents, *batch)``."""

    choice: Int[Array, "*rest"]
    """Its last decision."""
    left: Int[Array, "*rest"]
    """Steps for which that still stands, if there is anything to decide."""


class Choice(eqx.Module):
    """What an actor does and how it came to it."""

    action: Array
    """What the environment gets."""
    raw: Array
    """What was sampled, before clipping or squashing."""
    log_prob: Float[Array, "*rest"]
    """Its log-probability, where it was decided now."""
    decided: Bool[Array, "*rest"] | None
    """Whether it was; None for all."""


def decide(
    actor: Actor, key: Key[Array, "*batch"], memory: Held | None, observation: Float[Array, "feature *rest"], *,
    sample: bool,
) -> tuple[Choice, Held | None]:  # fmt: skip
    """Every agent's action and what is remembered; without ``sample`` the likeliest one. Can't be differentiated."""
    if memory is None:
        choice = actor(observation)
        raw = choice.sample(key) if sample else choice.mode()
        return Choice(choice.action(raw), raw, choice.log_prob(raw), None), None
    may = observation[0] > 0
    now = may & (memory.left == 0)
    choice = Categorical(run_where(actor.network, observation, now))
    new = choice.sample(key) if sample else choice.mode()
    kept = jnp.where(now, new, memory.choice)
    left = jnp.where(now, actor.hold - 1, memory.left - 1)
    action = jnp.where(may, kept, OTHERWISE)
    return Choice(action, action, choice.log_prob(action), now), Held(kept, jnp.where(may, left, 0))


def run_where(
    network: MLP, columns: Float[Array, "feature *rest"], which: Bool[Array, "*rest"]
) -> Float[Array, "out *rest"]:
    """Run the network on the columns chosen by ``which``; elsewhere the outputs are 0. Can't be differentiated.

    Few columns are chosen, so the network runs on those alone, a part of them at a time.
    """
    flat = columns.reshape(columns.shape[0], -1)
    count = flat.shape[1]
    places = -(-count // CHOSEN_PART)

    def some(left: tuple[Array, Array]) -> tuple[Array, Array]:
        waiting, found = left
        (chosen,) = jnp.nonzero(waiting, size=places, fill_value=count)  # beyond the last: nobody
        seen = network(flat.at[:, chosen].get(mode="fill", fill_value=0))
        return waiting.at[chosen].set(False, mode="drop"), found.at[:, chosen].set(seen, mode="drop")

    outputs = network.sizes[-1]
    begin = (which.reshape(-1), jnp.zeros((outputs, count), columns.dtype))
    _, found = jax.lax.while_loop(lambda left: left[0].any(), some, begin)
    return found.reshape(outputs, *columns.shape[1:])


def make_actor(key: Key[Array, ""], observation_size: int, action: Box | Discrete, config: RoleConfig) -> Actor:
    """An untrained actor, whose actions hardly depend on what it sees."""
    discrete = isinstance(action, Discrete)
    outputs = action.n if isinstance(action, Discrete) else action.size
    network = make_mlp(key, (observation_size, *config.actor_hidden, outputs), final_scale=0.01)
    log_std = None if discrete else jnp.full(outputs, math.log(config.initial_std), jnp.float32)
    kind = (GATED if config.gated else DISCRETE) if discrete else config.noise
    return Actor(network, log_std, observes=config.observes, kind=kind, hold=config.hold)
