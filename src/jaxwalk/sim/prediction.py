"""How close the car would come to people if it braked, held its speed or accelerated, as far as can be seen now."""

from __future__ import annotations

import jax
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
MOMENTS, MOMENT = 8, 0.375
"""The prediction looks at 8 moments, 0.375 s apart: 3 s ahead."""
POINT_SPACING = 2.5
"""The route ahead is shown at multiples of this distance [m] ..."""
POINTS = (1, 2, 3, 4, 5, 6, 8, 10)
"""... namely these."""
CONFLICT = 2.5
"""Predicted centres closer than this are a conflict [m]."""
FAR = 10.0
"""Clearances are capped here [m]."""


def route_ahead(maps: RoadMap, scenario: Scenario, state: State) -> tuple[Array, Array]:
    """Points of the route ahead in the car's frame, ahead and left [m]: two arrays ``(point, *batch)``."""
    car = state.vehicle
    steps = jnp.array(POINTS) * POINT_SPACING
    return _on_route(maps, scenario, state, car.along + steps.reshape((-1,) + (1,) * car.along.ndim))


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
) -> tuple[Float[Array, "manoeuvre *batch"], Float[Array, "*batch"]]:
    """Smallest predicted distance to anybody [m] for each manoeuvre, and the time until the first conflict at held
    speed [s].

    The car follows its route, people keep their velocity. Clearances are capped at 10 m, the time at 3 s.
    """
    car_x, car_y = _predicted_car(maps, config, scenario, state)
    x, y, vx, vy = relative_people(config, scenario, state)
    nearest = [jnp.full(x.shape, FAR**2) for _ in range(3)]
    conflict = jnp.full(x.shape, MOMENTS * MOMENT)
    for k in reversed(range(MOMENTS)):
        time = (k + 1) * MOMENT
        px, py = x + vx * time, y + vy * time
        for manoeuvre in range(3):
            dx, dy = px - car_x[manoeuvre, k], py - car_y[manoeuvre, k]
            away = dx * dx + dy * dy
            nearest[manoeuvre] = jnp.where(away < nearest[manoeuvre], away, nearest[manoeuvre])
            if manoeuvre == HOLD:
                conflict = jnp.where(away < CONFLICT**2, time, conflict)
    return jnp.sqrt(jnp.stack([each.min(axis=0) for each in nearest])), conflict.min(axis=0)


def _predicted_car(maps: RoadMap, config: SimConfig, scenario: Scenario, state: State) -> tuple[Array, Array]:
    """Where each manoeuvre would bring the car, in its present frame [m]: arrays ``(manoeuvre, moment, *batch)``."""
    speed = state.vehicle.speed
    batch = (1,) * speed.ndim
    time = (jnp.arange(1, MOMENTS + 1) * MOMENT).reshape(1, -1, *batch)
    acceleration = config.max_acceleration
    braking = jnp.minimum(time, speed / acceleration)
    accelerating = jnp.minimum(time, (config.max_speed - speed) / acceleration)
    travelled = jnp.concatenate([
        speed * braking - 0.5 * acceleration * braking**2,
        speed * time,
        speed * accelerating + 0.5 * acceleration * accelerating**2 + config.max_speed * (time - accelerating),
    ])  # fmt: skip
    return _on_route(maps, scenario, state, state.vehicle.along + travelled)


def _on_route(maps: RoadMap, scenario: Scenario, state: State, along: Array) -> tuple[Array, Array]:
    """Places on the route in the car's frame, ahead and left [m]."""
    car = state.vehicle
    x, y, _, _ = route_point(maps, scenario, along)
    return jax.lax.optimization_barrier(to_frame(x - car.x, y - car.y, car.cos, car.sin))
