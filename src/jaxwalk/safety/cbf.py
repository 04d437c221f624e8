"""Control barrier functions: C3BF's collision cone (Thontepu et al. 2022, arXiv:2209.11524), in discrete time."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

SLOWEST = 1e-3
"""Relative speeds count as at least this in ratios [m/s]."""


def collision_cone(
    place: tuple[Float[Array, "..."], Float[Array, "..."]],
    velocity: tuple[Float[Array, "..."], Float[Array, "..."]],
    radius: Float[Array, "..."] | float,
) -> Float[Array, "..."]:
    """Return h = p.w + |w| sqrt(|p|2 - r2) [m2/s]: below 0 if the relative velocity points into the circle.

    Args:
        place: p, where the other one is from here [m]; inside the circle the root counts as 0.
        velocity: w, the other one's velocity relative to the own one [m/s].
        radius: r, the distance to keep [m].
    """
    (px, py), (wx, wy) = place, velocity
    outside = jnp.maximum(px * px + py * py - radius * radius, 0)
    return px * wx + py * wy + jnp.sqrt((wx * wx + wy * wy) * outside)


def least_allowed(
    now: Float[Array, "..."], speed: Float[Array, "..."], speed_after: Float[Array, "..."], gamma: float
) -> Float[Array, "..."]:
    """Return the smallest h that a step may lead to: (1 - gamma) h, in discrete time (Agrawal and Sreenath 2017).

    h is proportional to the relative speed. Where it is positive, what it loses only because that speed falls doesn't
    count, which is ours: else a car near people could not brake hard.

    Args:
        now: h before the step [m2/s].
        speed: relative speed before it [m/s].
        speed_after: relative speed after it [m/s].
        gamma: the share of h that a step may use up, in (0, 1].
    """
    slower = jnp.minimum(speed_after / jnp.maximum(speed, SLOWEST), 1)
    return (1 - gamma) * now * jnp.where(now > 0, slower, 1)
