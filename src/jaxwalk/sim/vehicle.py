"""How the car moves: a kinematic bicycle about its centre, kept on the road, and where it is along its route."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.maps import RoadMap
from jaxwalk.maps.road_map import ROUTE_SPACING
from jaxwalk.sim.config import SimConfig
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import Course, VehicleState
from jaxwalk.sim.tables import POINTS, Tables, inside, look_up_row, of_map


def place(tables: Tables, scenario: Scenario) -> VehicleState:
    """The car at the start of its route, standing, facing along it."""
    zero = jnp.zeros(scenario.route.shape)
    at = course(tables, scenario, zero)
    return VehicleState(
        x=at.x, y=at.y, cos=at.cos, sin=at.sin, speed=zero, steering=zero, acceleration=zero, along=zero, course=at
    )


def drive(
    maps: RoadMap, tables: Tables, config: SimConfig, scenario: Scenario, vehicle: VehicleState,
    action: Float[Array, "2 *batch"],
) -> VehicleState:  # fmt: skip
    """One step of the bicycle model (Polack et al. 2017), then the projection onto the road.

    ``action`` is acceleration and steering as shares of their limits in [-1, 1]; what lies outside is clipped. The slip
    angle at the centre is beta = atan(0.5 tan delta), so cos beta and sin beta need no arctangent.
    """
    acceleration = config.max_acceleration * jnp.clip(action[0], -1, 1)
    steering = config.max_steering * jnp.clip(action[1], -1, 1)
    speed = jnp.clip(vehicle.speed + acceleration * config.dt, 0, config.max_speed)
    slip = 0.5 * jnp.tan(steering)
    cos_slip = 1 / jnp.sqrt(1 + slip * slip)
    sin_slip = slip * cos_slip
    x = vehicle.x + speed * config.dt * (vehicle.cos * cos_slip - vehicle.sin * sin_slip)
    y = vehicle.y + speed * config.dt * (vehicle.sin * cos_slip + vehicle.cos * sin_slip)
    turn = speed * config.dt * sin_slip / (0.5 * config.wheelbase)
    cos, sin = _rotate(vehicle.cos, vehicle.sin, jnp.cos(turn), jnp.sin(turn))
    x, y, off = onto_road(maps, config, scenario, x, y)
    speed = jnp.where(off, config.offroad_speed * speed, speed)
    along = _progress(tables, vehicle, x, y)
    return VehicleState(x, y, cos, sin, speed, steering, acceleration, along, course(tables, scenario, along))


def onto_road(maps: RoadMap, config: SimConfig, scenario: Scenario, x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Move a position off the road to the nearest place ``offroad_margin`` inside it; also whether it was off."""
    off = ~inside(maps.roads, scenario.map, x, y)
    best = jnp.full(x.shape, jnp.inf)
    new_x, new_y = x, y
    for box in of_map(maps.roads, scenario.map):
        near_x = jnp.clip(x, box[0] + config.offroad_margin, box[2] - config.offroad_margin)
        near_y = jnp.clip(y, box[1] + config.offroad_margin, box[3] - config.offroad_margin)
        away = (near_x - x) ** 2 + (near_y - y) ** 2
        closer = off & (away < best)
        best = jnp.where(closer, away, best)
        new_x, new_y = jnp.where(closer, near_x, new_x), jnp.where(closer, near_y, new_y)
    return new_x, new_y, off


def course(tables: Tables, scenario: Scenario, along: Float[Array, "*batch"]) -> Course:
    """The car's route at its point nearest to ``along`` [m]."""
    last = tables.course.shape[-2] - 1
    index = jnp.clip(jnp.round(along / ROUTE_SPACING).astype(jnp.int32), 0, last)
    columns = look_up_row(tables.course, scenario.map, scenario.route, index)
    return Course(*columns[:4], *jnp.split(columns[4:], (len(POINTS),)))


def goal(tables: Tables, scenario: Scenario) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"]]:
    """Where the car is to go [m]: the end of its route, in its lane."""
    x, y, _ = look_up_row(tables.finish, scenario.map, scenario.route)
    return x, y


def route_length(tables: Tables, scenario: Scenario) -> Float[Array, "*batch"]:
    """Metres from the start of the car's route to its goal."""
    return look_up_row(tables.finish, scenario.map, scenario.route)[2]


def route_frame(vehicle: VehicleState) -> tuple[Array, Array, Array]:
    """The car seen from its route: offset to the left [m], cosine and sine of the heading relative to the route's."""
    at = vehicle.course
    lateral = (vehicle.y - at.y) * at.cos - (vehicle.x - at.x) * at.sin
    relative_cos, relative_sin = to_frame(vehicle.cos, vehicle.sin, at.cos, at.sin)
    return lateral, relative_cos, relative_sin


def to_frame(x: Array, y: Array, cos: Array, sin: Array) -> tuple[Array, Array]:
    """A vector in the axes of somebody who faces (cos, sin): ahead and to the left."""
    return x * cos + y * sin, y * cos - x * sin


def _rotate(cos: Array, sin: Array, cos_turn: Array, sin_turn: Array) -> tuple[Array, Array]:
    """Turn a unit vector; one Newton step holds its length at 1, else rounding would add up over an episode."""
    new_cos, new_sin = cos * cos_turn - sin * sin_turn, sin * cos_turn + cos * sin_turn
    scale = 1.5 - 0.5 * (new_cos * new_cos + new_sin * new_sin)
    return new_cos * scale, new_sin * scale


def _progress(tables: Tables, vehicle: VehicleState, x: Array, y: Array) -> Array:
    """Foot of the position on the route near the last one: a step moves the car by less than a metre."""
    along, at = vehicle.along, vehicle.course
    at_point = jnp.round(along / ROUTE_SPACING) * ROUTE_SPACING
    ahead, _ = to_frame(x - at.x, y - at.y, at.cos, at.sin)
    longest = (tables.course.shape[-2] - 1) * ROUTE_SPACING
    return jnp.clip(jnp.clip(at_point + ahead, along - 1.0, along + 1.0), 0, longest)
