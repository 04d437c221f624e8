"""Small games with known answers, which the learner must solve through the very code that it trains cars with.

What a game pays is data, like a map: all games of one shape run through one compiled update.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array

from jaxwalk.interfaces import Box, Discrete, Moment, Outcome, Roles, RoleSpec
from jaxwalk.learning.config import RoleConfig, TrainConfig

CHOICE = Discrete(2)
ROLES = {"driver": RoleConfig(), "pedestrian": RoleConfig()}


def with_roles(config: TrainConfig, **roles: RoleConfig) -> TrainConfig:
    """The configuration with other ones of some roles."""
    return replace(config, roles=config.roles | roles)


@dataclass(frozen=True)
class Shown:
    """Everybody sees the scenario, the time and the first choice."""

    agents: tuple[int, ...]
    name: str = "paper"

    def __call__(self, moment: Moment) -> Array:
        scenario, state = moment.scenario, moment.state
        seen = moment.world.shows * jnp.stack([scenario, state["time"].astype(jnp.float32), state["choice"]])
        spread = seen.reshape(3, *(1,) * len(self.agents), *scenario.shape)
        return jnp.broadcast_to(spread, (3, *self.agents, *scenario.shape))


class Game(eqx.Module):
    """One car and some pedestrians. A scenario is one number, -1 or 1."""

    pays: dict[str, Array]
    """How much of each rule in `RULES` the game pays."""
    length: Array
    """Steps of an episode."""
    timeout: Array
    """Whether the last step truncates instead of terminating."""
    shows: Array
    """1 if agents see anything, else 0."""
    driver: Box | Discrete
    people: int = eqx.field(static=True, default=2)

    @property
    def roles(self) -> Roles[RoleSpec]:
        return {"driver": RoleSpec((), self.driver), "pedestrian": RoleSpec((self.people,), Discrete(2))}

    def draw(self, key: Array) -> Array:
        return jnp.where(jax.random.bernoulli(key), 1.0, -1.0)

    def reset(self, scenario: Array) -> dict[str, Array]:
        return {"time": jnp.zeros(scenario.shape, jnp.int32), "choice": jnp.zeros(scenario.shape)}

    def view(self, role: str, name: str) -> Shown:
        return Shown(self.roles[role].agents)

    def observe(self, scenario: Array, state: Any, view: Any) -> Array:
        return view(Moment(self, scenario, state))

    def unhidden(self, scenario: Array, state: Any) -> Any:
        return state

    def global_state(self, scenario: Array, state: Any) -> Array:
        return self.observe(scenario, state, Shown(()))

    def step(self, scenario: Array, state: Any, actions: Roles[Array]) -> tuple[Any, Outcome]:
        chosen = actions["driver"].astype(jnp.float32).reshape(-1, *scenario.shape)[0]
        driver, pedestrian = jnp.zeros_like(scenario), jnp.zeros((self.people, *scenario.shape))
        for name, rule in RULES.items():
            to_driver, to_pedestrian = rule(scenario, state, chosen, actions["pedestrian"].astype(jnp.float32))
            driver += self.pays[name] * to_driver
            pedestrian += self.pays[name] * to_pedestrian
        after = {"time": state["time"] + 1, "choice": jnp.where(state["time"] == 0, chosen, state["choice"])}
        over = after["time"] >= self.length

        def spread(x: Array) -> Array:
            return jnp.broadcast_to(x, (self.people, *x.shape))

        outcome = Outcome(
            rewards={
                "driver": {"pay": driver},
                "pedestrian": {"pay": pedestrian, "nothing": jnp.zeros_like(pedestrian)},
            },
            terminated={"driver": over & ~self.timeout, "pedestrian": spread(over & ~self.timeout)},
            truncated={"driver": over & self.timeout, "pedestrian": spread(over & self.timeout)},
            ended=over,
            events={"goal": over & (driver > 0), "timeout": over & self.timeout},
        )
        return after, outcome


def game(
    *names: str,
    size: float = 1.0,
    length: int = 1,
    timeout: bool = False,
    shows: bool = True,
    driver: Box | Discrete = CHOICE,
) -> Game:
    """A game that pays ``size`` by each of these rules."""
    pays = {name: jnp.float32(size if name in names else 0.0) for name in RULES}
    return Game(pays, jnp.int32(length), jnp.bool_(timeout), jnp.float32(shows), driver)


def bandit(scenario: Array, state: Any, chosen: Array, gone: Array) -> tuple[Array, Array]:
    """Action 1 pays the driver 1; going (1) pays a pedestrian 1."""
    return chosen, gone


def given(scenario: Array, state: Any, chosen: Array, gone: Array) -> tuple[Array, Array]:
    """Pays what the scenario says, whatever anybody does: only the critic has something to learn."""
    return scenario, jnp.broadcast_to(2.0 * scenario, gone.shape)


def delayed(scenario: Array, state: Any, chosen: Array, gone: Array) -> tuple[Array, Array]:
    """The second step pays for having chosen, in the first, the side that the scenario names."""
    chose = jnp.where(state["choice"] > 0.5, 1.0, -1.0)
    return jnp.where(state["time"] == 1, chose * scenario, 0.0), jnp.zeros_like(gone)


def tracking(scenario: Array, state: Any, chosen: Array, gone: Array) -> tuple[Array, Array]:
    """The driver should choose half of what the scenario says; people, to wait where it is negative."""
    return -((chosen - 0.5 * scenario) ** 2), 1.0 * (gone == (scenario > 0))


def steady(scenario: Array, state: Any, chosen: Array, gone: Array) -> tuple[Array, Array]:
    """The same for everybody in every step: worth 1 / (1 - discount) of it if a timeout is no end."""
    return jnp.ones_like(chosen), jnp.ones_like(gone)


def matching(scenario: Array, state: Any, chosen: Array, gone: Array) -> tuple[Array, Array]:
    """People should tell the two scenarios apart; the driver must do what most people do."""
    return 1.0 * (chosen == (jnp.mean(gone, axis=0) > 0.5)), 1.0 * (gone == (scenario > 0))


def holding(scenario: Array, state: Any, chosen: Array, gone: Array) -> tuple[Array, Array]:
    """People should never go."""
    return jnp.zeros_like(chosen), 1.0 - gone


RULES = {rule.__name__: rule for rule in (bandit, given, delayed, tracking, steady, matching, holding)}
