"""What every part of jaxwalk agrees on: roles, environments and policies. Read this first.

Arrays have their named axes first and batch axes last: an observation is ``(feature, *agents, *batch)``, where
``agents`` is ``()`` for the one driver and ``(12,)`` for the pedestrians, so the same code runs on one episode and on
thousands, with the episodes innermost, where the processor's vectors are.
"""

from __future__ import annotations

from typing import Any, Generic, Protocol, TypeVar, runtime_checkable

import equinox as eqx
from jaxtyping import Array, Bool, Float, Key

T = TypeVar("T")


class ByRole(eqx.Module, Generic[T]):
    """One value for each role: a pytree, so that code for all roles is a ``jax.tree.map``."""

    driver: T
    """The self-driving car."""
    pedestrian: T
    """The people, who share one policy."""


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


class Outcome(eqx.Module):
    """What one step brought each agent."""

    rewards: ByRole[dict[str, Float[Array, "..."]]]
    """Named reward terms, weighted; an agent's reward is their sum. Each ``(*agents, *batch)``."""
    terminated: ByRole[Bool[Array, "..."]]
    """The agent's future is worth nothing: it arrived or collided. ``(*agents, *batch)``."""
    truncated: ByRole[Bool[Array, "..."]]
    """The episode ended, but not because of this agent: its value bootstraps. ``(*agents, *batch)``."""
    events: Any
    """What happened, as the environment's own pytree of arrays."""

    @property
    def ended(self) -> Bool[Array, "*batch"]:
        """Whether the episode is over: an episode ends for everybody at once."""
        return self.terminated.driver | self.truncated.driver


@runtime_checkable
class Environment(Protocol):
    """A multi-agent world. All chance is in the scenario: ``reset`` and ``step`` are deterministic."""

    @property
    def roles(self) -> ByRole[RoleSpec]: ...

    def draw(self, key: Key[Array, ""]) -> Any:
        """One scenario (no batch axes); batches come from ``vmap(draw, out_axes=-1)``."""
        ...

    def reset(self, scenario: Any) -> Any:
        """The state in which the scenario begins."""
        ...

    def observe(self, scenario: Any, state: Any, role: str, name: str) -> Float[Array, "feature ..."]:
        """The named observation set of a role: ``(feature, *agents, *batch)``."""
        ...

    def global_state(self, scenario: Any, state: Any) -> Float[Array, "feature *batch"]:
        """What a centralised critic sees."""
        ...

    def step(self, scenario: Any, state: Any, actions: ByRole[Array]) -> tuple[Any, Outcome]:
        """One step; never resets by itself."""
        ...


@runtime_checkable
class Policy(Protocol):
    """Decides for all agents of one role. Deterministic given its key."""

    @property
    def observes(self) -> str:
        """Name of the observation set it reads."""
        ...

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Any:
        """The memory at the start of an episode: a pytree with arrays ``(..., *agents, *batch)``, or None."""
        ...

    def act(
        self, key: Key[Array, "*batch"], memory: Any, observation: Float[Array, "feature ..."]
    ) -> tuple[Array, Any]:
        """Action and next memory. ``key`` holds one key for each episode of the batch."""
        ...
