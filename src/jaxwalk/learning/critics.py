"""Critics: what they read, what reward they predict, and what they make of a rollout."""

from __future__ import annotations

import math

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Key

from jaxwalk.interfaces import Environment
from jaxwalk.learning.advantages import generalised_advantage
from jaxwalk.learning.config import GLOBAL, TrainConfig
from jaxwalk.learning.experience import Views
from jaxwalk.learning.fit import map_chunks, plan_chunks
from jaxwalk.learning.monitor import by_agent
from jaxwalk.learning.networks import MLP, make_mlp
from jaxwalk.rollout import Step

SHARED = "shared"
"""Name of the one critic of shared credit; the others are named after their roles."""


FORWARD_CHUNKS = 4
"""Judging keeps nothing for a gradient, so chunks may be this many times larger: large products are quicker."""


class Critic(eqx.Module):
    """A value for each agent of a role, or one for everybody."""

    network: MLP
    """From what it reads to one number."""
    role: str = eqx.field(static=True)
    """Whose observations it reads; ``shared`` reads none."""
    reads: tuple[str, ...] = eqx.field(static=True)
    """Observation sets of the role, and ``"global"``."""
    agents: tuple[int, ...] = eqx.field(static=True)
    """The agent axes of its values."""

    def __call__(self, views: Views) -> Float[Array, "..."]:
        """Values ``(*agents, *batch)``."""
        return self.network(critic_input(views, self.role, self.reads, self.agents))[0]

    def select(self, views: Views) -> Views:
        """The part of ``views`` that it reads."""
        own = {name: x for name, x in views.observations.get(self.role, {}).items() if name in self.reads}
        return Views({self.role: own}, views.world if GLOBAL in self.reads else None)


class Judgement(eqx.Module):
    """What a critic makes of a rollout; arrays ``(time, *agents, env)``."""

    value: Float[Array, "..."]
    """What it expected of the state before the step."""
    advantage: Float[Array, "..."]
    """How much better the step was."""

    @property
    def target(self) -> Float[Array, "..."]:
        """What it should have expected: the lambda-return."""
        return self.value + self.advantage


def critic_input(
    views: Views, role: str, names: tuple[str, ...], agents: tuple[int, ...]
) -> Float[Array, "feature ..."]:
    """The named observation sets of the role, one after the other; the global state for every agent."""

    def view(name: str) -> Array:
        if name != GLOBAL:
            return views.observations[role][name]
        assert views.world is not None
        feature, *batch = views.world.shape
        spread = views.world.reshape(feature, *(1,) * len(agents), *batch)
        return jnp.broadcast_to(spread, (feature, *agents, *batch))

    return jnp.concatenate([view(name) for name in names], axis=0)


def make_critics(environment: Environment, config: TrainConfig, views: Views, key: Key[Array, ""]) -> dict[str, Critic]:
    """Untrained critics, by name."""
    shared = config.credit == "shared"
    names = (SHARED,) if shared else config.learning_roles
    critics = {}
    for name, k in zip(names, jax.random.split(key, len(names)), strict=True):
        reads = (GLOBAL,) if shared else config.role(name).critic_observes
        agents = () if shared else getattr(environment.roles, name).agents
        hidden = config.shared_critic_hidden if shared else config.role(name).critic_hidden
        size = critic_input(views, name, reads, agents).shape[0]
        critics[name] = Critic(make_mlp(k, (size, *hidden, 1), final_scale=1.0), name, reads, agents)
    return critics


def judge(config: TrainConfig, critic: Critic, played: Step, final: Views) -> Judgement:
    """Values of all states of the rollout and of the ``final`` one after it, and the advantages."""
    rows = FORWARD_CHUNKS * config.chunk_rows
    agents = math.prod(critic.agents)
    chunks = plan_chunks(agents=agents, environments=config.environments, steps=config.steps, rows=rows)
    values = map_chunks(critic, critic.select(played.record.views), chunks=chunks)
    whose = "driver" if critic.role == SHARED else critic.role
    valid = by_agent(played.valid, values)
    advantage = generalised_advantage(
        jnp.where(valid, _reward(config, critic.role, played), 0.0),
        jnp.concatenate([values, critic(final)[None]]),
        getattr(played.outcome.terminated, whose),
        getattr(played.outcome.truncated, whose),
        valid,
        discount=config.discount,
        gae_lambda=config.gae_lambda,
    )
    return Judgement(values, advantage)


def blended_reward(rewards: dict[str, Float[Array, "time ..."]]) -> Float[Array, "time env"]:
    """The mean over roles of the mean over a role's agents: with two, half the car's and half the people's (paper)."""
    means = [jnp.mean(reward.reshape(reward.shape[0], -1, reward.shape[-1]), axis=1) for reward in rewards.values()]
    return jnp.mean(jnp.stack(means), axis=0)


def _reward(config: TrainConfig, name: str, played: Step) -> Float[Array, "time ..."]:
    """What that critic predicts the sum of. A role that doesn't learn pays into no shared reward."""
    rewards = {
        role: sum(getattr(played.outcome.rewards, role).values(), start=jnp.zeros(())) for role in config.learning_roles
    }
    return config.reward_scale * (blended_reward(rewards) if name == SHARED else rewards[name])
