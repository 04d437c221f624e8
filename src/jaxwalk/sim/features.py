"""Features, the parts of a flat observation. Each is one entry: name, size, bounds and formula."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from jaxwalk.interfaces import Moment
from jaxwalk.maps.routes import ROUTE_SPACING
from jaxwalk.sim.lookup import of_map
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.world import World

SPEED = 8.33
"""Speeds in views are divided by this [m/s], distances by `jaxwalk.sim.prediction.DISTANCE`."""
ROWS_AT_ONCE = 8
"""XLA's CPU backend writes up to this many arrays straight into their place. With more, it copies each first."""

FLAG, COSINE = ("yes or no",), ("cosine", "sine")
"""Units of flags and of directions ..."""
PURE, OF_MAP = ("pure number",), ("width of the map", "height of the map")
"""... of traits, and of positions on the map."""

Bound = tuple[float, float]
"""Lowest and highest value."""


@dataclass(frozen=True)
class Limits:
    """The quantities from which bounds follow. Nobody leaves the map, so no distance is larger than its diagonal."""

    config: SimConfig
    diagonal: float
    """Length of the longest map's diagonal [m]."""
    to_go: Bound
    """Metres from the car to its goal along the route."""

    @classmethod
    def of(cls, world: World) -> Limits:
        """Return the limits of a world."""
        lengths = np.asarray(world.tables.finish)[..., 2]
        farthest = (world.tables.course.shape[-2] - 1) * ROUTE_SPACING  # the limit of `along`, also on shorter routes
        return cls(
            config=world.rules.config,
            diagonal=float(np.hypot(np.asarray(world.maps.width), np.asarray(world.maps.height)).max()),
            to_go=(float(lengths.min()) - farthest, float(lengths.max())),
        )


@dataclass(frozen=True)
class Feature:
    """One or several numbers of an observation that belong together."""

    name: str
    size: int
    """How many numbers it is."""
    bounds: Callable[[Limits], Sequence[Bound]]
    """Return the bounds of each number; a shorter sequence is repeated."""
    compute: Callable[[Moment], Sequence[Array]]
    """Return the numbers in order: arrays ``(*agents, *batch)``, or ``(number, *agents, *batch)`` for several."""
    units: tuple[str, ...] = ()
    """What a value of 1 stands for, as in ``60 m``, or what a pure number is; a shorter tuple is repeated. Empty if it
    isn't said."""

    def units_in_words(self) -> str:
        """Return the units in order, equal ones together, as in ``(2 x 60 m, 2 x 8.33 m/s) x 6``."""
        alike = [(unit, len(list(found))) for unit, found in groupby(self.units)]
        words = ", ".join(unit if count == 1 else f"{count} x {unit}" for unit, count in alike)
        times = self.size // max(1, len(self.units))
        return words if times == 1 or len(alike) < 2 else f"({words}) x {times}"


def share(limits: Limits) -> Sequence[Bound]:
    """Return the bounds of flags, traits, places on the map and capped distances."""
    return [(0.0, 1.0)]


def signed(limits: Limits) -> Sequence[Bound]:
    """Return the bounds of cosines and commands."""
    return [(-1.0, 1.0)]


def within_diagonals(scale: float) -> Callable[[Limits], Sequence[Bound]]:
    """Return a function that gives the bounds of a signed distance on the map, divided by ``scale`` [m]."""
    return lambda limits: [both(limits.diagonal / scale)]


def both(most: float) -> Bound:
    """Return the bound from ``-most`` to ``most``."""
    return -most, most


def joined(rows: Sequence[Array]) -> Float[Array, "feature ..."]:
    """Return numbers ``(*agents, *batch)`` or ``(number, *agents, *batch)`` as one array; agent axes are broadcast."""
    axes = min(row.ndim for row in rows)
    several = [row if row.ndim > axes else row[None] for row in rows]
    shape = jnp.broadcast_shapes(*(row.shape[1:] for row in several))
    full = [jnp.broadcast_to(x, (x.shape[0], *shape)).astype(jnp.float32) for x in several]
    groups = [jnp.concatenate(full[i : i + ROWS_AT_ONCE]) for i in range(0, len(full), ROWS_AT_ONCE)]
    return jnp.concatenate(jax.lax.optimization_barrier(groups))  # the barrier keeps the compiler from merging groups


def on_map(moment: Moment, x: Array, y: Array) -> Sequence[Array]:
    """Return a position as shares of the map's width and height."""
    maps, which = moment.world.maps, moment.scenario.map
    return x / of_map(maps.width, which), y / of_map(maps.height, which)
