"""The Intelligent Driver Model (Treiber, Hennecke, Helbing 2000, Physical Review E 62, 1805): following a leader."""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
from jaxtyping import Array, Float

EXPONENT = 4
"""How the acceleration falls off near the desired speed."""
CLOSEST = 0.01
"""Gaps count as at least this long [m]."""


@dataclass(frozen=True)
class FollowingStyle:
    """The parameters of the model. T and s0 are usual for towns; a 1.5 and b 2 are ours, brisker than usual."""

    acceleration: float = 1.5
    """Largest acceleration a [m/s2]."""
    braking: float = 2.0
    """Comfortable braking b [m/s2]."""
    headway: float = 1.0
    """Time to the leader T [s]."""
    standstill: float = 2.0
    """Gap to a leader who stands s0 [m]."""


def idm_acceleration(
    speed: Float[Array, "..."],
    desired: Float[Array, "..."] | float,
    gap: Float[Array, "..."],
    closing: Float[Array, "..."],
    style: FollowingStyle,
) -> Float[Array, "..."]:
    """Return the acceleration behind a leader [m/s2]: a (1 - (v / v0)^4 - (s* / s)^2).

    s* = s0 + max(0, v T + v dv / (2 sqrt(a b))). Nothing limits how hard the model brakes.

    Args:
        speed: the car's speed v [m/s].
        desired: the speed without a leader v0 [m/s].
        gap: distance to the leader s [m]; inf without one.
        closing: the car's speed minus the leader's dv [m/s].
        style: the other parameters.
    """
    approach = speed * closing / (2 * (style.acceleration * style.braking) ** 0.5)
    wanted = style.standstill + jnp.maximum(0, speed * style.headway + approach)
    return style.acceleration * (1 - (speed / desired) ** EXPONENT - (wanted / jnp.maximum(gap, CLOSEST)) ** 2)
