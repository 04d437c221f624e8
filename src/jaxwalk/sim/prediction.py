"""How close the car would come to people if it braked, held its speed or accelerated, as far as can be seen now."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array

from jaxwalk.maps import RoadMap
from jaxwalk.sim import pedestrian
from jaxwalk.sim.config import SimConfig
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import Foresight, PedestrianState, VehicleState
from jaxwalk.sim.trajectory import CROSSWALK, JAYWALK
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
CAUTION_AHEAD, CAUTION_ASIDE = 15.0, 6.0
"""People on the roadway this far ahead of the car and this far aside [m] call for caution."""


def relative_people(
    config: SimConfig, scenario: Scenario, car: VehicleState, people: PedestrianState
) -> tuple[Array, Array, Array, Array]:
    """People in the car's frame: where they are, ahead and left [m], and their velocities, ahead and left [m/s].

    Arrays ``(ped, *batch)``.
    """
    ahead, left = to_frame(people.x - car.x[None], people.y - car.y[None], car.cos[None], car.sin[None])
    vx, vy = pedestrian.velocity(config, scenario, people)
    ahead_speed, left_speed = to_frame(vx, vy, car.cos[None], car.sin[None])
    return ahead, left, ahead_speed, left_speed


def foresee(
    maps: RoadMap, config: SimConfig, scenario: Scenario, car: VehicleState, people: PedestrianState
) -> Foresight:
    """The route ahead, the smallest predicted distance to anybody for each manoeuvre, the time until a conflict, and
    whether somebody crosses close ahead.

    The car follows its route (straight from each shown point of it to the next), people keep their velocity. Clearances
    are capped at 10 m, the time at 3 s. One pedestrian after the other is compared with all moments, so that nothing
    large is ever stored.
    """
    route_x, route_y = _route_ahead(maps, scenario, car)
    car_x, car_y = _predicted_car(config, car, route_x, route_y)
    motion = jax.lax.optimization_barrier(relative_people(config, scenario, car, people))
    on_crosswalk = people.on_roadway & (people.crossing == CROSSWALK)
    jaywalks = people.on_roadway & (people.crossing == JAYWALK)

    def compare(person: Array, found: tuple[Array, Array, Array, Array]) -> tuple[Array, Array, Array, Array]:
        nearest, conflict, crosswalk_user, jaywalker = found
        x, y, vx, vy = (of_all[person] for of_all in motion)
        ahead = (x > 0) & (x < CAUTION_AHEAD) & (jnp.abs(y) < CAUTION_ASIDE)
        for k in range(MOMENTS):
            time = (k + 1) * MOMENT
            away = (x + vx * time - car_x[k]) ** 2 + (y + vy * time - car_y[k]) ** 2
            nearest = jnp.where(away < nearest, away, nearest)
            conflict = jnp.where((away[HOLD] < CONFLICT**2) & (time < conflict), time, conflict)
        crosswalk_user, jaywalker = (
            crosswalk_user | (ahead & on_crosswalk[person]),
            jaywalker | (ahead & jaywalks[person]),
        )
        return nearest, conflict, crosswalk_user, jaywalker

    nobody = jnp.zeros(car.x.shape, bool)
    nothing = (jnp.full((3, *car.x.shape), FAR**2), jnp.full(car.x.shape, MOMENTS * MOMENT), nobody, nobody)
    nearest, conflict, crosswalk_user, jaywalker = jax.lax.fori_loop(0, people.going.shape[0], compare, nothing)
    return Foresight(route_x, route_y, jnp.sqrt(nearest), conflict, crosswalk_user, jaywalker)


def _route_ahead(maps: RoadMap, scenario: Scenario, car: VehicleState) -> tuple[Array, Array]:
    """Points of the route in the car's frame, ahead and left [m]: two arrays ``(point, *batch)``."""
    steps = jnp.array(POINTS) * POINT_SPACING
    x, y, _, _ = route_point(maps, scenario, car.along + steps.reshape((-1,) + (1,) * car.along.ndim))
    return jax.lax.optimization_barrier(to_frame(x - car.x, y - car.y, car.cos, car.sin))


def _predicted_car(config: SimConfig, car: VehicleState, route_x: Array, route_y: Array) -> tuple[Array, Array]:
    """Where each manoeuvre would bring the car, in its present frame [m]: arrays ``(moment, manoeuvre, *batch)``."""
    batch = (1,) * car.speed.ndim
    time = (jnp.arange(1, MOMENTS + 1) * MOMENT).reshape(-1, *batch)
    acceleration = config.max_acceleration
    braking = jnp.minimum(time, car.speed / acceleration)
    accelerating = jnp.minimum(time, (config.max_speed - car.speed) / acceleration)
    travelled = jnp.stack(
        [
            car.speed * braking - 0.5 * acceleration * braking**2,
            car.speed * time,
            car.speed * accelerating + 0.5 * acceleration * accelerating**2 + config.max_speed * (time - accelerating),
        ],
        axis=1,
    )
    x = y = jnp.zeros(travelled.shape)
    begin, from_x, from_y = 0.0, jnp.zeros(car.x.shape), jnp.zeros(car.x.shape)
    for k, end in enumerate(POINT_SPACING * point for point in POINTS):
        share = jnp.clip((travelled - begin) / (end - begin), 0, 1)
        x, y = x + share * (route_x[k] - from_x), y + share * (route_y[k] - from_y)
        begin, from_x, from_y = end, route_x[k], route_y[k]
    return jax.lax.optimization_barrier((x, y))
