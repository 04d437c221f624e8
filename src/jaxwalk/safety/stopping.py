"""When a car would hit something, the last moment to brake, and how a person brakes."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

STILL = 1e-3
"""Slower than this nothing comes nearer [m/s]."""


def time_to_collision(gap: Float[Array, "..."], closing: Float[Array, "..."]) -> Float[Array, "..."]:
    """Return the time until a gap is closed if both keep their speeds [s]; inf if it doesn't shrink.

    Args:
        gap: distance between the surfaces [m]; a negative one counts as 0.
        closing: how fast the gap shrinks [m/s].
    """
    return jnp.where(closing > STILL, jnp.maximum(gap, 0) / jnp.maximum(closing, STILL), jnp.inf)


def last_moment(speed: Float[Array, "..."], braking: float, spare: float) -> Float[Array, "..."]:
    """Return the time to collision at which full braking still stops the car, ``spare`` seconds early: v / (2 b) + t.

    Braking b [m/s2] from speed v takes v2 / (2 b) metres, which the unbraked car drives in v / (2 b) seconds.
    """
    return speed / (2 * braking) + spare


def ramp(since: Float[Array, "..."], most: float, rise: float) -> Float[Array, "..."]:
    """Return the deceleration ``since`` seconds after the foot met the brake [m/s2]: linear up to ``most`` in ``rise``.

    The careful and competent human driver of UN R157 (annex 4, appendix 3) reaches 0.774 g = 7.59 m/s2 in 0.6 s.
    """
    return most * jnp.clip(since / rise, 0, 1)
