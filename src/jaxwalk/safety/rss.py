"""Responsibility-sensitive safety on open ground: RSS (Shalev-Shwartz et al. 2017, arXiv:1708.06374, section 3.7).

Everybody reacts after a response time, in which they speed up; then they brake, or go on speeding up. How far that
brings them are the *braking* and the *forward* way. The sets of places are those of Intel's ad-rss-lib, simplified: a
car keeps its steering angle, and who walks reaches a sector.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float


@dataclass(frozen=True)
class Response:
    """How somebody responds."""

    reaction: float
    """Response time rho [s]."""
    acceleration: Float[Array, ""] | float
    """How much they speed up until then, and go on to in the forward way [m/s2]."""
    braking: Float[Array, ""] | float
    """How hard they brake at least from then on [m/s2]."""
    fastest: Float[Array, ""] | float
    """They speed up to this at most [m/s]."""


PERSON = Response(reaction=0.5, acceleration=2.0, braking=2.0, fastest=2.5)
"""A pedestrian, with the numbers of CARLA's RssCheck; the highest speed is ours."""
TURNING_RADIUS = 2.0
"""Who walks turns on a circle of this radius at least, until the response time, and then goes straight [m]."""
CAR = Response(reaction=1.0, acceleration=3.5, braking=4.0, fastest=100.0)
"""A car, with the numbers of CARLA's RssCheck: a car that can do less responds by what it can."""
STANDING = 0.1
"""Who is slower than this may set off in any direction [m/s]."""


def sped_up(
    speed: Float[Array, "*batch"], time: Float[Array, "*batch"] | float, response: Response
) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"]]:
    """Return way [m] and speed [m/s] after speeding up for some time [s]: at the highest speed nobody is any faster."""
    most = jnp.maximum(speed, response.fastest)
    speeding = jnp.minimum(time, (most - speed) / response.acceleration)
    after = speed + response.acceleration * speeding
    return (speed + after) / 2 * speeding + after * (time - speeding), after


def braking_way(speed: Float[Array, "*batch"], response: Response) -> Float[Array, "*batch"]:
    """Return the way until somebody stands who responds by braking [m]: v rho + a rho2 / 2 + (v + a rho)2 / (2 b)."""
    way, after = sped_up(speed, response.reaction, response)
    return way + after * after / (2 * response.braking)


def forward_way(speed: Float[Array, "*batch"], response: Response) -> Float[Array, "*batch"]:
    """Return the way of somebody who goes on speeding up [m], in the time in which braking would make them stand."""
    after = sped_up(speed, response.reaction, response)[1]
    return sped_up(speed, response.reaction + after / response.braking, response)[0]


def turn_until_response(
    speed: Float[Array, "*batch"], response: Response = PERSON, radius: float = TURNING_RADIUS
) -> Float[Array, "*batch"]:
    """Return how far somebody on foot can turn to either side until the response time [rad]; pi for who stands."""
    way = sped_up(speed, response.reaction, response)[0]
    return jnp.where(speed < STANDING, jnp.pi, jnp.minimum(way / radius, jnp.pi))


def near_sector(
    point: tuple[Float[Array, "..."], Float[Array, "..."]], half_angle: Float[Array, "..."],
    radius: Float[Array, "..."], within: Float[Array, "..."] | float,
) -> Bool[Array, "..."]:  # fmt: skip
    """Return whether a point is closer to a sector of a circle than a distance; it is if it is inside.

    It is asked for many points at once, and needs no root and no arctangent for it.

    Args:
        point: how far it is from the sector's apex along its middle, and how far to the side [m].
        half_angle: the sector reaches as far to either side [rad].
        radius: the sector's radius [m].
        within: the distance, above 0 [m].
    """
    ahead, aside = point[0], jnp.abs(point[1])
    cos, sin = jnp.cos(half_angle), jnp.sin(half_angle)
    along, beside = ahead * cos + aside * sin, aside * cos - ahead * sin  # in the axes of the edge on that side
    to_apex, reach = ahead * ahead + aside * aside, radius + within
    past = jnp.maximum(along - radius, 0)
    to_edge = jnp.where(along < 0, to_apex, past * past + beside * beside)
    between = (beside <= 0) & ((along >= 0) | (half_angle > jnp.pi / 2))
    inside = between | (half_angle >= jnp.pi)
    return jnp.where(inside, to_apex < reach * reach, to_edge < within * within)
