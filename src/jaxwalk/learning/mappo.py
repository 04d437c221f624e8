"""Multi-agent PPO (Schulman 2017; for several agents Yu 2022): call `init` once, then `update` repeatedly.

One update plays a rollout with the current actors, estimates the advantage of every action, and fits every network.
Actors and critics share no weights, so each is fitted separately: one more role is one more turn of a loop.

Devices can share the environments (`TrainConfig.shards`): each plays its own part and computes gradients from it.
Networks are the same on all devices, since sums go over all shards.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jax.sharding import Mesh, PartitionSpec
from jaxtyping import Array, Float, Int, Key

from jaxwalk.acting import fresh_memory, typed
from jaxwalk.interfaces import Environment, Policy, Roles
from jaxwalk.learning.actor import GATED, Actor, make_actor
from jaxwalk.learning.advantages import normalised
from jaxwalk.learning.casting import Shard, check_roles, learning_cast, remember, shard_of, snapshots, whole
from jaxwalk.learning.config import SHARED, TrainConfig
from jaxwalk.learning.critics import Critic, Estimates, estimate_advantages, make_critics
from jaxwalk.learning.experience import gather_views, recording_act
from jaxwalk.learning.fit import Entries, Fit, fit, gated_part, learning_rate, optimiser, pack_weighted
from jaxwalk.learning.hyperparameters import Hyperparameters, hyperparameters, without_hyperparameters
from jaxwalk.learning.losses import Actions, Targets, actor_loss, critic_loss, explained_variance
from jaxwalk.learning.monitor import all_finite, by_agent, rollout_metrics, sound_metrics
from jaxwalk.learning.risk import Multiplier, check_costs, constrained, fresh_multipliers, next_multipliers
from jaxwalk.rollout import Step, Stream, environment_keys, rollout, waiting
from jaxwalk.shards import EVERYWHERE, SHARDS, by_environment, everywhere, mesh_of, place

ONCE = {"xla_backend_optimization_level": 0}
"""Options for code that runs once: full optimisation would take longer than running the unoptimised code."""


class Learner(eqx.Module):
    """Everything that training changes, or needs to resume. A checkpoint holds exactly this."""

    actors: dict[str, Actor]
    """Actors by role, only of roles that learn."""
    critics: dict[str, Critic]
    """Critics by role, or the one named ``shared``; then those of costs, by role and cost."""
    early: dict[str, tuple[Actor, ...]]
    """By role, the actor as it was after each of `SNAPSHOTS` updates; empty if it plays nowhere."""
    actor_memories: dict[str, optax.OptState]
    """The states of the actors' optimisers."""
    critic_memories: dict[str, optax.OptState]
    """The states of the critics' optimisers."""
    others: Roles[Policy | None]
    """The policy of a role where its learner does not play; None if there is none."""
    stream: Stream
    """The environments in the middle of their episodes."""
    key: Key[Array, ""]
    """Key for shuffling: each update folds in its number."""
    updates: Int[Array, ""]
    """Number of updates so far."""
    planned: Int[Array, ""]
    """Updates in the whole training, for annealing: `init` takes it from the configuration."""
    parked: tuple[Stream, ...] = ()
    """The episodes of further environments that train in turns with the first one (`jaxwalk.learning.turns`)."""
    multipliers: dict[str, Multiplier] = eqx.field(default_factory=dict)
    """The multipliers of limits, by the names of their critics (`TrainConfig.limits`)."""


def init(
    environment: Environment, config: TrainConfig, key: Key[Array, ""], *, others: Roles[Policy | None] | None = None
) -> Learner:
    """Return an untrained learner, its environments waiting for their first episodes.

    ``others``: the policy of a role where its learner does not play; a role that is left out learns everywhere.

    Raises:
        ValueError: the configuration's roles are not the environment's; a gated role does not choose between 0 and 1; a
            cost that has a limit doesn't exist; or ``others`` names a role that does not exist, lacks a policy that is
            needed, or has one that is not.
        ShardsError: there are fewer devices than shards.
    """
    given = others or {}
    others = {role: given.get(role) for role in config.roles}
    check_roles(environment, config, {**given, **others})
    check_costs(environment, config)
    mesh = mesh_of(config.shards)
    learner = _untrained(environment, without_hyperparameters(config), key, others)
    learner = replace(learner, planned=jax.device_put(np.int32(config.updates)))
    return place(learner, _partition_specs(learner), mesh)


@eqx.filter_jit(compiler_options=ONCE)  # pyright: ignore[reportCallIssue] (it passes on what `jax.jit` takes)
def _untrained(
    environment: Environment, config: TrainConfig, key: Key[Array, ""], others: Roles[Policy | None]
) -> Learner:
    """Do the work of `init`, all of it on one device."""
    stream_key, actor_key, critic_key, shuffle_key = jax.random.split(key, 4)
    stream = waiting(environment, environment_keys(stream_key, 0, config.environments))
    everything, adam = whole(config), optimiser(hyperparameters(config))
    see = partial(gather_views, environment, everything)
    views = jax.eval_shape(see, stream.scenario, stream.state)
    actors = {}
    for role, k in zip(config.learning_roles, jax.random.split(actor_key, len(config.learning_roles)), strict=True):
        size = views[role][config.roles[role].observes].shape[0]
        actors[role] = make_actor(k, size, environment.roles[role].action, config.roles[role])
    critics = make_critics(environment, config, views, critic_key)
    early = snapshots(config, actors)
    cast = learning_cast(environment, shard_of(config, everything.numbers), actors, early, others)
    memory = fresh_memory(environment, cast, (config.environments,))
    learner = Learner(
        actors=actors,
        critics=critics,
        early=early,
        actor_memories={name: adam.init(actor) for name, actor in actors.items()},  # pyright: ignore
        critic_memories={name: adam.init(critic) for name, critic in critics.items()},  # pyright: ignore
        others=others,
        stream=eqx.tree_at(lambda s: s.memory, stream, memory, is_leaf=lambda x: x is None),
        key=shuffle_key,
        updates=jnp.zeros((), jnp.int32),
        planned=jnp.zeros((), jnp.int32),  # `init` sets it
        multipliers=fresh_multipliers(config),
    )
    return typed(learner)


def update(environment: Environment, config: TrainConfig, learner: Learner) -> tuple[Learner, dict[str, Array]]:
    """Play a rollout and learn from it; return the learner and scalars to log.

    Some scalars are 1 or 0. ``finite``: all others, every network and the optimisers' states are finite, and every
    action was in its space. ``fixed/ROLE``: every action of that role's fixed policy was. Nothing is donated: the input
    stays usable. Other `Hyperparameters`, or another plan, compile nothing anew.
    """
    compiled, numbers = _compiled_for(config)
    return _update_compiled(environment, compiled, numbers, learner)


@lru_cache(maxsize=16)
def _compiled_for(config: TrainConfig) -> tuple[TrainConfig, Hyperparameters]:
    """Return the configuration for which `update` is compiled, and the numbers that it takes, on every device."""
    with jax.ensure_compile_time_eval():  # `update` may be traced
        return without_hyperparameters(config), everywhere(hyperparameters(config), mesh_of(config.shards))


@eqx.filter_jit
def _update_compiled(
    environment: Environment, config: TrainConfig, numbers: Hyperparameters, learner: Learner
) -> tuple[Learner, dict[str, Array]]:
    return update_on(mesh_of(config.shards), environment, config, numbers, learner)


def update_on(
    mesh: Mesh, environment: Environment, config: TrainConfig, numbers: Hyperparameters, learner: Learner
) -> tuple[Learner, dict[str, Array]]:
    """Do the work of `update` on the devices of a mesh, which may be devices that are only described."""
    arrays, rest = eqx.partition((environment, numbers, learner), eqx.is_array)

    def work(arrays: tuple[Environment, Hyperparameters, Learner]) -> tuple[Learner, dict[str, Array]]:
        environment, numbers, learner = eqx.combine(arrays, rest)
        learner, metrics = _update(environment, shard_of(config, numbers), learner)
        return eqx.filter(learner, eqx.is_array), metrics

    specs = _partition_specs(learner)
    shared = jax.shard_map(
        work, mesh=mesh, in_specs=((EVERYWHERE, EVERYWHERE, specs),), out_specs=(specs, EVERYWHERE), check_vma=False
    )
    updated, metrics = shared(arrays)
    metrics["steps"] = updated.updates.astype(jnp.float32) * (config.steps * config.environments)
    return eqx.combine(updated, rest[-1]), metrics


def _update(environment: Environment, shard: Shard, learner: Learner) -> tuple[Learner, dict[str, Array]]:
    """Make an update on one device."""
    config = shard.config
    cast = learning_cast(environment, shard, learner.actors, learner.early, learner.others)
    memory = fresh_memory(environment, cast, (config.environments,))
    act = recording_act(environment, shard, cast)
    stream, played = rollout(environment, act, learner.stream, config.steps, fresh_memory=memory)
    final = gather_views(environment, shard, stream.scenario, stream.state)
    multipliers, limit_metrics = next_multipliers(shard, learner.multipliers, played)
    learner = replace(learner, multipliers=multipliers)
    estimates = {
        name: estimate_advantages(shard, name, critic, played, final, multipliers)
        for name, critic in learner.critics.items()
    }
    actors, actor_memories, actor_metrics = _improve_actors(environment, shard, learner, played, estimates)
    critics, critic_memories, critic_metrics = _improve_critics(shard, learner, played, estimates)
    metrics = actor_metrics | critic_metrics | limit_metrics
    metrics |= rollout_metrics(shard, played)
    metrics["learning_rate"] = _rate(shard, learner)
    updates = learner.updates + 1
    finite = all_finite((metrics, actors, critics, actor_memories, critic_memories))
    metrics |= sound_metrics(shard, played, learner.others)
    metrics["finite"] = finite * metrics.pop("sound")
    early = {role: remember(learner.early[role], actor, updates) for role, actor in actors.items()}
    learner = Learner(
        actors, critics, early, actor_memories, critic_memories, learner.others, stream, learner.key, updates,
        learner.planned, multipliers=multipliers,
    )  # fmt: skip
    return learner, metrics


def _partition_specs(learner: Learner) -> Any:
    """Return the learner with a `PartitionSpec` in place of each array.

    Devices share the environments; everything else is on each of them.
    """
    specs: Any = jax.tree.map(lambda _: EVERYWHERE, eqx.filter(learner, eqx.is_array))
    return eqx.tree_at(
        lambda x: x.stream, specs, by_environment(learner.stream), is_leaf=lambda x: isinstance(x, PartitionSpec)
    )


def _shuffle_keys(learner: Learner, kind: int, count: int) -> Key[Array, " count"]:
    """Return this update's keys for a number of networks; ``kind`` separates actors (0) from critics (1)."""
    return jax.random.split(jax.random.fold_in(jax.random.fold_in(learner.key, learner.updates), kind), count)


def _improve_actors(
    environment: Environment, shard: Shard, learner: Learner, played: Step, estimates: dict[str, Estimates]
) -> tuple[dict[str, Actor], dict[str, optax.OptState], dict[str, Array]]:
    """Fit every actor to the rollout."""
    config = shard.config
    actors, memories, metrics = {}, {}, {}
    for (role, actor), key in zip(learner.actors.items(), _shuffle_keys(learner, 0, len(learner.actors)), strict=True):
        of_reward = advantage = estimates[SHARED if config.credit == "shared" else role].advantage
        limits = [name for name, (limited, _) in config.limits.items() if limited == role]
        if limits:
            advantage = constrained(advantage, [(learner.multipliers[x].value, estimates[x].advantage) for x in limits])
        choice, own = played.record.choices[role], shard.columns[role].own
        counts = by_agent(played.valid[:, own].astype(jnp.float32), advantage)
        counts = counts if choice.decided is None else counts * choice.decided
        data = Actions(
            observation=played.record.views[role][actor.observes],
            raw=choice.raw,
            log_prob=choice.log_prob,
            advantage=normalised(advantage, counts, SHARDS, of_reward if limits else None),
            weight=counts,
        )
        loss = partial(actor_loss, clip=shard.numbers.clip, entropy=shard.numbers.entropy[role])
        settings = _fit_settings(shard, learner, config.roles[role].epochs, environment.roles[role].agents, data)
        if actor.kind == GATED:
            data, settings = _only_decisions(data, settings)
        actors[role], memories[role], report = fit(settings, loss, actor, learner.actor_memories[role], data, key)
        metrics |= {f"{role}/{name}": x for name, x in report.items()}
        if actor.log_std is not None:
            metrics[f"{role}/std"] = jnp.mean(jnp.exp(actors[role].log_std))
    return actors, memories, metrics


def _improve_critics(
    shard: Shard, learner: Learner, played: Step, estimates: dict[str, Estimates]
) -> tuple[dict[str, Critic], dict[str, optax.OptState], dict[str, Array]]:
    """Fit every critic to the rollout; a shared one for as many epochs as the role with the most."""
    config = shard.config
    critics, memories, metrics = {}, {}, {}
    for (name, critic), key in zip(
        learner.critics.items(), _shuffle_keys(learner, 1, len(learner.critics)), strict=True
    ):
        found = estimates[name]
        roles = config.learning_roles if name == SHARED else (critic.role,)
        loss = partial(critic_loss, coefficient=shard.numbers.value_coefficient)
        data = Targets(critic.select(played.record.views), found.target, found.weight)
        settings = _fit_settings(shard, learner, max(config.roles[role].epochs for role in roles), critic.agents, data)
        if name != SHARED and config.roles[critic.role].gated:
            data, settings = _only_decisions(data, settings)
        critics[name], memories[name], report = fit(settings, loss, critic, learner.critic_memories[name], data, key)
        metrics |= {f"{name}/critic_{key}": x for key, x in report.items()}
        metrics[f"{name}/explained_variance"] = explained_variance(found.value, found.target, found.weight, SHARDS)
    return critics, memories, metrics


def _rate(shard: Shard, learner: Learner) -> Float[Array, ""]:
    """Return the learning rate of the learner's next update."""
    begin = shard.numbers.learning_rate
    return learning_rate(begin, learner.updates, learner.planned, anneal=shard.config.anneal)


def _fit_settings(
    shard: Shard, learner: Learner, epochs: int | float, agents: tuple[int, ...], data: Actions | Targets
) -> Fit:
    """Return how this update fits a network to data with these agent axes."""
    return Fit(
        shard.config, shard.numbers, _rate(shard, learner), epochs, math.prod(agents), data.weight.shape[-1], SHARDS
    )


def _only_decisions(data: Entries, settings: Fit) -> tuple[Entries, Fit]:
    """Return a gated role's data without entries it does not learn from, and how to fit a network to it."""
    columns = -(-settings.agents * settings.environments // gated_part(settings.config))
    return pack_weighted(data, columns=columns), settings._replace(agents=1, environments=columns)
