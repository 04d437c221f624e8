"""Decide who plays each role in which environments: a fixed policy, earlier versions of the learner, or the learner."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Int

from jaxwalk.acting import Cast, Player
from jaxwalk.interfaces import Discrete, Environment, Policy, Roles
from jaxwalk.learning.actor import Actor, Choice, decide
from jaxwalk.learning.config import SNAPSHOTS, TrainConfig
from jaxwalk.learning.hyperparameters import Hyperparameters, hyperparameters


@dataclass(frozen=True)
class Columns:
    """Who plays a role in which environments: slices of the environment axis."""

    fixed: slice
    """Environments of a fixed policy."""
    early: tuple[slice, ...]
    """Environments of the learner as it was after each of `SNAPSHOTS` updates."""
    own: slice
    """Environments of the learner; it learns only from these."""


@dataclass(frozen=True)
class Shard:
    """One device's part of the training: a part of the environments, and who plays in them."""

    config: TrainConfig
    """The configuration of the training, with the shard's number of environments."""
    columns: Roles[Columns]
    """The columns of each role."""
    numbers: Hyperparameters
    """The training's numbers. In ``config`` there may be a 1 in their place, so they are read from here."""


def shard_of(config: TrainConfig, numbers: Hyperparameters) -> Shard:
    """Return each device's shard; all shards are alike."""
    return whole(replace(config, environments=config.environments // config.shards, shards=1), numbers)


def whole(config: TrainConfig, numbers: Hyperparameters | None = None) -> Shard:
    """Return all environments as if they were one shard; without ``numbers``, with those of the configuration."""
    columns = {role: _columns(config, role) for role in config.roles}
    return Shard(config, columns, hyperparameters(config) if numbers is None else numbers)


def _columns(config: TrainConfig, role: str) -> Columns:
    """Return who plays a role where. The first role's stand-ins get the first environments, the other roles' the last.

    So there are environments in which all roles learn, and each role's stand-ins meet the other roles' learners.
    """
    choice, count = config.roles[role], config.environments
    fixed, early = round(choice.fixed * count), round(choice.early * count)
    bounds = [0, fixed, *(fixed + early * (k + 1) // len(SNAPSHOTS) for k in range(len(SNAPSHOTS))), count]
    parts = [slice(a, b) for a, b in pairwise(bounds)]
    if role != next(iter(config.roles)):
        parts = [slice(count - part.stop, count - part.start) for part in parts]
    return Columns(parts[0], tuple(parts[1:-1]), parts[-1])


def check_roles(environment: Environment, config: TrainConfig, others: Roles[Policy | None]) -> None:
    """Raise ValueError unless the roles are the environment's, and a policy is given where one is needed."""
    wanted = list(environment.roles)
    if list(config.roles) != wanted:
        raise ValueError(f"roles must be the environment's, {', '.join(wanted)}, not {', '.join(config.roles)}")
    for role in others:
        if role not in wanted:
            raise ValueError(f"others: no role is called {role}; there are: {', '.join(wanted)}")
    for role, choice in config.roles.items():
        given, share = others[role] is not None, choice.fixed
        action = environment.roles[role].action
        if choice.gated and not (isinstance(action, Discrete) and action.n == 2):
            raise ValueError(f"gated: the {role} doesn't choose between 0 and 1, so it can't be gated")
        if given and not share:
            raise ValueError(f"others: the {role} learns everywhere (fixed is 0), so no fixed policy can play it")
        if share and not given:
            raise ValueError(f"others: a fixed policy must play the {role} (fixed is {share:g})")


def learning_cast(
    environment: Environment, shard: Shard, actors: Roles[Actor], early: Roles[tuple[Actor, ...]],
    others: Roles[Policy | None],
) -> Cast:  # fmt: skip
    """Return the cast of a shard: learning roles sample from their actors, stand-ins play elsewhere."""
    cast = {}
    for role, columns in shard.columns.items():
        fixed, players = others[role], []
        if fixed is not None:
            players.append(Player(fixed, fixed.view, columns.fixed))
        if role in actors:
            versions = [*zip(columns.early, early[role], strict=False), (columns.own, actors[role])]
            players += [Player(x, environment.view(role, x.observes), at, sample) for at, x in versions]
        cast[role] = tuple(sorted((p for p in players if width(p.columns)), key=lambda p: p.columns.start))
    return cast


def sample(actor: Actor, key: Array, memory: Any, seen: Array) -> tuple[Array, Any, Choice]:
    """Sample an action, and record its probability."""
    choice, memory = decide(actor, key, memory, seen, sample=True)
    return choice.action, memory, choice


def remember(early: tuple[Actor, ...], actor: Actor, updates: Int[Array, ""]) -> tuple[Actor, ...]:
    """Return the snapshots after this number of updates: each follows the actor until its own number is reached."""

    def follow(snapshot: Actor, until: int) -> Actor:
        return jax.tree.map(lambda new, old: jnp.where(updates <= until, new, old), actor, snapshot)

    return tuple(follow(snapshot, until) for snapshot, until in zip(early, SNAPSHOTS, strict=False))


def snapshots(config: TrainConfig, actors: Roles[Actor]) -> Roles[tuple[Actor, ...]]:
    """Return the snapshots of untrained actors by role; empty if no earlier version plays."""
    return {role: (actor,) * len(SNAPSHOTS) if config.roles[role].early else () for role, actor in actors.items()}


def width(columns: slice) -> int:
    """Return the number of environments."""
    return columns.stop - columns.start
