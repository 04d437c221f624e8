"""Scenarios drawn at random, each from only its seed and its number."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Key

from jaxwalk.rollout import EVALUATION, draw_batch, scenario_key, seed_key
from jaxwalk.scenarios.source import source_hash
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario, dimensions, uniforms

SEEDS = 2**31
"""Seeds lie in [0, this)."""
NUMBERS = 2**30
"""Numbers of scenarios lie in [0, this)."""


@dataclass(frozen=True)
class Drawn:
    """The first ``count`` scenarios of a seed: those with which evaluation environments begin a rollout.

    No training meets them. Raises ValueError for an impossible seed or count.
    """

    street: Street
    """The street in which the scenarios are drawn."""
    seed: int
    count: int = NUMBERS

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible seed or count."""
        if not 0 <= self.seed < SEEDS:
            raise ValueError(f"seed must be 0 or more and below {SEEDS}, not {self.seed}")
        if not 1 <= self.count <= NUMBERS:
            raise ValueError(f"count must lie in [1, {NUMBERS}], not {self.count}")

    def __len__(self) -> int:
        """Return the number of scenarios."""
        return self.count

    def take(self, numbers: Int[np.ndarray, "episode"]) -> tuple[Scenario, Key[Array, "episode"]]:
        """Return the scenarios of these numbers, and a key for each. Raise ValueError for a number out of range."""
        keys = self._keys(numbers)
        return _draw(self.street, keys), keys

    def points(self, numbers: Int[np.ndarray, "episode"]) -> Float[np.ndarray, "episode number"]:
        """Return the points of the unit cube that these scenarios are at: what `Archived` keeps of them.

        Raise ValueError for a number out of range.
        """
        return np.asarray(_points(self._keys(numbers), dimensions(self.street.world)))

    def _keys(self, numbers: Int[np.ndarray, "episode"]) -> Key[Array, "episode"]:
        for wrong in numbers[(numbers < 0) | (numbers >= self.count)][:1]:
            raise ValueError(f"scenario must lie in [0, {self.count}), not {wrong}")
        fold_in = jax.vmap(jax.random.fold_in, in_axes=(None, 0))
        return fold_in(seed_key(self.seed, EVALUATION), jnp.asarray(numbers))

    def hash(self) -> str:
        """Return the hash of the scenarios."""
        return source_hash(self)

    def describe(self) -> dict[str, Any]:
        """Return the seed, the count and the hash."""
        return {"seed": self.seed, "count": self.count, "hash": self.hash()}


@eqx.filter_jit
def _draw(street: Street, keys: Key[Array, "episode"]) -> Scenario:
    """Draw the first episode of each environment."""
    return draw_batch(street, _first_keys(keys))


@partial(jax.jit, static_argnums=1)
def _points(keys: Key[Array, "episode"], count: int) -> Float[Array, "episode number"]:
    """Return the numbers from which `_draw` makes the scenarios."""
    return jax.vmap(lambda key: uniforms(key, count))(_first_keys(keys))


def _first_keys(keys: Key[Array, "episode"]) -> Key[Array, "episode"]:
    return scenario_key(keys, jnp.zeros(keys.shape, jnp.int32))
