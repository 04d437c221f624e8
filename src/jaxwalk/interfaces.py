"""The interfaces of jaxwalk: roles, environments, views and policies. Read this first.

Arrays have their named axes first and batch axes last: an observation is ``(feature, *agents, *batch)``, where
``agents`` is ``()`` for the one driver and ``(12,)`` for the pedestrians. So the same code runs on one episode and on
thousands, with the episodes innermost, where the processor's vectors are.
"""

from __future__ import annotations

from typing import Any, Protocol, TypeVar, runtime_checkable

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Key

T = TypeVar("T")
ScenarioT = TypeVar("ScenarioT")
StateT = TypeVar("StateT")

Roles = dict[str, T]
"""One value for each role, by the role's name. Code loops over all roles and names one only if it must."""


BEYOND = 1e-4
"""Rounding may take a continuous action beyond [-1, 1] by this much."""


class Box(eqx.Module):
    """A continuous action: ``size`` numbers, each in [-1, 1]; array ``(size, *agents, *batch)``.

    A policy that gives anything else (NaN, for example) is broken: what plays it stops and says so.
    """

    size: int = eqx.field(static=True)

    def contains(self, action: Any) -> Any:
        """Return where an action is in this space, but for rounding: ``(*agents, *batch)``. NaN never is."""
        return (abs(action) <= 1 + BEYOND).all(axis=0)

    def __str__(self) -> str:
        return f"{'a number' if self.size == 1 else f'{self.size} numbers'} in [-1, 1]"


class Discrete(eqx.Module):
    """A choice among ``n``: an integer in [0, n); array ``(*agents, *batch)``.

    A policy that gives anything else (-1, for example) is broken: what plays it stops and says so.
    """

    n: int = eqx.field(static=True)

    def contains(self, action: Any) -> Any:
        """Return where an action is in this space: ``(*agents, *batch)``."""
        return (action >= 0) & (action < self.n)

    def __str__(self) -> str:
        return f"an integer in [0, {self.n})"


class RoleSpec(eqx.Module):
    """How many agents play a role, and what each decides."""

    agents: tuple[int, ...] = eqx.field(static=True)
    """The agent axes of the role's arrays: ``()`` for a single agent, ``(12,)`` for twelve."""
    action: Box | Discrete

    def contains(self, action: Any) -> Any:
        """Return where the actions of all agents are in their space: ``(*batch,)``."""
        return self.action.contains(action).all(axis=tuple(range(len(self.agents))))

    def zeros(self, batch: tuple[int, ...]) -> Array:
        """Return an action of zeros for all agents: ``(size, *agents, *batch)`` or ``(*agents, *batch)``."""
        if isinstance(self.action, Box):
            return jnp.zeros((self.action.size, *self.agents, *batch))
        return jnp.zeros((*self.agents, *batch), jnp.int32)


class Moment(eqx.Module):
    """One moment of a batch of episodes: everything that a view may depend on."""

    world: Any
    """The part of the environment that stays the same from episode to episode."""
    scenario: Any
    """The scenarios; arrays ``(..., *batch)``."""
    state: Any
    """The states; arrays ``(..., *batch)``."""


class Shared(eqx.Module):
    """A part of an observation that all environments have in common: its arrays have no batch axes."""

    value: Any


def is_shared(part: Any) -> bool:
    """Return whether a part of an observation is `Shared`."""
    return isinstance(part, Shared)


@runtime_checkable
class View(Protocol):
    """What a policy observes of a moment. Hashable, and equal to another view that shows the same.

    A flat observation, ``(feature, *agents, *batch)``, is the usual kind; any pytree will do. What has no batch axes
    is `Shared`.
    """

    @property
    def name(self) -> str:
        """Return its name in results."""
        ...

    def __call__(self, moment: Moment) -> Any:
        """Return the observation: a pytree with arrays ``(..., *agents, *batch)``."""
        ...


class Outcome(eqx.Module):
    """The result of one step for each agent."""

    rewards: Roles[dict[str, Float[Array, "..."]]]
    """Named reward terms, weighted; an agent's reward is their sum. Each ``(*agents, *batch)``."""
    terminated: Roles[Bool[Array, "..."]]
    """Whether the agent's future has no value: it arrived or collided. ``(*agents, *batch)``."""
    truncated: Roles[Bool[Array, "..."]]
    """Whether the episode ended, but not because of this agent: its value bootstraps. ``(*agents, *batch)``."""
    ended: Bool[Array, "*batch"]
    """Whether the episode is over. It ends for all agents at once."""
    events: Any
    """The environment's own events, as a pytree of arrays."""
    costs: Roles[dict[str, Float[Array, "..."]]] = eqx.field(default_factory=dict)
    """Named costs of 0 or more, counted beside the reward and in no part of it. Each ``(*agents, *batch)``. A role
    that is left out has none."""


@runtime_checkable
class Environment(Protocol[ScenarioT, StateT]):
    """A multi-agent world. All chance is in the scenario: ``reset`` and ``step`` are deterministic."""

    @property
    def roles(self) -> Roles[RoleSpec]:
        """Return every role, always in the same order."""
        ...

    def draw(self, key: Key[Array, ""]) -> ScenarioT:
        """Return one scenario (no batch axes); batches come from ``vmap(draw, out_axes=-1)``."""
        ...

    def reset(self, scenario: ScenarioT) -> StateT:
        """Return the state in which the scenario begins."""
        ...

    def view(self, role: str, name: str) -> View:
        """Return a flat view of a role by its name. Raise ValueError if there is none of that name."""
        ...

    def observe(self, scenario: ScenarioT, state: StateT, view: View) -> Any:
        """Return the observation of a view."""
        ...

    def unhidden(self, scenario: ScenarioT, state: StateT) -> StateT:
        """Return the state for critics: its views show everything as it is. The state itself, if they do anyway."""
        ...

    def global_state(self, scenario: ScenarioT, state: StateT) -> Float[Array, "feature *batch"]:
        """Return the global state, which a centralised critic observes."""
        ...

    def step(self, scenario: ScenarioT, state: StateT, actions: Roles[Array]) -> tuple[StateT, Outcome]:
        """Make one step; never reset."""
        ...


@runtime_checkable
class Policy(Protocol):
    """Decides for all agents of one role. It is deterministic for a given key.

    Two members are optional: ``sample``, whether it draws its actions at random, and ``decide``, which acts and also
    returns a record of the step (`jaxwalk.acting.cast_of`).
    """

    @property
    def view(self) -> View:
        """Return the view that it observes."""
        ...

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...], /) -> Any:
        """Return the memory at the start of an episode: a pytree with arrays ``(..., *agents, *batch)``, or None."""
        ...

    def act(self, key: Key[Array, "*batch"], memory: Any, seen: Any, /) -> tuple[Array, Any]:
        """Return action and next memory. ``key`` holds one key for each episode, ``seen`` is what its view shows.

        The action must be in its role's space: `RoleSpec.contains`.
        """
        ...
