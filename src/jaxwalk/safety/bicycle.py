"""The kinematic bicycle about its centre (Polack et al. 2017): its slip, and the circle of a held steering angle."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float


def slip(steering: Float[Array, "*batch"]) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"]]:
    """Return cosine and sine of the slip angle: beta = atan(0.5 tan delta), for a steering angle delta [rad].

    The centre moves along the heading plus beta. Cosine and sine need no arctangent.
    """
    tangent = 0.5 * jnp.tan(steering)
    cos = 1 / jnp.sqrt(1 + tangent * tangent)
    return cos, tangent * cos


def held_turn(
    way: Float[Array, "..."], steering: Float[Array, "..."], wheelbase: Float[Array, ""] | float
) -> tuple[Float[Array, "..."], Float[Array, "..."], Float[Array, "..."]]:
    """Return where the car is after some way with a held steering angle: ahead and left [m], and its heading [rad].

    It drives a circle of curvature sin(beta) / (L / 2): the chord of an arc s is s sin(u) / u at the angle beta + u,
    with u half the turn.

    Args:
        way: length of the arc s [m].
        steering: the steering angle [rad].
        wheelbase: distance between the axles L [m].
    """
    cos, sin = slip(steering)
    half = way * sin / wheelbase
    chord = way * jnp.sinc(half / jnp.pi)
    ahead = chord * (cos * jnp.cos(half) - sin * jnp.sin(half))
    left = chord * (sin * jnp.cos(half) + cos * jnp.sin(half))
    return ahead, left, 2 * half
