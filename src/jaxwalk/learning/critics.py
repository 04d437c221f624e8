"""Critics: what they read, what reward they predict, and the advantages estimated with them."""

from __future__ import annotations

import math
from functools import partial, reduce

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Key

from jaxwalk.interfaces import Environment, Outcome
from jaxwalk.learning.actor import CHOSEN_PART
from jaxwalk.learning.advantages import Transitions, generalised_advantage
from jaxwalk.learning.casting import Shard, width
from jaxwalk.learning.config import GLOBAL, SHARED, TrainConfig
from jaxwalk.learning.experience import Views, ViewShapes, critic_reads
from jaxwalk.learning.fit import map_chunks, plan_chunks, take_rows
from jaxwalk.learning.monitor import by_agent
from jaxwalk.learning.networks import MLP, make_mlp
from jaxwalk.learning.risk import Multiplier, charge
from jaxwalk.rollout import Step

FORWARD_CHUNKS = 4
"""Factor on the size of chunks when no gradient is kept: large products are faster."""


class Critic(eqx.Module):
    """A critic: a value for each agent of a role, or one value for everybody."""

    network: MLP
    """The network from the critic's input to one number."""
    role: str = eqx.field(static=True)
    """The role whose observations it reads; ``shared`` reads none."""
    reads: tuple[str, ...] = eqx.field(static=True)
    """Observation sets of the role, and ``"global"``: names in the role's `Views`."""
    agents: tuple[int, ...] = eqx.field(static=True)
    """The agent axes of its values."""
    cost: str | None = eqx.field(static=True, default=None)
    """Name of the role's cost that it predicts; None: it predicts the reward."""

    def __call__(self, views: Views) -> Float[Array, "..."]:
        """Return the values ``(*agents, *batch)``."""
        return self.network(critic_input(views[self.role], self.reads, self.agents))[0]

    def select(self, views: Views) -> Views:
        """Return the part of ``views`` that it reads."""
        return {self.role: {name: views[self.role][name] for name in self.reads}}


class Estimates(eqx.Module):
    """A critic's values in a rollout, and the advantages from them; arrays ``(time, *agents, env)``."""

    value: Float[Array, "..."]
    """The critic's estimate for the state before the step, where it was computed."""
    advantage: Float[Array, "..."]
    """How much better the decision was than the estimate."""
    target: Float[Array, "..."]
    """The target of the estimate: the lambda-return."""
    weight: Float[Array, "..."]
    """1 where the critic learns from the target, 0 elsewhere."""


def critic_input(
    seen: dict[str, Float[Array, "_ ..."]], names: tuple[str, ...], agents: tuple[int, ...]
) -> Float[Array, "feature ..."]:
    """Return the named observation sets, concatenated; the global state is repeated for every agent."""

    def view(name: str) -> Array:
        if name != GLOBAL:
            return seen[name]
        feature, *batch = seen[name].shape
        spread = seen[name].reshape(feature, *(1,) * len(agents), *batch)
        return jnp.broadcast_to(spread, (feature, *agents, *batch))

    return jnp.concatenate([view(name) for name in names], axis=0)


def make_critics(
    environment: Environment, config: TrainConfig, views: ViewShapes, key: Key[Array, ""]
) -> dict[str, Critic]:
    """Return untrained critics by name: of the rewards, then of the costs that have limits."""
    shared = config.credit == "shared"
    of_rewards = {role: (role, None) for role in ((SHARED,) if shared else config.learning_roles)}
    wanted = of_rewards | {name: (role, limit.cost) for name, (role, limit) in config.limits.items()}
    critics = {}
    for (name, (role, cost)), k in zip(wanted.items(), jax.random.split(key, len(wanted)), strict=True):
        reads = (GLOBAL,) if shared else critic_reads(config.roles[role].critic_observes, views[role])
        agents = () if shared else environment.roles[role].agents
        hidden = config.shared_critic_hidden if shared else config.roles[role].critic_hidden
        size = jax.eval_shape(partial(critic_input, names=reads, agents=agents), views[role]).shape[0]
        critics[name] = Critic(make_mlp(k, (size, *hidden, 1), final_scale=1.0), role, reads, agents, cost)
    return critics


def estimate_advantages(
    shard: Shard, name: str, critic: Critic, played: Step, final: Views, multipliers: dict[str, Multiplier]
) -> Estimates:
    """Estimate the values of the rollout's states and of the ``final`` one after it, and the advantages.

    ``name`` is the critic's. ``multipliers`` say what costs are charged.

    For a gated role, values are estimated only at decisions and at the ends of episodes. From those states alone a
    critic would learn nothing about others, in which a rollout may end: so it also learns from the rollout's first
    states, whatever they are.
    """
    config, shared = shard.config, critic.role == SHARED
    own = slice(0, config.environments) if shared else shard.columns[critic.role].own
    decided = None if shared else played.record.choices[critic.role].decided
    views = critic.select(played.record.views)
    if decided is None:
        values = _values(config, critic, views, own)
    else:
        final_shown = jnp.roll(played.valid & played.outcome.ended, 1, axis=0)
        values = _sparse_values(critic, views, decided, final_shown[:, own])
    valid = by_agent(played.valid[:, own], values)
    if critic.cost is None:
        reward = shard.numbers.reward_scale * _reward(config, critic.role, played, own)
    else:
        cost = played.outcome.costs[critic.role][critic.cost][..., own]
        reward = charge(config.limits[name][1], multipliers[name], cost)
    reward = jnp.where(valid, reward, 0.0)
    terminated, truncated = (end[..., own] for end in _ends(critic.role, played.outcome))
    found = generalised_advantage(
        Transitions(reward, terminated, truncated, valid, decided),
        jnp.concatenate([values, critic(final)[None]]),
        discount=shard.numbers.discount,
        gae_lambda=shard.numbers.gae_lambda,
    )
    learns = valid if decided is None else valid & decided.at[0].set(True)
    return Estimates(values, found.advantage, found.target, learns.astype(jnp.float32))


def _ends(role: str, outcome: Outcome) -> tuple[Bool[Array, "time ..."], Bool[Array, "time ..."]]:
    """Return where a role's agents terminated and were truncated. A shared future ends as soon as anybody's does."""
    if role != SHARED:
        return outcome.terminated[role], outcome.truncated[role]
    flat = [x.reshape(x.shape[0], -1, x.shape[-1]).any(axis=1) for x in outcome.terminated.values()]
    terminated = reduce(jnp.logical_or, flat)
    return terminated, outcome.ended & ~terminated


def _values(config: TrainConfig, critic: Critic, views: Views, own: slice) -> Float[Array, "time *agents env"]:
    """Return the values of all states of a rollout."""
    rows, agents = FORWARD_CHUNKS * config.chunk_rows, math.prod(critic.agents)
    chunks = plan_chunks(agents=agents, environments=width(own), steps=config.steps, rows=rows)
    return map_chunks(critic, views, chunks=chunks)


def _sparse_values(
    critic: Critic, views: Views, decided: Bool[Array, "time *agents env"], final: Bool[Array, "time env"]
) -> Float[Array, "time *agents env"]:
    """Return values at decisions, in final states and in the first states; 0 elsewhere."""
    asked = (decided | by_agent(final, decided)).at[0].set(True)
    room = -(-asked.size // CHOSEN_PART)

    def some(progress: tuple[Array, Array]) -> tuple[Array, Array]:
        waiting, values = progress
        rows = jnp.nonzero(waiting, size=room, fill_value=waiting.shape[0])  # an index beyond the last one is nobody
        found = critic.network(critic_input(take_rows(views[critic.role], rows), critic.reads, ()))[0]
        return waiting.at[rows].set(False, mode="drop"), values.at[rows].set(found, mode="drop")

    _, values = jax.lax.while_loop(lambda progress: progress[0].any(), some, (asked, jnp.zeros(asked.shape)))
    return values


def blended_reward(rewards: dict[str, Float[Array, "time ..."]]) -> Float[Array, "time env"]:
    """Return the mean over roles of the mean over a role's agents: with two, half and half (paper)."""
    means = [jnp.mean(reward.reshape(reward.shape[0], -1, reward.shape[-1]), axis=1) for reward in rewards.values()]
    return jnp.mean(jnp.stack(means), axis=0)


def _reward(config: TrainConfig, name: str, played: Step, own: slice) -> Float[Array, "time ..."]:
    """Return the unscaled reward whose sum the critic predicts. Roles that don't learn have no part in a shared one."""
    rewards = {role: sum(played.outcome.rewards[role].values(), start=jnp.zeros(())) for role in config.learning_roles}
    return (blended_reward(rewards) if name == SHARED else rewards[name])[..., own]
