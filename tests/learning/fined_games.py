"""Games in which what pays also costs."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp

from jaxwalk.interfaces import Box
from learning import games


class Toll(games.Game):
    """Action 1 pays 1, and in half of the scenarios, those of -1, it costs 4."""

    def step(self, scenario, state, actions):
        after, outcome = super().step(scenario, state, actions)
        fine = jnp.where(scenario < 0, 4.0, 0.0) * actions["driver"]
        return after, dataclasses.replace(outcome, costs={"driver": {"fine": fine, "nothing": 0.0 * fine}})


class Haste(games.Game):
    """Action a, in [-1, 1], pays a and costs (1 + a)^2 u; the scenario u is any number in [0, 1)."""

    def draw(self, key):
        return jax.random.uniform(key)

    def step(self, scenario, state, actions):
        after, outcome = super().step(scenario, state, actions)
        fine = (1.0 + actions["driver"][0]) ** 2 * scenario
        return after, dataclasses.replace(outcome, costs={"driver": {"fine": fine, "nothing": 0.0 * fine}})


def made(kind, **options):
    """A game of this kind that pays what the driver does."""
    plain = games.game("bandit", **options)
    return kind(**{field.name: getattr(plain, field.name) for field in dataclasses.fields(plain)})


TOLL, HASTE = made(Toll), made(Haste, driver=Box(1), shows=False)
