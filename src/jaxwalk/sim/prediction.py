"""How close the car would come to people if it braked, held its speed or accelerated, as far as can be seen now."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.maps import RoadMap
from jaxwalk.sim import pedestrian
from jaxwalk.sim.config import SimConfig
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import State
from jaxwalk.sim.vehicle import route_point, to_frame

BRAKE, HOLD, ACCELERATE = 0, 1, 2
"""The three manoeuvres that are predicted."""
INTERVALS, INTERVAL = 6, 0.5
"""The prediction looks 6 x 0.5 = 3 s ahead; within an interval everything moves straight."""
POINT_SPACING, POINTS = 2.5, 11
"""The route ahead as points this far apart [m], the first at the car's own place on it."""
CONFLICT = 2.5
"""Predicted centres closer than this are a conflict [m]."""
FAR = 10.0
"""Clearances are capped here [m]."""


def route_ahead(maps: RoadMap, scenario: Scenario, state: State) -> tuple[Array, Array]:
    """Points of the route ahead in the car's frame, ahead and left [m]: two arrays ``(point, *batch)``."""
    car = state.vehicle
    steps = jnp.arange(POINTS) * POINT_SPACING
    along = car.along + steps.reshape((-1,) + (1,) * car.along.ndim)
    x, y, _, _ = route_point(maps, scenario, along)
    return to_frame(x - car.x, y - car.y, car.cos, car.sin)


def relative_people(
    config: SimConfig, scenario: Scenario, state: State
) -> tuple[Float[Array, "ped *batch"], Float[Array, "ped *batch"], Float[Array, "ped *batch"], Float[Array, "ped *batch"]]:
    """Positions relative to the car [m] and velocities [m/s] of people, in the car's frame: ahead and left."""
    car, people = state.vehicle, state.pedestrian
    ahead, left = to_frame(people.x - car.x[None], people.y - car.y[None], car.cos[None], car.sin[None])
    vx, vy = pedestrian.velocity(config, scenario, people)
    ahead_speed, left_speed = to_frame(vx, vy, car.cos[None], car.sin[None])
    return ahead, left, ahead_speed, left_speed


def clearances(
    maps: RoadMap, config: SimConfig, scenario: Scenario, state: State
) -> tuple[Float[Array, "manoeuvre *batch"], Float[Array, "manoeuvre *batch"]]:
    """Smallest predicted distance to anybody [m], and the time until the first conflict [s], for each manoeuvre.

    The car follows its route, people keep their velocity; both move straight within an interval, so the closest
    approach of each pair is that of a point to a segment. Clearances are capped at 10 m, times at 3 s.
    """
    car_x, car_y = _predicted_car(maps, config, scenario, state)
    x, y, vx, vy = relative_people(config, scenario, state)
    time = (jnp.arange(INTERVALS + 1) * INTERVAL).reshape((-1,) + (1,) * x.ndim)
    gap_x = x + vx * time - car_x[:, :, None]
    gap_y = y + vy * time - car_y[:, :, None]
    start_x, start_y = gap_x[:, :-1], gap_y[:, :-1]
    move_x, move_y = gap_x[:, 1:] - start_x, gap_y[:, 1:] - start_y
    squared = move_x * move_x + move_y * move_y
    closest = jnp.clip(-(start_x * move_x + start_y * move_y) / jnp.maximum(squared, 1e-6), 0, 1)
    away = (start_x + closest * move_x) ** 2 + (start_y + closest * move_y) ** 2
    conflict = jnp.where(away < CONFLICT**2, time[:-1] + closest * INTERVAL, INTERVALS * INTERVAL)
    return jnp.minimum(jnp.sqrt(away.min(axis=(1, 2))), FAR), conflict.min(axis=(1, 2))


def _predicted_car(maps: RoadMap, config: SimConfig, scenario: Scenario, state: State) -> tuple[Array, Array]:
    """Where each manoeuvre would bring the car, in its present frame: two arrays ``(manoeuvre, time, *batch)``.

    The route between its points is interpolated by hat functions, which is cheaper than looking it up.
    """
    point_x, point_y = route_ahead(maps, scenario, state)
    speed = state.vehicle.speed
    batch = (1,) * speed.ndim
    time = (jnp.arange(INTERVALS + 1) * INTERVAL).reshape(1, -1, *batch)
    acceleration = jnp.array([-config.max_acceleration, 0.0, config.max_acceleration]).reshape(3, 1, *batch)
    limit = jnp.where(acceleration < 0, 0.0, config.max_speed)
    until = jnp.where(acceleration == 0, jnp.inf, (limit - speed) / jnp.where(acceleration == 0, 1, acceleration))
    first = jnp.minimum(time, until)
    travelled = speed * first + 0.5 * acceleration * first**2 + limit * (time - first)
    place = jnp.minimum(travelled / POINT_SPACING, POINTS - 1.0)
    x = y = jnp.zeros_like(place)
    for k in range(POINTS):
        weight = jnp.maximum(1 - jnp.abs(place - k), 0)
        x, y = x + weight * point_x[k], y + weight * point_y[k]
    return x, y
