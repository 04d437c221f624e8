"""How the car moves: a kinematic bicycle about its centre, kept on the road, and where it is along its route."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.maps import RoadMap
from jaxwalk.maps.road_map import ROUTE_SPACING
from jaxwalk.sim.config import SimConfig
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import VehicleState
from jaxwalk.sim.tables import inside, look_up, look_up_each, of_map


def place(maps: RoadMap, scenario: Scenario) -> VehicleState:
    """The car at the start of its route, standing, facing along it."""
    x, y, cos, sin = route_point(maps, scenario, jnp.zeros(scenario.route.shape))
    zero = jnp.zeros_like(x)
    return VehicleState(x=x, y=y, cos=cos, sin=sin, speed=zero, steering=zero, acceleration=zero, along=zero)


def drive(
    maps: RoadMap, config: SimConfig, scenario: Scenario, vehicle: VehicleState, action: Float[Array, "2 *batch"]
) -> VehicleState:
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
    along = _progress(maps, scenario, vehicle.along, x, y)
    return VehicleState(x, y, cos, sin, speed, steering, acceleration, along)


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


def route_point(
    maps: RoadMap, scenario: Scenario, along: Float[Array, "*any"]
) -> tuple[Float[Array, "*any"], Float[Array, "*any"], Float[Array, "*any"], Float[Array, "*any"]]:
    """Position and direction (x, y, cos, sin) of the route's sample nearest to ``along`` [m]."""
    last = maps.route_x.shape[-1] - 1
    index = jnp.clip(jnp.round(along / ROUTE_SPACING).astype(jnp.int32), 0, last)
    tables = (maps.route_x, maps.route_y, maps.route_cos, maps.route_sin)
    x, y, cos, sin = look_up_each(tables, scenario.map, scenario.route, index)
    return x, y, cos, sin


def goal(maps: RoadMap, scenario: Scenario) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"]]:
    """Where the car is to go [m]: the end of its route, in its lane."""
    length = route_length(maps, scenario)
    x, y, cos, sin = route_point(maps, scenario, length)
    beyond = length - jnp.round(length / ROUTE_SPACING) * ROUTE_SPACING
    return x + cos * beyond, y + sin * beyond


def route_length(maps: RoadMap, scenario: Scenario) -> Float[Array, "*batch"]:
    """Metres from the start of the car's route to its goal."""
    return look_up(maps.route_length, scenario.map, scenario.route)


def route_frame(maps: RoadMap, scenario: Scenario, vehicle: VehicleState) -> tuple[Array, Array, Array]:
    """The car seen from its route: offset to the left [m], cosine and sine of the heading relative to the route's."""
    x, y, cos, sin = route_point(maps, scenario, vehicle.along)
    lateral = (vehicle.y - y) * cos - (vehicle.x - x) * sin
    relative_cos, relative_sin = to_frame(vehicle.cos, vehicle.sin, cos, sin)
    return lateral, relative_cos, relative_sin


def to_frame(x: Array, y: Array, cos: Array, sin: Array) -> tuple[Array, Array]:
    """A vector in the axes of somebody who faces (cos, sin): ahead and to the left."""
    return x * cos + y * sin, y * cos - x * sin


def _rotate(cos: Array, sin: Array, cos_turn: Array, sin_turn: Array) -> tuple[Array, Array]:
    """Turn a unit vector; one Newton step holds its length at 1, else rounding would add up over an episode."""
    new_cos, new_sin = cos * cos_turn - sin * sin_turn, sin * cos_turn + cos * sin_turn
    scale = 1.5 - 0.5 * (new_cos * new_cos + new_sin * new_sin)
    return new_cos * scale, new_sin * scale


def _progress(maps: RoadMap, scenario: Scenario, along: Array, x: Array, y: Array) -> Array:
    """Foot of the position on the route near the last one: a step moves the car by less than a metre."""
    point_x, point_y, cos, sin = route_point(maps, scenario, along)
    at_point = jnp.round(along / ROUTE_SPACING) * ROUTE_SPACING
    ahead, _ = to_frame(x - point_x, y - point_y, cos, sin)
    longest = (maps.route_x.shape[-1] - 1) * ROUTE_SPACING
    return jnp.clip(jnp.clip(at_point + ahead, along - 1.0, along + 1.0), 0, longest)
