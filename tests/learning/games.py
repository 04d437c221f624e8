"""Small games with known answers, which the learner must solve through the very code that it trains cars with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array

from jaxwalk.interfaces import Box, ByRole, Discrete, Outcome, RoleSpec


class Game(eqx.Module):
    """One car, two pedestrians; subclasses say what a step pays. A scenario is one number, -1 or 1."""

    driver: Box | Discrete = Box(1)
    pedestrian: Box | Discrete = Discrete(2)
    length: int = eqx.field(static=True, default=1)
    """Steps of an episode."""
    timeout: bool = eqx.field(static=True, default=False)
    """Whether the last step truncates instead of terminating."""

    @property
    def roles(self) -> ByRole[RoleSpec]:
        return ByRole(RoleSpec((), self.driver), RoleSpec((2,), self.pedestrian))

    @property
    def shortest_episode(self) -> int:
        return self.length

    def draw(self, key: Array) -> Array:
        return jnp.where(jax.random.bernoulli(key), 1.0, -1.0)

    def reset(self, scenario: Array) -> dict[str, Array]:
        return {"time": jnp.zeros(scenario.shape, jnp.int32), "choice": jnp.zeros(scenario.shape)}

    def observe(self, scenario: Array, state: Any, role: str, name: str) -> Array:
        seen = jnp.stack([scenario, state["time"].astype(jnp.float32), state["choice"]])
        if name == "blind":
            seen = jnp.zeros_like(seen)
        return seen if role == "driver" else jnp.broadcast_to(seen[:, None], (3, 2, *scenario.shape))

    def global_state(self, scenario: Array, state: Any) -> Array:
        return self.observe(scenario, state, "driver", "paper")

    def pay(self, scenario: Array, state: Any, actions: ByRole[Array]) -> tuple[Array, Array]:
        """Rewards of the driver ``(*batch)`` and the pedestrians ``(2, *batch)``."""
        raise NotImplementedError

    def step(self, scenario: Array, state: Any, actions: ByRole[Array]) -> tuple[Any, Outcome]:
        driver, pedestrian = self.pay(scenario, state, actions)
        first = actions.driver.astype(jnp.float32).reshape(-1, *scenario.shape)[0]
        after = {"time": state["time"] + 1, "choice": jnp.where(state["time"] == 0, first, state["choice"])}
        over = after["time"] >= self.length
        never = jnp.zeros_like(over)
        terminated, truncated = (never, over) if self.timeout else (over, never)
        spread = lambda x: jnp.broadcast_to(x, (2, *x.shape))  # noqa: E731
        outcome = Outcome(
            rewards=ByRole({"pay": driver}, {"pay": pedestrian, "nothing": jnp.zeros_like(pedestrian)}),
            terminated=ByRole(terminated, spread(terminated)),
            truncated=ByRole(truncated, spread(truncated)),
            events={"goal": terminated & (driver > 0), "timeout": truncated},
        )
        return after, outcome


class Play(Game):
    """A game whose pay is a function."""

    rule: Callable[[Array, Any, ByRole[Array]], tuple[Array, Array]] = eqx.field(static=True, kw_only=True)

    def pay(self, scenario: Array, state: Any, actions: ByRole[Array]) -> tuple[Array, Array]:
        return self.rule(scenario, state, actions)


def nothing_for_people(scenario: Array) -> Array:
    return jnp.zeros((2, *scenario.shape))


def bandit(scenario: Array, state: Any, actions: ByRole[Array]) -> tuple[Array, Array]:
    """Action 1 pays the driver 1; going (1) pays a pedestrian 1."""
    return actions.driver.astype(jnp.float32), actions.pedestrian.astype(jnp.float32)


def given(scenario: Array, state: Any, actions: ByRole[Array]) -> tuple[Array, Array]:
    """Pays what the scenario says, whatever anybody does: only the critic has something to learn."""
    return scenario, jnp.broadcast_to(2.0 * scenario, (2, *scenario.shape))


def delayed(scenario: Array, state: Any, actions: ByRole[Array]) -> tuple[Array, Array]:
    """The last step pays for having chosen, in the first, the side that the scenario names."""
    chose = jnp.where(state["choice"] > 0.5, 1.0, -1.0)
    return jnp.where(state["time"] == 1, chose * scenario, 0.0), nothing_for_people(scenario)


def tracking(scenario: Array, state: Any, actions: ByRole[Array]) -> tuple[Array, Array]:
    """The driver should choose half of what the scenario says; people, to wait where it is negative."""
    right = (actions.pedestrian == (scenario > 0)).astype(jnp.float32)
    return -((actions.driver[0] - 0.5 * scenario) ** 2), right


def steady(scenario: Array, state: Any, actions: ByRole[Array]) -> tuple[Array, Array]:
    """1 for everybody in every step: worth 1 / (1 - discount) if a timeout is no end."""
    return jnp.ones_like(scenario), jnp.ones((2, *scenario.shape))


def matching(scenario: Array, state: Any, actions: ByRole[Array]) -> tuple[Array, Array]:
    """People should tell the two scenarios apart; the driver must do what most people do."""
    right = (actions.pedestrian == (scenario > 0)).astype(jnp.float32)
    people = jnp.mean(actions.pedestrian.astype(jnp.float32), axis=0) > 0.5
    return (actions.driver == people).astype(jnp.float32), right
