"""Where braking, holding the speed and accelerating would bring the car, and how near that is to people.

The car is predicted to follow its route, straight from each shown point to the next. Distances from the car's
rectangle show every decimetre, so they are predicted with more care than distances between centres, which stay as
policies of 0.1 have learned them: at closer moments, and on a way that begins at the car and comes back to its route.
The rectangle points from the rear axle to the centre, and both follow that way: a car in a bend points out of it.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Protocol, runtime_checkable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.sim import vehicle
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from jaxwalk.sim.sim_config import ContactRule
from jaxwalk.sim.state import VehicleState
from jaxwalk.sim.world import World

MANOEUVRES = BRAKE, HOLD, ACCELERATE = 0, 1, 2
"""The three manoeuvres that are predicted."""
AHEAD = 3.0
"""The prediction covers this time [s] ..."""
MOMENTS: dict[ContactRule, tuple[float, ...]] = {
    "disc": (0.375, 0.75, 1.125, 1.5, 1.875, 2.25, 2.625, AHEAD),
    "footprint": (0.1, 0.2, 0.3, 0.4, 0.55, 0.7, 0.9, 1.15, 1.45, 1.85, 2.35, AHEAD),
}
"""... by looking at these moments [s]: what is near can't be corrected later, so it is looked at closely."""
CONFLICT: dict[ContactRule, float] = {"disc": 2.5, "footprint": 0.3}
"""A conflict is a predicted clearance below this [m]: a contact, or almost one."""
SHORTEST = 1e-3
"""The car's direction is unknown where its centre and rear axle are predicted nearer to each other than this [m]."""
FAR = 10.0
"""Clearances are capped here [m]."""


@runtime_checkable
class Walk(Protocol):
    """How somebody is predicted to walk."""

    def at(self, time: Array) -> tuple[Array, Array]:
        """Return how far ahead and to the left of the car's present place they are after some time [s], in metres."""
        ...


def far(car: VehicleState, contact: ContactRule) -> Array:
    """Return the largest squared clearance, ``(moment, manoeuvre, *batch)``."""
    return jnp.full((len(MOMENTS[contact]), len(MANOEUVRES), *car.speed.shape), FAR**2)


def squared_clearance(
    world: World, car: VehicleState, route: tuple[Array, Array], contact: ContactRule
) -> Callable[[Walk], Array]:
    """Return a function that gives somebody's predicted distances, squared; ``(moment, manoeuvre, *batch)``.

    They are distances from the person's centre to the car's centre, or to its rectangle. ``route`` holds the points
    ahead and to the left of the car, ``(point, *batch)`` each.
    """
    time = _moments(contact, 1 + car.speed.ndim)
    if contact == "footprint":
        route = _from_the_car(car, route)
    (car_x, beyond_x), (car_y, beyond_y) = _predicted_car(world, car, route, time)
    half_length, half_width = world.rules.car_length / 2, world.rules.car_width / 2
    norm = jax.lax.rsqrt(jnp.maximum(beyond_x**2 + beyond_y**2, SHORTEST**2))

    def squared(person: Walk) -> Array:
        x, y = person.at(time)
        dx, dy = x - car_x, y - car_y
        if contact == "disc":
            return dx**2 + dy**2
        ahead, left = to_frame(dx, dy, beyond_x * norm, beyond_y * norm)
        return jnp.maximum(jnp.abs(ahead) - half_length, 0) ** 2 + jnp.maximum(jnp.abs(left) - half_width, 0) ** 2

    return squared


def clearance_and_conflict(world: World, closest: Array, contact: ContactRule) -> tuple[Array, Array]:
    """Return each manoeuvre's clearance [m] and the time until its first conflict [s], ``(manoeuvre, *batch)``.

    ``closest`` holds squared distances to the nearest person's centre, ``(moment, manoeuvre, *batch)``.
    """
    body = 0 if contact == "disc" else world.rules.body_radius
    time = _moments(contact, closest.ndim - 1)
    conflict = jnp.where(closest < (CONFLICT[contact] + body) ** 2, time, AHEAD).min(axis=0)
    return jnp.maximum(jnp.sqrt(closest.min(axis=0)) - body, 0), conflict


def _moments(contact: ContactRule, axes: int) -> Array:
    """Return the moments [s], followed by this number of axes."""
    return jnp.array(MOMENTS[contact]).reshape(-1, *(1,) * axes)


def _from_the_car(car: VehicleState, route: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return the points of a way that begins at the car, beside its route, and is back on it at the last point."""
    lateral, cos, sin = vehicle.route_frame(car)
    beside = (1 - jnp.array(POINTS) / POINTS[-1]).reshape(-1, *(1,) * car.speed.ndim) * lateral
    return route[0] + beside * sin, route[1] + beside * cos


def _predicted_car(
    world: World, car: VehicleState, route: tuple[Array, Array], time: Array
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return x and y of the car after each manoeuvre, and how far they are beyond those of its rear axle.

    Arrays are ``(moment, manoeuvre, *batch)``, in the car's present frame [m].
    """
    rules, acceleration, time = world.rules, world.rules.max_acceleration, time[:, 0]
    braking = jnp.minimum(time, car.speed / rules.max_braking)
    top = jnp.maximum(vehicle.top_speed(world, car), car.speed)
    accelerating = jnp.minimum(time, (top - car.speed) / acceleration)
    travelled = jnp.stack(
        [
            car.speed * braking - 0.5 * rules.max_braking * braking**2,
            car.speed * time,
            car.speed * accelerating + 0.5 * acceleration * accelerating**2 + top * (time - accelerating),
        ],
        axis=1,
    )
    rear = travelled - rules.wheelbase / 2  # its way is behind the car at first, then the centre's
    places = [(_along(of_route, travelled), _along(of_route, rear)) for of_route in route]
    axles = [jnp.where(rear > 0, place, behind) for (_, place), behind in zip(places, (rear, 0.0), strict=True)]
    (x, _), (y, _) = places
    return (x, x - axles[0]), (y, y - axles[1])


def _along(route: Float[Array, "point *batch"], metres: Array) -> Array:
    """Return a coordinate of the place this many metres along the straight pieces between the route's points.

    It is a sum: the first piece, continued, and the change of slope at each point, from there on. Beyond the last
    point the last piece continues.
    """
    points = jnp.unstack(route)
    lengths = [POINT_SPACING * (to - at) for at, to in pairwise((0, *POINTS))]
    slopes = [(to - at) / length for at, to, length in zip((0, *points[:-1]), points, lengths, strict=True)]
    place = slopes[0] * metres
    for point, (old, new) in zip(POINTS[:-1], pairwise(slopes), strict=True):
        place = place + (new - old) * jnp.maximum(metres - POINT_SPACING * point, 0)
    return place
