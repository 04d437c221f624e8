"""The path that each pedestrian will walk. It depends on the scenario alone: waiting only delays it."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.sim.crossing_kind import LegKind
from jaxwalk.sim.pedestrian import next_leg, place
from jaxwalk.sim.scenario import FAR_AWAY, Scenario
from jaxwalk.sim.script import Script
from jaxwalk.sim.state import Leg
from jaxwalk.sim.world import World

LEGS = 16
"""Number of legs computed between two checks whether the paths are long enough."""


class Paths(eqx.Module):
    """Everybody's path as a polyline: point 0 is the start, leg k leads from point k to point k + 1."""

    x: Float[np.ndarray, "point ped *batch"]
    """Position [m]."""
    y: Float[np.ndarray, "point ped *batch"]
    jaywalk: Bool[np.ndarray, "leg ped *batch"]
    """The leg is a jaywalk across a roadway."""
    arrivals: Int[np.ndarray, "leg ped *batch"]
    """Goals reached before the leg."""


def walking_paths(world: World, scenario: Scenario, *, reach: float) -> Paths:
    """Return the paths of all people of a scenario (or a batch), each at least ``reach`` metres long.

    Those of scripted people are as long as they are.
    """
    if scenario.script is not None:
        return _of_script(scenario.script)
    leg = place(world, scenario).leg
    points, legs, shortest = [(leg.end_x[None], leg.end_y[None])], [], 0.0
    while shortest < reach:
        leg, found = _legs(world, scenario, leg)
        points.append((found.end_x, found.end_y))
        legs.append(found)
        shortest += float(found.length.sum(axis=0).min())
    x, y = (np.concatenate(columns) for columns in zip(*points, strict=True))
    if scenario.absent is not None:
        x, y = (np.where(scenario.absent, np.float32(FAR_AWAY), column) for column in (x, y))
    return Paths(
        x=x,
        y=y,
        jaywalk=np.concatenate([found.kind == LegKind.ACROSS for found in legs]),
        arrivals=np.concatenate([found.arrivals for found in legs]),
    )


def _of_script(script: Script) -> Paths:
    x, y = np.asarray(script.path_x), np.asarray(script.path_y)
    none = np.zeros(x[1:].shape, int)
    return Paths(x=x, y=y, jaywalk=none.astype(bool), arrivals=none)


@eqx.filter_jit
def _legs(world: World, scenario: Scenario, leg: Leg) -> tuple[Leg, Leg]:
    """Return the last of the next `LEGS` legs, and all of them along a leading axis."""

    def follow(leg: Leg, _: None) -> tuple[Leg, Leg]:
        after = next_leg(world, scenario, leg)
        after = jax.tree.map(lambda new, old: new.astype(jnp.asarray(old).dtype), after, leg)
        return after, after

    return jax.lax.scan(follow, leg, None, length=LEGS)
