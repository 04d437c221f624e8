"""Steering along a route that an observation gives as points ahead."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.sim_config import SimConfig


def pursue(
    route: Float[Array, "coordinate *batch"],
    *,
    point: int = 0,
    wheelbase: float = SimConfig.wheelbase,
    max_steering: float = SimConfig.max_steering,
) -> Float[Array, "*batch"]:
    """Return the steering of pure pursuit, as a share of the largest angle: the circle through a point of the route.

    A bicycle model about the centre moves along its heading plus the slip angle beta. Its circle has
    tan(beta) = L y / (x2 + y2 + L x), and the steering angle is atan(2 tan(beta)). Here x and y are the point's
    distances ahead and to the left [m], and L is the wheelbase [m].

    Args:
        route: the part "route" of an observation: x and y of each point ahead, divided by its distance along the route.
        point: the point to steer to: an index of ``jaxwalk.sim.map_tables.POINTS``; the first is 2.5 m ahead.
        wheelbase: distance between the car's axles [m].
        max_steering: the car's largest steering angle [rad].
    """
    ahead, left = route[2 * point : 2 * point + 2] * (POINTS[point] * POINT_SPACING)
    reach = jnp.maximum(ahead * ahead + left * left + wheelbase * ahead, 1e-3)
    angle = jnp.arctan(2 * wheelbase * left / reach)
    return jnp.clip(angle / max_steering, -1, 1)
