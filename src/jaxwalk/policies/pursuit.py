"""Steering along a route that is shown as points ahead."""

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
    """Pure pursuit: steering along the circle that meets a point of the route, as a share of the largest angle.

    For a bicycle about its centre, whose course is its heading plus the slip angle beta, that circle has
    tan(beta) = L y / (x2 + y2 + L x), and the steering angle is atan(2 tan(beta)): x, y is the point ahead and to the
    left [m], L the wheelbase.

    Args:
        route: the part "route" of an observation: x and y of each point ahead, over its distance along the route.
        point: which of them to aim at: an index of ``jaxwalk.sim.map_tables.POINTS``; the first is 2.5 m ahead.
        wheelbase: distance between the car's axles [m].
        max_steering: the car's largest steering angle [rad].
    """
    ahead, left = route[2 * point : 2 * point + 2] * (POINTS[point] * POINT_SPACING)
    reach = jnp.maximum(ahead * ahead + left * left + wheelbase * ahead, 1e-3)
    angle = jnp.arctan(2 * wheelbase * left / reach)
    return jnp.clip(angle / max_steering, -1, 1)
