"""Multi-agent PPO (Schulman 2017; for several agents Yu 2022): `init` once, then `update` again and again.

One update plays a rollout with the current actors, judges every action by generalised advantages, and improves every
network on it. Actors and critics share no weights, so each is fitted on its own: a role more is a turn of a loop more.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jaxtyping import Array, Int, Key

from jaxwalk.interfaces import ByRole, Environment, Policy
from jaxwalk.learning.actor import GATED, Actor, make_actor
from jaxwalk.learning.advantages import normalised
from jaxwalk.learning.config import ROLES, TrainConfig
from jaxwalk.learning.critics import SHARED, Critic, Judgement, judge, make_critics
from jaxwalk.learning.experience import fresh_memory, look, make_act
from jaxwalk.learning.fit import fit, learning_rate, only_weighty, optimiser
from jaxwalk.learning.losses import Actions, Targets, actor_loss, critic_loss, explained_variance
from jaxwalk.learning.monitor import by_agent, episode_metrics, reward_metrics
from jaxwalk.rollout import Step, Stream, environment_keys, rollout, start

GATED_PART = 8
"""A gated role learns from at most this part (1 / 8) of its rows, which hold its decisions; they are far fewer."""
NOBODY: ByRole[Policy | None] = ByRole(driver=None, pedestrian=None)
"""No fixed policies: every role learns."""


class Learner(eqx.Module):
    """Everything that training changes or continues from. A checkpoint holds exactly this."""

    actors: dict[str, Actor]
    """By role; only of roles that learn."""
    critics: dict[str, Critic]
    """By role, or the one named ``shared``."""
    actor_memories: dict[str, optax.OptState]
    """What the actors' optimisers remember."""
    critic_memories: dict[str, optax.OptState]
    """What the critics' optimisers remember."""
    others: ByRole[Policy | None]
    """Who plays the roles that don't learn."""
    stream: Stream
    """The environments in the middle of their episodes."""
    key: Key[Array, ""]
    """For the shuffling: each update folds in its number."""
    updates: Int[Array, ""]
    """Updates made."""
    planned: Int[Array, ""]
    """Updates in the whole training, as far as the annealing knows: `init` takes it from the configuration."""


@eqx.filter_jit
def init(
    environment: Environment, config: TrainConfig, key: Key[Array, ""], *, others: ByRole[Policy | None] = NOBODY
) -> Learner:
    """An untrained learner, its environments at the start of their first episodes."""
    _check_others(config, others)
    stream_key, actor_key, critic_key, shuffle_key = jax.random.split(key, 4)
    memory = fresh_memory(environment, config, others)
    stream = start(environment, environment_keys(stream_key, 0, config.environments), memory)
    views = look(environment, config, stream.scenario, stream.state)
    actors = {}
    for role, k in zip(config.learning_roles, jax.random.split(actor_key, len(config.learning_roles)), strict=True):
        size = views.observations[role][config.role(role).observes].shape[0]
        actors[role] = make_actor(k, size, getattr(environment.roles, role).action, config.role(role))
    critics = make_critics(environment, config, views, critic_key)
    learner = Learner(
        actors=actors,
        critics=critics,
        actor_memories={name: optimiser(config).init(actor) for name, actor in actors.items()},  # pyright: ignore
        critic_memories={name: optimiser(config).init(critic) for name, critic in critics.items()},  # pyright: ignore
        others=others,
        stream=stream,
        key=shuffle_key,
        updates=jnp.zeros((), jnp.int32),
        planned=jnp.asarray(config.updates, jnp.int32),
    )
    return jax.tree.map(_strongly_typed, learner)


@eqx.filter_jit
def update(environment: Environment, config: TrainConfig, learner: Learner) -> tuple[Learner, dict[str, Array]]:
    """Play a rollout and learn from it; returns the learner and scalars to log.

    Nothing is donated: what goes in stays usable, and it is small beside the rollout.
    """
    act = make_act(environment, config, learner.actors, learner.others)
    memory = fresh_memory(environment, config, learner.others)
    stream, played = rollout(environment, act, learner.stream, config.steps, fresh_memory=memory)
    final = look(environment, config, stream.scenario, stream.state)
    judgements = {name: judge(config, critic, played, final) for name, critic in learner.critics.items()}

    actors, actor_memories, actor_metrics = _improve_actors(environment, config, learner, played, judgements)
    critics, critic_memories, critic_metrics = _improve_critics(config, learner, played, judgements)
    metrics = actor_metrics | critic_metrics
    metrics["finite"] = jnp.all(jnp.isfinite(jnp.stack(list(metrics.values())))).astype(jnp.float32)
    valid = played.valid.astype(jnp.float32)
    metrics |= reward_metrics(played.outcome.rewards, valid) | episode_metrics(played.outcome, valid)
    metrics["learning_rate"] = learning_rate(config, learner.updates, learner.planned)
    updates = learner.updates + 1
    metrics["steps"] = updates.astype(jnp.float32) * (config.steps * config.environments)
    learner = Learner(
        actors, critics, actor_memories, critic_memories, learner.others, stream, learner.key, updates, learner.planned
    )
    return learner, metrics


def _check_others(config: TrainConfig, others: ByRole[Policy | None]) -> None:
    for role in ROLES:
        given = getattr(others, role) is not None
        if given and config.role(role).learns:
            raise ValueError(f"others: the {role} learns, so no fixed policy can play it")
        if not given and not config.role(role).learns:
            raise ValueError(f"others: the {role} doesn't learn, so a fixed policy must play it")


def _strongly_typed(x: Any) -> Any:
    """The same array without JAX's weak type, which the first `update` would lose and so compile twice."""
    numeric = eqx.is_array(x) and not jnp.issubdtype(x.dtype, jax.dtypes.prng_key)
    return x.astype(x.dtype) if numeric else x


def _shuffle_keys(learner: Learner, kind: int, count: int) -> Key[Array, " count"]:
    """Keys of this update for that many networks; ``kind`` tells actors (0) from critics (1)."""
    return jax.random.split(jax.random.fold_in(jax.random.fold_in(learner.key, learner.updates), kind), count)


def _improve_actors(
    environment: Environment, config: TrainConfig, learner: Learner, played: Step, judgements: dict[str, Judgement]
) -> tuple[dict[str, Actor], dict[str, optax.OptState], dict[str, Array]]:
    """Fit every actor to the rollout."""
    weight = played.valid.astype(jnp.float32)
    actors, memories, metrics = {}, {}, {}
    for (role, actor), key in zip(learner.actors.items(), _shuffle_keys(learner, 0, len(learner.actors)), strict=True):
        advantage = judgements[SHARED if config.credit == "shared" else role].advantage
        observation = played.record.views.observations[role][actor.observes]
        counts = by_agent(weight, advantage) * (observation[:, 0] > 0 if actor.kind == GATED else 1.0)
        data = Actions(
            observation=observation,
            raw=played.record.raw[role],
            log_prob=played.record.log_prob[role],
            advantage=normalised(advantage, counts),
            weight=counts,
        )
        agents, environments = math.prod(getattr(environment.roles, role).agents), config.environments
        if actor.kind == GATED:
            agents, environments = 1, -(-agents * environments // GATED_PART)
            data = only_weighty(data, columns=environments)
        actors[role], memories[role], report = fit(
            partial(actor_loss, clip=config.clip, entropy=config.role(role).entropy),
            actor,
            learner.actor_memories[role],
            data,
            key=key,
            rate=learning_rate(config, learner.updates, learner.planned),
            epochs=config.role(role).epochs,
            agents=agents,
            environments=environments,
            config=config,
        )
        metrics |= {f"{role}/{name}": x for name, x in report.items()}
        if actor.log_std is not None:
            metrics[f"{role}/std"] = jnp.mean(jnp.exp(actors[role].log_std))
    return actors, memories, metrics


def _improve_critics(
    config: TrainConfig, learner: Learner, played: Step, judgements: dict[str, Judgement]
) -> tuple[dict[str, Critic], dict[str, optax.OptState], dict[str, Array]]:
    """Fit every critic to the rollout; a shared one as often as the role with the most epochs."""
    weight = played.valid.astype(jnp.float32)
    critics, memories, metrics = {}, {}, {}
    for (name, critic), key in zip(
        learner.critics.items(), _shuffle_keys(learner, 1, len(learner.critics)), strict=True
    ):
        judgement = judgements[name]
        roles = config.learning_roles if name == SHARED else (name,)
        critics[name], memories[name], report = fit(
            partial(critic_loss, coefficient=config.value_coefficient),
            critic,
            learner.critic_memories[name],
            Targets(critic.select(played.record.views), judgement.target, weight),
            key=key,
            rate=learning_rate(config, learner.updates, learner.planned),
            epochs=max(config.role(role).epochs for role in roles),
            agents=math.prod(critic.agents),
            environments=config.environments,
            config=config,
        )
        valid = by_agent(weight, judgement.target)
        metrics |= {f"{name}/critic_{key}": x for key, x in report.items()}
        metrics[f"{name}/explained_variance"] = explained_variance(judgement.value, judgement.target, valid)
    return critics, memories, metrics
