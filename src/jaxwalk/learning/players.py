"""Who plays a role where: a fixed policy, earlier versions of the learner, the learner."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Int

from jaxwalk.learning.actor import Actor
from jaxwalk.learning.config import ROLES, SNAPSHOTS, TrainConfig


@dataclass(frozen=True)
class Columns:
    """Who plays a role in which environments: parts of the environment axis."""

    fixed: slice
    """A fixed policy."""
    early: tuple[slice, ...]
    """The learner as it was after each of `SNAPSHOTS` updates."""
    own: slice
    """The learner: the only ones it learns from."""


def columns_of(config: TrainConfig, role: str) -> Columns:
    """The driver's stand-ins have the first environments, the pedestrians' the last: so that there are environments in
    which both learn, and each role's stand-ins meet the other's learner."""
    choice, count = config.role(role), config.environments
    fixed, early = round(choice.fixed * count), round(choice.early * count)
    bounds = [0, fixed, *(fixed + early * (k + 1) // len(SNAPSHOTS) for k in range(len(SNAPSHOTS))), count]
    parts = [slice(a, b) for a, b in pairwise(bounds)]
    if role != ROLES[0]:
        parts = [slice(count - part.stop, count - part.start) for part in parts]
    return Columns(parts[0], tuple(parts[1:-1]), parts[-1])


def part_of(tree: Any, columns: slice) -> Any:
    """Those environments of arrays ``(..., env)``."""
    return jax.tree.map(lambda x: x[..., columns], tree)


def remember(early: tuple[Actor, ...], actor: Actor, updates: Int[Array, ""]) -> tuple[Actor, ...]:
    """What is remembered of an actor after so many updates: each snapshot follows it until its time has come."""

    def follow(snapshot: Actor, until: int) -> Actor:
        return jax.tree.map(lambda new, old: jnp.where(updates <= until, new, old), actor, snapshot)

    return tuple(follow(snapshot, until) for snapshot, until in zip(early, SNAPSHOTS, strict=False))


def snapshots(config: TrainConfig, actors: dict[str, Actor]) -> dict[str, tuple[Actor, ...]]:
    """Of untrained actors, by role; empty where no earlier version plays."""
    return {role: (actor,) * len(SNAPSHOTS) if config.role(role).early else () for role, actor in actors.items()}


def width(columns: slice) -> int:
    """How many environments they are."""
    return columns.stop - columns.start
