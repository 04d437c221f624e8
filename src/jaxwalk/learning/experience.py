"""Gather experience: what learning reads of a state, and what a rollout records of a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import equinox as eqx
import jax
from jaxtyping import Array, Bool, Float, Key

from jaxwalk.acting import Cast, act, part_of
from jaxwalk.interfaces import Environment, Roles
from jaxwalk.learning.actor import Choice
from jaxwalk.learning.casting import Shard
from jaxwalk.learning.config import GLOBAL, SHARED
from jaxwalk.rollout import Act

Views = dict[str, dict[str, Float[Array, "_ ..."]]]
"""Views of a state, by observer (a learning role, or the shared critic) and the view's name."""
ViewShapes = dict[str, dict[str, jax.ShapeDtypeStruct]]
"""The shapes of `Views`."""


class Record(eqx.Module):
    """What a rollout keeps of each step for learning roles, in the environments from which they learn."""

    views: Views
    """The views before the step."""
    choices: Roles[Choice]
    """The choices of each learning role."""
    sound: Roles[Bool[Array, "env"]]
    """Whether the actions of each role are in their space, whoever plays it."""


def gather_views(environment: Environment, shard: Shard, scenario: Any, state: Any) -> Views:
    """Return everything that learning reads of a state."""
    config = shard.config
    shared = config.credit == "shared"
    views: Views = {SHARED: {GLOBAL: environment.global_state(scenario, state)}} if shared else {}
    truth = state if shared else environment.unhidden(scenario, state)
    for role in config.learning_roles:
        choice, own = config.roles[role], shard.columns[role].own
        shown = {choice.observes: (state, choice.observes)}
        for name in () if shared else choice.critic_observes:
            shown[name if truth is state else unhidden(name)] = truth, name
        views[role] = {
            key: part_of(_see(environment, scenario, of, role, name), own) for key, (of, name) in sorted(shown.items())
        }
    return views


def unhidden(name: str) -> str:
    """Return the name under which views have what a critic sees, where that isn't what the role's agents see."""
    return name if name == GLOBAL else f"{name}, nothing hidden"


def critic_reads(names: Sequence[str], of_role: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names that a critic's observation sets have among the views of its role."""
    return tuple(unhidden(name) if unhidden(name) in of_role else name for name in names)


def _see(environment: Environment, scenario: Any, state: Any, role: str, name: str) -> Float[Array, "_ ..."]:
    if name == GLOBAL:
        return environment.global_state(scenario, state)
    return environment.observe(scenario, state, environment.view(role, name))


def recording_act(environment: Environment, shard: Shard, cast: Cast) -> Act:
    """Return the acting step of a rollout: everybody acts, and the learners' views and choices are recorded."""

    def act_and_record(key: Key[Array, "env"], scenario: Any, state: Any, memory: Any) -> tuple[Any, Any, Record]:
        acted = act(environment, cast, key, scenario, state, memory)
        choices = {role: _own(shard, cast, role, acted.records[role]) for role in shard.config.learning_roles}
        sound = {role: spec.contains(acted.actions[role]) for role, spec in environment.roles.items()}
        return acted.actions, acted.memory, Record(gather_views(environment, shard, scenario, state), choices, sound)

    return act_and_record


def _own(shard: Shard, cast: Cast, role: str, records: tuple[Any, ...]) -> Choice:
    """Return the choice that the role's learner recorded."""
    own = shard.columns[role].own
    return next(record for player, record in zip(cast[role], records, strict=True) if player.columns == own)
