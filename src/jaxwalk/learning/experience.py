"""Gathering experience: who acts, and what is recorded of it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Key

from jaxwalk.interfaces import ByRole, Environment, Policy
from jaxwalk.learning.actor import Actor, Choice, decide, no_memory
from jaxwalk.learning.config import GLOBAL, ROLES, SHARED, TrainConfig, of_a_shard
from jaxwalk.learning.players import columns_of, part_of, snapshots, width
from jaxwalk.rollout import Act

Views = dict[str, dict[str, Float[Array, "_ ..."]]]
"""What is seen of a state, by who sees it (a learning role, or the shared critic) and the observation set's name."""


class Record(eqx.Module):
    """What a rollout keeps of each step: of learning roles, in the environments that they learn from."""

    views: Views
    """Before the step."""
    choices: dict[str, Choice]
    """By role."""


def look(environment: Environment, config: TrainConfig, scenario: Any, state: Any) -> Views:
    """Everything that learning reads of a state."""
    shared = config.credit == "shared"
    views: Views = {SHARED: {GLOBAL: environment.global_state(scenario, state)}} if shared else {}
    for role in config.learning_roles:
        choice, own = config.role(role), columns_of(config, role).own
        names = {choice.observes} | (set() if shared else set(choice.critic_observes))
        views[role] = {name: part_of(_see(environment, scenario, state, role, name), own) for name in sorted(names)}
    return views


def _see(environment: Environment, scenario: Any, state: Any, role: str, name: str) -> Float[Array, "_ ..."]:
    if name == GLOBAL:
        return environment.global_state(scenario, state)
    return environment.observe(scenario, state, role, name)


class Player(NamedTuple):
    """Somebody who plays a role in some of the environments."""

    columns: slice
    observes: str
    init: Callable[[tuple[int, ...], tuple[int, ...]], Any]
    """As `Policy.init`."""
    decide: Callable[[Array, Any, Array], tuple[Choice, Any]]
    """From keys, memory and observation to what it does, and its next memory."""


def players(
    config: TrainConfig, role: str, actors: dict[str, Actor], early: dict[str, tuple[Actor, ...]],
    others: ByRole[Policy | None],
) -> list[Player]:  # fmt: skip
    """Everybody who plays the role, in the order of their environments."""
    columns, fixed, found = columns_of(config, role), getattr(others, role), []
    if fixed is not None:

        def follow(key: Array, memory: Any, seen: Array) -> tuple[Choice, Any]:
            action, memory = fixed.act(key, memory, seen)
            return Choice(action, action, jnp.zeros(()), None), memory

        found.append(Player(columns.fixed, fixed.observes, fixed.init, follow))
    if role in actors:
        versions = [*zip(columns.early, early[role], strict=False), (columns.own, actors[role])]
        for where, actor in versions:
            sample = partial(decide, actor, sample=True)
            found.append(Player(where, actor.observes, partial(no_memory, actor), sample))
    return sorted((x for x in found if width(x.columns)), key=lambda player: player.columns.start)


def make_act(
    environment: Environment, config: TrainConfig, actors: dict[str, Actor], early: dict[str, tuple[Actor, ...]],
    others: ByRole[Policy | None],
) -> Act:  # fmt: skip
    """Learning roles sample from their actors and are recorded; elsewhere earlier versions and fixed policies play."""

    def play(role: str, key: Key[Array, "env"], scenario: Any, state: Any, memory: Any) -> tuple[Any, Any, Any]:
        """The role's action, what is remembered, and the choices of who learns."""
        own, actions, memories, learned = columns_of(config, role).own, [], [], None
        everybody = players(config, role, actors, early, others)
        for player, before in zip(everybody, memory, strict=True):
            seen = part_of(_see(environment, scenario, state, role, player.observes), player.columns)
            choice, after = player.decide(key[player.columns], part_of(before, player.columns), seen)
            actions.append(choice.action)
            memories.append(jax.tree.map(lambda x, new, at=player.columns: x.at[..., at].set(new), before, after))
            learned = choice if player.columns == own else learned
        return jnp.concatenate(actions, axis=-1), tuple(memories), learned

    def act(key: Key[Array, "env"], scenario: Any, state: Any, memory: ByRole) -> tuple[ByRole, ByRole, Record]:
        played = {}
        for index, role in enumerate(ROLES):
            role_key = jax.vmap(jax.random.fold_in, in_axes=(0, None))(key, index)
            played[role] = play(role, role_key, scenario, state, getattr(memory, role))
        actions, memories = (ByRole(*(played[role][i] for role in ROLES)) for i in (0, 1))
        choices = {role: played[role][2] for role in config.learning_roles}
        return actions, memories, Record(look(environment, config, scenario, state), choices)

    return act


def fresh_memory(
    environment: Environment, config: TrainConfig, actors: dict[str, Actor], others: ByRole[Policy | None]
) -> ByRole:
    """What everybody remembers at the start of an episode; arrays ``(..., env)`` over all shards' environments."""
    early, share = snapshots(config, actors), of_a_shard(config)

    def of(role: str) -> tuple[Any, ...]:
        agents = getattr(environment.roles, role).agents
        return tuple(p.init(agents, (config.environments,)) for p in players(share, role, actors, early, others))

    return ByRole(*(of(role) for role in ROLES))
