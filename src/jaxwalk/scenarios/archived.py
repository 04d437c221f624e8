"""Scenarios that somebody found: points of the unit cube of all draws, kept with what else decides an episode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int, Key

from jaxwalk.rollout import EVALUATION, seed_key
from jaxwalk.scenarios.source import source_hash
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario, dimensions, from_uniforms


@dataclass(frozen=True, eq=False)
class Archived:
    """Kept scenarios, which are played again exactly. Raises ValueError for arrays that don't fit the street."""

    street: Street
    """The street in which they were found."""
    points: np.ndarray
    """A point of the unit cube for each, ``(scenario, number)``: single precision, in [0, 1)."""
    present: np.ndarray
    """Who is there in each, ``(scenario, ped)``."""
    seed: int
    """The seed of the keys."""
    keys: np.ndarray
    """Number of each scenario's key among those of the seed, ``(scenario,)``."""

    def __post_init__(self) -> None:
        """Raise ValueError for arrays that don't fit the street."""
        count, people = len(self.points), self.street.world.rules.pedestrians
        numbers = dimensions(self.street.world)
        if self.points.shape != (count, numbers) or self.points.dtype != np.float32:
            found = f"{self.points.dtype} of shape {self.points.shape}"
            raise ValueError(f"a scenario of this street is a point of {numbers} 32-bit numbers, not {found}")
        if not ((self.points >= 0) & (self.points < 1)).all():
            raise ValueError("the numbers of a point must lie in [0, 1)")
        if self.present.shape != (count, people) or self.keys.shape != (count,):
            raise ValueError(f"present must be of shape {(count, people)} and keys of {(count,)}")
        if not ((self.keys >= 0) & (self.keys < 2**31)).all() or not 0 <= self.seed < 2**31:
            raise ValueError("seed and keys must lie in [0, 2^31)")

    def __len__(self) -> int:
        """Return the number of scenarios."""
        return len(self.points)

    def take(self, numbers: Int[np.ndarray, "episode"]) -> tuple[Scenario, Key[Array, "episode"]]:
        """Return the scenarios of these numbers, and a key for each. Raise ValueError for a number out of range."""
        for wrong in numbers[(numbers < 0) | (numbers >= len(self))][:1]:
            raise ValueError(f"scenario must lie in [0, {len(self)}), not {wrong}")
        absent = None if self.present.all() else ~self.present[numbers].T
        scenarios = scenarios_at(self.street, self.points[numbers], absent)
        return scenarios, keys_of(self.seed, self.keys[numbers])

    def hash(self) -> str:
        """Return the hash of the scenarios."""
        return source_hash(self)

    def describe(self) -> dict[str, Any]:
        """Return what it is, the count and the hash."""
        return {"kind": "archived", "count": len(self), "hash": self.hash()}


def scenarios_at(
    street: Street, points: Float[np.ndarray, "episode number"], absent: Bool[np.ndarray, "ped episode"] | None = None
) -> Scenario:
    """Return the scenarios at points of the unit cube, arrays ``(..., episode)``; who is absent isn't there."""
    there = None if absent is None else jnp.asarray(absent)
    return _scenarios(street, jnp.asarray(points, jnp.float32), there)


@eqx.filter_jit
def _scenarios(
    street: Street, points: Float[Array, "episode number"], absent: Bool[Array, "ped episode"] | None
) -> Scenario:
    made = jax.vmap(lambda point: from_uniforms(street.world, point), out_axes=-1)(points)
    if absent is None:
        return made
    return eqx.tree_at(lambda scenario: scenario.absent, made, absent, is_leaf=lambda leaf: leaf is None)


def keys_of(seed: int, numbers: Int[np.ndarray, "episode"]) -> Key[Array, "episode"]:
    """Return the keys of these numbers among those of a seed: those with which `Drawn` plays the same numbers."""
    fold_in = jax.vmap(jax.random.fold_in, in_axes=(None, 0))
    return fold_in(seed_key(seed, EVALUATION), jnp.asarray(numbers, jnp.int32))
