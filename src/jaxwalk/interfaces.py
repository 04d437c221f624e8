"""What every part of jaxwalk agrees on: roles, environments, views and policies. Read this first.

Arrays have their named axes first and batch axes last: an observation is ``(feature, *agents, *batch)``, where
``agents`` is ``()`` for the one driver and ``(12,)`` for the pedestrians. So the same code runs on one episode and on
thousands, with the episodes innermost, where the processor's vectors are.
"""

from __future__ import annotations

from typing import Any, Protocol, TypeVar, runtime_checkable

import equinox as eqx
from jaxtyping import Array, Bool, Float, Key

T = TypeVar("T")
ScenarioT = TypeVar("ScenarioT")
StateT = TypeVar("StateT")

Roles = dict[str, T]
"""One value for each role, by the role's name. Code for all roles is a loop over it; no code names a role it doesn't
have to."""


class Box(eqx.Module):
    """A continuous action: ``size`` numbers, each in [-1, 1]; array ``(size, *agents, *batch)``."""

    size: int = eqx.field(static=True)


class Discrete(eqx.Module):
    """A choice among ``n``: an integer in [0, n); array ``(*agents, *batch)``."""

    n: int = eqx.field(static=True)


class RoleSpec(eqx.Module):
    """How many agents play a role, and what each decides."""

    agents: tuple[int, ...] = eqx.field(static=True)
    """The agent axes of the role's arrays: ``()`` for a single agent, ``(12,)`` for twelve."""
    action: Box | Discrete


class Moment(eqx.Module):
    """One moment of a batch of episodes: all that a view may be a function of."""

    world: Any
    """What stays the same from episode to episode, as the environment has it."""
    scenario: Any
    """What is played; arrays ``(..., *batch)``."""
    state: Any
    """Where it stands; arrays ``(..., *batch)``."""


@runtime_checkable
class View(Protocol):
    """What a policy sees of a moment. Hashable, and equal to another view that shows the same.

    A flat observation, ``(feature, *agents, *batch)``, is the usual kind; any pytree will do.
    """

    @property
    def name(self) -> str:
        """What results call it."""
        ...

    def __call__(self, moment: Moment) -> Any:
        """Return what is seen: a pytree with arrays ``(..., *agents, *batch)``."""
        ...


class Outcome(eqx.Module):
    """What one step brought each agent."""

    rewards: Roles[dict[str, Float[Array, "..."]]]
    """Named reward terms, weighted; an agent's reward is their sum. Each ``(*agents, *batch)``."""
    terminated: Roles[Bool[Array, "..."]]
    """The agent's future is worth nothing: it arrived or collided. ``(*agents, *batch)``."""
    truncated: Roles[Bool[Array, "..."]]
    """The episode ended, but not because of this agent: its value bootstraps. ``(*agents, *batch)``."""
    ended: Bool[Array, "*batch"]
    """The episode is over. It ends for everybody at once."""
    events: Any
    """What happened, as the environment's own pytree of arrays."""


@runtime_checkable
class Environment(Protocol[ScenarioT, StateT]):
    """A multi-agent world. All chance is in the scenario: ``reset`` and ``step`` are deterministic."""

    @property
    def roles(self) -> Roles[RoleSpec]:
        """Every role, always in the same order."""
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
        """Return what the view shows."""
        ...

    def global_state(self, scenario: ScenarioT, state: StateT) -> Float[Array, "feature *batch"]:
        """Return what a centralised critic sees."""
        ...

    def step(self, scenario: ScenarioT, state: StateT, actions: Roles[Array]) -> tuple[StateT, Outcome]:
        """Make one step; it never resets."""
        ...


@runtime_checkable
class Policy(Protocol):
    """Decides for all agents of one role. Deterministic given its key."""

    @property
    def view(self) -> View:
        """What it sees."""
        ...

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...], /) -> Any:
        """Return the memory at the start of an episode: a pytree with arrays ``(..., *agents, *batch)``, or None."""
        ...

    def act(self, key: Key[Array, "*batch"], memory: Any, seen: Any, /) -> tuple[Array, Any]:
        """Return action and next memory. ``key`` holds one key for each episode, ``seen`` is what its view shows."""
        ...
