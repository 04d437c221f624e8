"""Change one thing in a replay and keep everything else: a policy that wraps the policy of a role.

An intervention has one row for each episode of the batch. It acts from ``from_step`` on: the first action it changes is
the one taken after seeing that frame. It sees the whole `Moment`, and passes the inner policy its own view.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int, Key

from jaxwalk.interfaces import Moment, Policy, Roles, View
from jaxwalk.policies import Oracle
from jaxwalk.policies.careful_human import CarefulHuman
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario

NEVER = 2**30
"""A change whose first step is this one never starts."""
FULL_BRAKING = -1.0
"""The first number of the action of a driver who brakes as hard as the car can."""
WAIT = 0
"""The action of a pedestrian who stands."""


@dataclass(frozen=True)
class WholeMoment:
    """A view of everything, for a policy that chooses what its inner policies see."""

    name: str = "moment"

    def __call__(self, moment: Moment) -> Moment:
        """Return the moment."""
        return moment


class Wait(eqx.Module):
    """One pedestrian of each episode stands still."""

    pedestrians: Policy
    """The policy of all other pedestrians, and of this one until then."""
    ped: Int[Array, "episode"]
    """The pedestrian who stands still."""
    from_step: Int[Array, "episode"]
    view: View = eqx.field(static=True, default=WholeMoment())

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Any:
        """Return the pedestrians' memory at the start."""
        return self.pedestrians.init(agents, batch)

    def act(self, key: Key[Array, "episode"], memory: Any, seen: Moment) -> tuple[Array, Any]:
        """Return everybody's actions, with this pedestrian's action changed to waiting."""
        walk, memory = self.pedestrians.act(key, memory, self.pedestrians.view(seen))
        waits = (jnp.arange(len(walk))[:, None] == self.ped) & (seen.state.step >= self.from_step)
        return jnp.where(waits, WAIT, walk), memory


class Brake(eqx.Module):
    """The car brakes fully; the driver still steers."""

    driver: Policy
    from_step: Int[Array, "episode"]
    view: View = eqx.field(static=True, default=WholeMoment())

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> Any:
        """Return the driver's memory at the start."""
        return self.driver.init(agents, batch)

    def act(self, key: Key[Array, "episode"], memory: Any, seen: Moment) -> tuple[Array, Any]:
        """Return full braking instead of the driver's acceleration."""
        (acceleration, steering), memory = self.driver.act(key, memory, self.driver.view(seen))
        braking = jnp.where(seen.state.step >= self.from_step, FULL_BRAKING, acceleration)
        return jnp.stack([braking, steering]), memory


class TakeOver(eqx.Module):
    """Another driver takes over. Its view and action are computed only if it drives in some episode."""

    driver: Policy
    other: Policy
    from_step: Int[Array, "episode"]
    view: View = eqx.field(static=True, default=WholeMoment())

    def init(self, agents: tuple[int, ...], batch: tuple[int, ...]) -> tuple[Any, Any]:
        """Return both drivers' memories at the start."""
        return self.driver.init(agents, batch), self.other.init(agents, batch)

    def act(self, key: Key[Array, "episode"], memory: tuple[Any, Any], seen: Moment) -> tuple[Array, tuple[Any, Any]]:
        """Return the other driver's action once it drives; its memory starts when it takes over."""
        before, waiting = memory
        action, after = self.driver.act(key, before, self.driver.view(seen))
        drives = seen.state.step >= self.from_step
        answer = jax.lax.cond(
            drives.any(), lambda: self.other.act(key, waiting, self.other.view(seen)), lambda: (action, waiting)
        )
        action, waiting = jax.tree.map(lambda new, old: jnp.where(drives, new, old), answer, (action, waiting))
        return action, (after, waiting)


@dataclass(frozen=True)
class Since:
    """The first step of each change in each episode; None: never."""

    wait: Int[np.ndarray, "episode"] | None = None
    """One pedestrian stands."""
    brake: Int[np.ndarray, "episode"] | None = None
    """The car brakes fully."""
    oracle: Int[np.ndarray, "episode"] | None = None
    """The `Oracle` drives."""
    human: Int[np.ndarray, "episode"] | None = None
    """The `CarefulHuman` drives."""


def with_changes(
    street: Street, policies: Roles[Policy], ped: Int[np.ndarray, "episode"], since: Since
) -> Roles[Policy]:
    """Return the policies with all four changes around them; ``ped`` are those who are to wait.

    Also a change that never starts is there: so replays with one change or another are one program, compiled once.
    """
    wait, brake, oracle, human = (
        jnp.asarray(np.full(len(ped), NEVER) if step is None else step, jnp.int32)
        for step in (since.wait, since.brake, since.oracle, since.human)
    )
    driver: Policy = Brake(policies["driver"], brake)
    driver = TakeOver(driver, with_limits(Oracle(), street.config), oracle)
    driver = TakeOver(driver, with_limits(CarefulHuman(), street.config), human)
    return policies | {"driver": driver, "pedestrian": Wait(policies["pedestrian"], jnp.asarray(ped, jnp.int32), wait)}


def on_the_crosswalk(
    scenarios: Scenario, ped: Int[np.ndarray, "episode"], crossing: Int[np.ndarray, "episode"]
) -> Scenario:
    """Return the scenarios with one crossing (counted from 0) of one pedestrian each made on the crosswalk.

    Only that crossing's draw changes, to a number above every probability. No policy changes: the scenario decides how
    somebody crosses, before the road.
    """
    draws = scenarios.jaywalk_draw.at[crossing, ped, np.arange(len(ped))].set(jnp.inf)
    return eqx.tree_at(lambda scenario: scenario.jaywalk_draw, scenarios, draws)
