"""One thing done otherwise in a replay, everything else as it was: `jaxwalk.evaluation.play` applies it at every step.

An intervention has a row for each episode of the batch. It acts from ``from_step`` on: the first action it changes is
the one taken in view of that frame. Nothing changed is None.
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Int, Key

from jaxwalk.interfaces import ByRole, Policy
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import State

FULL_BRAKING = -1.0
"""Acceleration as a share of its limit (3 m/s2)."""
WAIT = 0
"""The action of a pedestrian who stands."""


class Now(eqx.Module):
    """The moment in which everybody acts."""

    street: Street
    scenarios: Scenario
    state: State
    key: Key[Array, "episode"]
    """The driver's, of this step."""
    playing: Bool[Array, "episode"]
    """Not ended yet."""


@runtime_checkable
class Intervention(Protocol):
    """Changes the actions of a step."""

    def init(self, batch: tuple[int, ...]) -> Any:
        """What it remembers at the start: a pytree with arrays ``(..., episode)``, or None."""
        ...

    def act(self, now: Now, memory: Any, actions: ByRole[Array]) -> tuple[ByRole[Array], Any]:
        """The actions with its change, and its next memory."""
        ...


class Wait(eqx.Module):
    """One pedestrian of each episode stands still."""

    ped: Int[Array, "episode"]
    """Who."""
    from_step: Int[Array, "episode"]

    def init(self, batch: tuple[int, ...]) -> None:
        """It remembers nothing."""
        return None

    def act(self, now: Now, memory: None, actions: ByRole[Array]) -> tuple[ByRole[Array], None]:
        """That pedestrian waits, and nobody else's action changes."""
        walk = actions.pedestrian
        waits = (jnp.arange(len(walk))[:, None] == self.ped) & (now.state.step >= self.from_step)
        return ByRole(actions.driver, jnp.where(waits, WAIT, walk)), memory


class Brake(eqx.Module):
    """The car brakes fully; its steering stays the driver's."""

    from_step: Int[Array, "episode"]

    def init(self, batch: tuple[int, ...]) -> None:
        """It remembers nothing."""
        return None

    def act(self, now: Now, memory: None, actions: ByRole[Array]) -> tuple[ByRole[Array], None]:
        """Full braking instead of the driver's acceleration."""
        acceleration, steering = actions.driver
        braking = jnp.where(now.state.step >= self.from_step, FULL_BRAKING, acceleration)
        return ByRole(jnp.stack([braking, steering]), actions.pedestrian), memory


class TakeOver(eqx.Module):
    """Another driver takes over. It is asked, and shown what it observes, only where and when it drives."""

    driver: Policy
    from_step: Int[Array, "episode"]

    def init(self, batch: tuple[int, ...]) -> Any:
        """What the other driver remembers at the start."""
        return self.driver.init((), batch)

    def act(self, now: Now, memory: Any, actions: ByRole[Array]) -> tuple[ByRole[Array], Any]:
        """The other driver's action, and its memory, which begins when it takes over."""
        drives = now.playing & (now.state.step >= self.from_step)

        def ask() -> tuple[Array, Any]:
            seen = now.street.observe(now.scenarios, now.state, "driver", self.driver.observes)
            return self.driver.act(now.key, memory, seen)

        answer = jax.lax.cond(drives.any(), ask, lambda: (actions.driver, memory))
        before = (actions.driver, memory)
        drive, memory = jax.tree.map(lambda new, old: jnp.where(drives, new, old), answer, before)
        return ByRole(drive, actions.pedestrian), memory


def on_the_crosswalk(
    scenarios: Scenario, ped: Int[np.ndarray, "episode"], crossing: Int[np.ndarray, "episode"]
) -> Scenario:
    """The scenarios with one crossing (counted from 0) of one pedestrian each made on the crosswalk.

    It changes no action but the draw, which no probability is above any more: decisions are made before the road.
    """
    draws = scenarios.jaywalk_draw.at[crossing, ped, np.arange(len(ped))].set(jnp.inf)
    return eqx.tree_at(lambda scenario: scenario.jaywalk_draw, scenarios, draws)
