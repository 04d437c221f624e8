"""Multi-agent PPO (Schulman 2017; for several agents Yu 2022): `init` once, then `update` again and again.

One update plays a rollout with the current actors, judges every action by generalised advantages, and improves every
network on it. Actors and critics share no weights, so each is fitted on its own: a role more is a turn of a loop more.

Environments may be shared out among devices (`TrainConfig.shards`): each plays its own and takes gradients of them;
networks are the same everywhere, since sums go over all shards.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import optax
from jax.sharding import PartitionSpec
from jaxtyping import Array, Int, Key

from jaxwalk.interfaces import ByRole, Environment, Policy
from jaxwalk.learning.actor import GATED, Actor, make_actor
from jaxwalk.learning.advantages import normalised
from jaxwalk.learning.config import ROLES, SHARED, TrainConfig, of_a_shard
from jaxwalk.learning.critics import Critic, Judgement, judge, make_critics
from jaxwalk.learning.experience import fresh_memory, look, make_act
from jaxwalk.learning.fit import Loss, fit, gated_part, learning_rate, only_weighty, optimiser
from jaxwalk.learning.losses import Actions, Targets, actor_loss, critic_loss, explained_variance
from jaxwalk.learning.monitor import all_finite, by_agent, episode_metrics, reward_metrics
from jaxwalk.learning.players import columns_of, part_of, remember, snapshots
from jaxwalk.rollout import Step, Stream, environment_keys, rollout, waiting
from jaxwalk.shards import EVERYWHERE, SHARDS, by_environment, mesh_of, place

NOBODY: ByRole[Policy | None] = ByRole(driver=None, pedestrian=None)
"""No fixed policies: every role learns everywhere."""
ONCE = {"xla_backend_optimization_level": 0}
"""For what runs once: compiling it well takes longer than running it badly compiled."""


class Learner(eqx.Module):
    """Everything that training changes or continues from. A checkpoint holds exactly this."""

    actors: dict[str, Actor]
    """By role; only of roles that learn."""
    critics: dict[str, Critic]
    """By role, or the one named ``shared``."""
    early: dict[str, tuple[Actor, ...]]
    """By role, what the actor was after each of `SNAPSHOTS` updates; empty where that plays nowhere."""
    actor_memories: dict[str, optax.OptState]
    """What the actors' optimisers remember."""
    critic_memories: dict[str, optax.OptState]
    """What the critics' optimisers remember."""
    others: ByRole[Policy | None]
    """Who plays a role where its learner doesn't."""
    stream: Stream
    """The environments in the middle of their episodes."""
    key: Key[Array, ""]
    """For the shuffling: each update folds in its number."""
    updates: Int[Array, ""]
    """Updates made."""
    planned: Int[Array, ""]
    """Updates in the whole training, as far as the annealing knows: `init` takes it from the configuration."""


def init(
    environment: Environment, config: TrainConfig, key: Key[Array, ""], *, others: ByRole[Policy | None] = NOBODY
) -> Learner:
    """An untrained learner, its environments waiting for their first episodes.

    Raises:
        ValueError: a role that others play has no policy in ``others``, or one that it doesn't need.
        ShardsError: there are fewer devices than shards.
    """
    _check_others(config, others)
    mesh = mesh_of(config.shards)
    learner = _untrained(environment, config, key, others)
    return place(learner, _where(learner), mesh)


@eqx.filter_jit(compiler_options=ONCE)  # pyright: ignore[reportCallIssue] (it passes on what `jax.jit` takes)
def _untrained(
    environment: Environment, config: TrainConfig, key: Key[Array, ""], others: ByRole[Policy | None]
) -> Learner:
    """`init`, all of it on one device."""
    stream_key, actor_key, critic_key, shuffle_key = jax.random.split(key, 4)
    stream = waiting(environment, environment_keys(stream_key, 0, config.environments))
    views = look(environment, config, stream.scenario, stream.state)
    actors = {}
    for role, k in zip(config.learning_roles, jax.random.split(actor_key, len(config.learning_roles)), strict=True):
        size = views[role][config.role(role).observes].shape[0]
        actors[role] = make_actor(k, size, getattr(environment.roles, role).action, config.role(role))
    critics = make_critics(environment, config, views, critic_key)
    memory = fresh_memory(environment, config, actors, others)
    learner = Learner(
        actors=actors,
        critics=critics,
        early=snapshots(config, actors),
        actor_memories={name: optimiser(config).init(actor) for name, actor in actors.items()},  # pyright: ignore
        critic_memories={name: optimiser(config).init(critic) for name, critic in critics.items()},  # pyright: ignore
        others=others,
        stream=eqx.tree_at(lambda s: s.memory, stream, memory, is_leaf=lambda x: x is None),
        key=shuffle_key,
        updates=jnp.zeros((), jnp.int32),
        planned=jnp.asarray(config.updates, jnp.int32),
    )
    return jax.tree.map(_strongly_typed, learner)


@eqx.filter_jit
def update(environment: Environment, config: TrainConfig, learner: Learner) -> tuple[Learner, dict[str, Array]]:
    """Play a rollout and learn from it; returns the learner and scalars to log.

    ``finite`` among them is 1 if all the others, every network and what the optimisers remember are finite, else 0.
    Nothing is donated: what goes in stays usable, and it is small beside the rollout.
    """
    arrays, rest = eqx.partition(learner, eqx.is_array)

    def work(arrays: Learner) -> tuple[Learner, dict[str, Array]]:
        learner, metrics = _update(environment, of_a_shard(config), eqx.combine(arrays, rest))
        return eqx.filter(learner, eqx.is_array), metrics

    where, mesh = _where(learner), mesh_of(config.shards)
    shared = jax.shard_map(work, mesh=mesh, in_specs=(where,), out_specs=(where, EVERYWHERE), check_vma=False)
    arrays, metrics = shared(arrays)
    metrics["steps"] = arrays.updates.astype(jnp.float32) * (config.steps * config.environments)
    return eqx.combine(arrays, rest), metrics


def _update(environment: Environment, config: TrainConfig, learner: Learner) -> tuple[Learner, dict[str, Array]]:
    """`update` of a shard: its environments, its configuration."""
    act = make_act(environment, config, learner.actors, learner.early, learner.others)
    memory = fresh_memory(environment, config, learner.actors, learner.others)
    stream, played = rollout(environment, act, learner.stream, config.steps, fresh_memory=memory)
    final = look(environment, config, stream.scenario, stream.state)
    judgements = {name: judge(config, critic, played, final) for name, critic in learner.critics.items()}

    actors, actor_memories, actor_metrics = _improve_actors(environment, config, learner, played, judgements)
    critics, critic_memories, critic_metrics = _improve_critics(config, learner, played, judgements)
    metrics = actor_metrics | critic_metrics
    metrics |= _rollout_metrics(config, played)
    metrics["learning_rate"] = learning_rate(config, learner.updates, learner.planned)
    updates = learner.updates + 1
    metrics["finite"] = all_finite((metrics, actors, critics, actor_memories, critic_memories))
    early = {role: remember(learner.early[role], actor, updates) for role, actor in actors.items()}
    learner = Learner(
        actors, critics, early, actor_memories, critic_memories, learner.others, stream, learner.key, updates,
        learner.planned,
    )  # fmt: skip
    return learner, metrics


def _where(learner: Learner) -> Any:
    """Of a learner's arrays, which devices have what: the environments are shared out, everything else is everywhere.

    Returns the learner with `PartitionSpec` in place of its arrays.
    """
    specs: Any = jax.tree.map(lambda _: EVERYWHERE, eqx.filter(learner, eqx.is_array))
    return eqx.tree_at(
        lambda x: x.stream, specs, by_environment(learner.stream), is_leaf=lambda x: isinstance(x, PartitionSpec)
    )


def _rollout_metrics(config: TrainConfig, played: Step) -> dict[str, Array]:
    """Of the environments in which the learners play: rewards of each role's, endings of the first learning role's."""
    metrics = {}
    for role in ROLES:
        own = columns_of(config, role).own if config.role(role).learns else slice(None)
        valid = played.valid[:, own].astype(jnp.float32)
        metrics |= reward_metrics(role, part_of(getattr(played.outcome.rewards, role), own), valid, SHARDS)
    own = columns_of(config, config.learning_roles[0]).own
    return metrics | episode_metrics(part_of(played.outcome, own), played.valid[:, own].astype(jnp.float32), SHARDS)


def _check_others(config: TrainConfig, others: ByRole[Policy | None]) -> None:
    for role in ROLES:
        given, share = getattr(others, role) is not None, config.role(role).fixed
        if given and not share:
            raise ValueError(f"others: the {role} learns everywhere (fixed is 0), so no fixed policy can play it")
        if share and not given:
            raise ValueError(f"others: a fixed policy must play the {role} (fixed is {share:g})")


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
    actors, memories, metrics = {}, {}, {}
    for (role, actor), key in zip(learner.actors.items(), _shuffle_keys(learner, 0, len(learner.actors)), strict=True):
        advantage = judgements[SHARED if config.credit == "shared" else role].advantage
        choice, own = played.record.choices[role], columns_of(config, role).own
        counts = by_agent(played.valid[:, own].astype(jnp.float32), advantage)
        counts = counts if choice.decided is None else counts * choice.decided
        data = Actions(
            observation=played.record.views[role][actor.observes],
            raw=choice.raw,
            log_prob=choice.log_prob,
            advantage=normalised(advantage, counts, SHARDS),
            weight=counts,
        )
        actors[role], memories[role], report = _fit(
            config,
            learner,
            partial(actor_loss, clip=config.clip, entropy=config.role(role).entropy),
            actor,
            learner.actor_memories[role],
            data,
            key=key,
            epochs=config.role(role).epochs,
            agents=getattr(environment.roles, role).agents,
            gated=actor.kind == GATED,
        )
        metrics |= {f"{role}/{name}": x for name, x in report.items()}
        if actor.log_std is not None:
            metrics[f"{role}/std"] = jnp.mean(jnp.exp(actors[role].log_std))
    return actors, memories, metrics


def _improve_critics(
    config: TrainConfig, learner: Learner, played: Step, judgements: dict[str, Judgement]
) -> tuple[dict[str, Critic], dict[str, optax.OptState], dict[str, Array]]:
    """Fit every critic to the rollout; a shared one as often as the role with the most epochs."""
    critics, memories, metrics = {}, {}, {}
    for (name, critic), key in zip(
        learner.critics.items(), _shuffle_keys(learner, 1, len(learner.critics)), strict=True
    ):
        judgement = judgements[name]
        roles = config.learning_roles if name == SHARED else (name,)
        critics[name], memories[name], report = _fit(
            config,
            learner,
            partial(critic_loss, coefficient=config.value_coefficient),
            critic,
            learner.critic_memories[name],
            Targets(critic.select(played.record.views), judgement.target, judgement.weight),
            key=key,
            epochs=max(config.role(role).epochs for role in roles),
            agents=critic.agents,
            gated=name != SHARED and config.role(name).gated,
        )
        metrics |= {f"{name}/critic_{key}": x for key, x in report.items()}
        metrics[f"{name}/explained_variance"] = explained_variance(
            judgement.value, judgement.target, judgement.weight, SHARDS
        )
    return critics, memories, metrics


def _fit(
    config: TrainConfig, learner: Learner, loss: Loss, network: Any, memory: optax.OptState, data: Actions | Targets,
    *, key: Key[Array, ""], epochs: int | float, agents: tuple[int, ...], gated: bool,
) -> tuple[Any, optax.OptState, dict[str, Array]]:  # fmt: skip
    """`fit` to the data; of a gated role, to the rows that have weight."""
    rows, environments = math.prod(agents), data.weight.shape[-1]
    if gated:
        rows, environments = 1, -(-rows * environments // gated_part(config))
        data = only_weighty(data, columns=environments)
    rate = learning_rate(config, learner.updates, learner.planned)
    return fit(
        loss, network, memory, data,
        key=key, rate=rate, epochs=epochs, agents=rows, environments=environments, config=config, axis=SHARDS,
    )  # fmt: skip
