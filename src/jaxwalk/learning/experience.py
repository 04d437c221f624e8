"""Gathering experience: who acts, and what is recorded of it."""

from __future__ import annotations

from typing import Any

import equinox as eqx
import jax
from jaxtyping import Array, Float, Key

from jaxwalk.interfaces import ByRole, Environment, Policy
from jaxwalk.learning.actor import Actor, glance
from jaxwalk.learning.config import GLOBAL, ROLES, TrainConfig
from jaxwalk.rollout import Act


class Views(eqx.Module):
    """What actors and critics see of a state."""

    observations: dict[str, dict[str, Float[Array, "_ ..."]]]
    """Of each learning role, each observation set that its actor or critic reads."""
    world: Float[Array, "_ *batch"] | None
    """The global state, if any critic reads it."""


class Record(eqx.Module):
    """What a rollout keeps of each step; of learning roles only."""

    views: Views
    """Before the step."""
    raw: dict[str, Array]
    """What each role's actor sampled, before clipping or squashing."""
    log_prob: dict[str, Float[Array, "..."]]
    """Its log-probability: ``(*agents, *batch)``."""


def look(environment: Environment, config: TrainConfig, scenario: Any, state: Any) -> Views:
    """Everything that learning reads of a state."""
    shared = config.credit == "shared"
    observations = {}
    world = shared
    for role in config.learning_roles:
        choice = config.role(role)
        names = {choice.observes} | (set() if shared else set(choice.critic_observes))
        world = world or GLOBAL in names
        observations[role] = {
            name: environment.observe(scenario, state, role, name) for name in sorted(names - {GLOBAL})
        }
    return Views(observations, environment.global_state(scenario, state) if world else None)


def make_act(
    environment: Environment, config: TrainConfig, actors: dict[str, Actor], others: ByRole[Policy | None]
) -> Act:
    """Learning roles sample from their actors and are recorded; the others follow their fixed policies."""

    def act(key: Key[Array, "env"], scenario: Any, state: Any, memory: ByRole) -> tuple[ByRole, ByRole, Record]:
        views = look(environment, config, scenario, state)
        actions, memories, raw, log_prob = {}, {}, {}, {}
        for index, role in enumerate(ROLES):
            role_key = jax.vmap(jax.random.fold_in, in_axes=(0, None))(key, index)
            memories[role] = getattr(memory, role)
            if role in actors:
                choice = glance(actors[role], views.observations[role][actors[role].observes])
                raw[role] = choice.sample(role_key)  # type: ignore[reportArgumentType]
                log_prob[role] = choice.log_prob(raw[role])
                actions[role] = choice.action(raw[role])
            else:
                policy = getattr(others, role)
                observation = environment.observe(scenario, state, role, policy.observes)
                actions[role], memories[role] = policy.act(role_key, memories[role], observation)
        return ByRole(**actions), ByRole(**memories), Record(views, raw, log_prob)

    return act


def fresh_memory(environment: Environment, config: TrainConfig, others: ByRole[Policy | None]) -> ByRole:
    """What the fixed policies remember at the start of an episode."""
    batch = (config.environments,)
    return ByRole(
        **{
            role: None
            if config.role(role).learns
            else getattr(others, role).init(getattr(environment.roles, role).agents, batch)
            for role in ROLES
        }
    )
