"""The one acting step, and the one rule for random keys, of everything that plays an environment.

Training, evaluation, adapters and export differ only in who plays where (a `Cast`) and in what they keep.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Int, Key

from jaxwalk.interfaces import Environment, Moment, Policy, Roles, View, is_shared

SCENARIO_KEYS, FIRST_ACTION_KEY = 0, 1
"""An environment's key is folded with 0 for its scenarios and with 1 + step for its actions, so the two never meet."""
ALL = slice(None)
"""A slice of all environments."""

Decide = Callable[[Any, Key[Array, "*batch"], Any, Any], tuple[Array, Any, Any]]
"""A function of policy, key, memory and what is seen; returns action, next memory and a record of the decision."""


def follow(policy: Policy, key: Key[Array, "*batch"], memory: Any, seen: Any) -> tuple[Array, Any, None]:
    """Do what the policy decides, and record nothing."""
    return *policy.act(key, memory, seen), None


class Player(NamedTuple):
    """A policy that plays a role, everywhere or in some of the environments."""

    policy: Any
    """A `Policy`, or anything else that ``decide`` accepts; it has ``init``."""
    view: View
    """The view that it observes."""
    columns: slice = ALL
    """The environments in which it plays."""
    decide: Decide = follow
    """The function by which it decides."""


Cast = Roles[tuple[Player, ...]]
"""The players of each role, in the order of their environments, which together are all environments."""


class Acted(NamedTuple):
    """What all players did in a step."""

    actions: Roles[Array]
    """The actions, ``(size, *agents, *batch)`` or ``(*agents, *batch)``."""
    memory: Roles[tuple[Any, ...]]
    """The next memory of each player."""
    records: Roles[tuple[Any, ...]]
    """The record of each player, in its own environments."""


@dataclass(frozen=True)
class Nothing:
    """A view that shows nothing."""

    name: str = "nothing"

    def __call__(self, moment: Moment) -> None:
        """Return None."""
        return None


class Given(eqx.Module):
    """A policy that returns a given action, so that a role can be played from outside a compiled program."""

    action: Any
    """The action, ``(size, *agents, *batch)`` or ``(*agents, *batch)``."""
    view: View = eqx.field(static=True, default=Nothing())

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> None:
        """Return None: it has no memory."""
        return None

    def act(self, key: Key[Array, "*batch"], memory: None, seen: Any) -> tuple[Array, None]:
        """Return the given action."""
        return self.action, memory


def cast_of(policies: Mapping[str, Policy]) -> Cast:
    """Return the cast in which each policy plays its role everywhere.

    A policy that has a method ``decide``, which also returns a record, decides by it.
    """
    return {
        role: (Player(policy, policy.view, decide=getattr(type(policy), "decide", follow)),)
        for role, policy in policies.items()
    }


def fresh_memory(environment: Environment, cast: Cast, batch: tuple[int, ...]) -> Roles[tuple[Any, ...]]:
    """Return everybody's memory at the start of an episode; arrays ``(..., *agents, *batch)``.

    ``batch`` counts all environments: a player's memory also has room for those in which it doesn't play.
    """
    roles = environment.roles
    return typed(
        {role: tuple(p.policy.init(roles[role].agents, batch) for p in players) for role, players in cast.items()}
    )


def typed(tree: Any) -> Any:
    """Return a pytree whose arrays have types of their own.

    What is made of Python numbers alone, as by ``jnp.full(shape, 2.0)``, has a weak type, and what comes of it a step
    later has not: so whatever goes on from it would be compiled twice.
    """
    return jax.tree.map(lambda x: jax.lax.convert_element_type(x, x.dtype) if is_weak(x) else x, tree)


def is_weak(x: Any) -> bool:
    """Return whether this is an array with a weak type; random keys have none."""
    return isinstance(x, Array) and getattr(x, "weak_type", False)


def step_key(keys: Key[Array, "*batch"], number: Int[Array, "*#batch"]) -> Key[Array, "*batch"]:
    """Return each environment's key for the step with that number, counted from 0 under the environment's own key."""
    fold = jax.random.fold_in
    for _ in range(keys.ndim):
        fold = jax.vmap(fold)
    return fold(keys, FIRST_ACTION_KEY + jnp.broadcast_to(number, keys.shape))


def role_key(key: Key[Array, "*batch"], index: int) -> Key[Array, "*batch"]:
    """Return a role's key, from the step's key and the role's index among the environment's roles."""
    fold = jax.random.fold_in
    for _ in range(key.ndim):
        fold = jax.vmap(fold, in_axes=(0, None))
    return fold(key, index)


def act(
    environment: Environment, cast: Cast, key: Key[Array, "*batch"], scenario: Any, state: Any,
    memory: Roles[tuple[Any, ...]],
) -> Acted:  # fmt: skip
    """Let everybody act in one step.

    Args:
        environment: the world.
        cast: who plays where.
        key: the step's key of each environment (`step_key`).
        scenario: what is played; arrays ``(..., *batch)``.
        state: where it stands; arrays ``(..., *batch)``.
        memory: as `fresh_memory` or the step before gave it.
    """
    acted = {}
    for index, role in enumerate(environment.roles):
        seen = [environment.observe(scenario, state, player.view) for player in cast[role]]
        acted[role] = _play(cast[role], role_key(key, index), memory[role], seen)
    return Acted(*({role: each[i] for role, each in acted.items()} for i in range(3)))


def _play(
    players: tuple[Player, ...], key: Key[Array, "*batch"], memory: tuple[Any, ...], seen: list[Any]
) -> tuple[Array, tuple[Any, ...], tuple[Any, ...]]:
    """Return the actions, next memories and records of one role."""
    actions, memories, records = [], [], []
    for player, before, shown in zip(players, memory, seen, strict=True):
        at = player.columns
        mine, own, view = (part_of(x, at) for x in (key, before, shown))
        action, after, record = player.decide(player.policy, mine, own, view)
        actions.append(action)
        memories.append(after if at == ALL else _put(before, after, at))
        records.append(record)
    joined = actions[0] if len(actions) == 1 else jnp.concatenate(actions, axis=-1)
    return joined, tuple(memories), tuple(records)


def part_of(tree: Any, columns: slice) -> Any:
    """Return the part of arrays ``(..., env)`` that belongs to those environments."""
    if columns == ALL:
        return tree
    return jax.tree.map(lambda x: x if is_shared(x) else x[..., columns], tree, is_leaf=is_shared)


def _put(before: Any, after: Any, columns: slice) -> Any:
    return jax.tree.map(lambda x, new: x.at[..., columns].set(new), before, after)
