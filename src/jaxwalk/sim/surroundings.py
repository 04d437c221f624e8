"""What a driver from elsewhere can work with: the route ahead, the road's edges and people, all in the car's frame.

Nothing tells where on the map the car is, so a driver may come from other streets, or from another simulator.
"""

from __future__ import annotations

from collections.abc import Sequence

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.interfaces import Moment
from jaxwalk.sim.driver_features import METRES, PEOPLE, SPEED_OF_CAR, STEERING, TO_GO
from jaxwalk.sim.features import Feature, Limits, both, share
from jaxwalk.sim.geometry import rotate
from jaxwalk.sim.map_tables import POINTS
from jaxwalk.sim.prediction import DISTANCE
from jaxwalk.sim.vehicle import room

RAYS = 24
"""Directions in which the road's edge is seen: ahead, and on to the left in equal angles."""
RANGE = 20.0
"""The road's edge is seen up to this far [m]."""
STRIDE = 0.5
"""A ray passes corners of kerbs that are thinner than this [m]."""


def edge_distances(moment: Moment) -> Float[Array, "ray *batch"]:
    """Return how far the roadway's edge is from the car's centre in each of `RAYS` directions [m], at most `RANGE`.

    A ray goes on by the distance to the nearest edge until it is off the roadway. The end of the street is an edge.
    """
    car = moment.state.vehicle
    angle = (2 * jnp.pi / RAYS * jnp.arange(RAYS)).reshape(-1, *(1,) * car.x.ndim)
    east, north = rotate(car.cos[None], car.sin[None], jnp.cos(angle), jnp.sin(angle))

    def looking(ray: tuple[Array, ...]) -> Array:
        at, _, _, found = ray
        return (at < RANGE) & (found == RANGE)

    def go_on(ray: tuple[Array, ...]) -> tuple[Array, ...]:
        at, before, inside_before, found = ray
        inside, _, _ = room(moment.world, moment.scenario, car.x[None] + at * east, car.y[None] + at * north)
        edge = before + (at - before) * inside_before / jnp.maximum(inside_before - inside, 1e-6)
        found = jnp.where(looking(ray) & (inside <= 0), jnp.minimum(edge, RANGE), found)
        return at + jnp.maximum(inside, STRIDE), at, inside, found

    start = jnp.zeros(east.shape)
    nothing = (start, start, start, start + RANGE)
    return jax.lax.while_loop(lambda ray: looking(ray).any(), go_on, nothing)[3]


def _route(moment: Moment) -> Sequence[Array]:
    """Return the points of the route ahead, x and y of each, the nearest first."""
    seen = moment.state.foresight
    points = jnp.stack([seen.route_x, seen.route_y], axis=1) / DISTANCE
    return (points.reshape(-1, *moment.state.step.shape),)


def _within_map(limits: Limits) -> list[tuple[float, float]]:
    return [both(limits.diagonal / DISTANCE)]


SURROUNDINGS = (
    SPEED_OF_CAR,
    STEERING,
    TO_GO,
    Feature("route", 2 * len(POINTS), _within_map, _route, (METRES,)),
    Feature("edges", RAYS, share, lambda moment: (edge_distances(moment) / RANGE,), (f"{RANGE:g} m",)),
    PEOPLE,
)
"""The car 3, points of its route 16, the road's edges 24, nearest people 24."""
