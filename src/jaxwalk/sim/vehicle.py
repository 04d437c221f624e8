"""How the car moves: a kinematic bicycle about its centre, kept on the road, and where it is along its route."""

from __future__ import annotations

import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.maps.routes import ROUTE_SPACING
from jaxwalk.sim.geometry import inside, rotate, to_frame
from jaxwalk.sim.lookup import look_up_row, of_map
from jaxwalk.sim.map_tables import POINTS
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import Course, VehicleState
from jaxwalk.sim.world import World


def place(world: World, scenario: Scenario) -> VehicleState:
    """Return the car at the start of its route, standing, facing along it."""
    zero = jnp.zeros(scenario.route.shape)
    at = course(world, scenario, zero)
    return VehicleState(
        x=at.x, y=at.y, cos=at.cos, sin=at.sin, speed=zero, steering=zero, acceleration=zero, along=zero, course=at
    )


def drive(world: World, scenario: Scenario, vehicle: VehicleState, action: Float[Array, "2 *batch"]) -> VehicleState:
    """Move the car by one step of the bicycle model (Polack et al. 2017), then put it back onto the road.

    ``action`` holds acceleration and steering as shares of their limits, clipped to [-1, 1]. The slip angle at the
    centre is beta = atan(0.5 tan delta), so cos beta and sin beta need no arctangent.
    """
    rules = world.rules
    acceleration = rules.max_acceleration * jnp.clip(action[0], -1, 1)
    steering = rules.max_steering * jnp.clip(action[1], -1, 1)
    speed = jnp.clip(vehicle.speed + acceleration * rules.dt, 0, rules.max_speed)
    slip = 0.5 * jnp.tan(steering)
    cos_slip = 1 / jnp.sqrt(1 + slip * slip)
    sin_slip = slip * cos_slip
    x = vehicle.x + speed * rules.dt * (vehicle.cos * cos_slip - vehicle.sin * sin_slip)
    y = vehicle.y + speed * rules.dt * (vehicle.sin * cos_slip + vehicle.cos * sin_slip)
    turn = speed * rules.dt * sin_slip / (0.5 * rules.wheelbase)
    cos, sin = rotate(vehicle.cos, vehicle.sin, jnp.cos(turn), jnp.sin(turn))
    x, y, off = onto_road(world, scenario, x, y)
    speed = jnp.where(off, rules.offroad_speed * speed, speed)
    along = _progress(world, vehicle, x, y)
    return VehicleState(x, y, cos, sin, speed, steering, acceleration, along, course(world, scenario, along))


def onto_road(world: World, scenario: Scenario, x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Move a position off the road to the nearest place well inside it; also return whether it was off."""
    roads, margin = world.maps.roads, world.rules.offroad_margin
    off = ~inside(roads, scenario.map, x, y)
    best = jnp.full(x.shape, jnp.inf)
    new_x, new_y = x, y
    for box in of_map(roads, scenario.map):
        near_x = jnp.clip(x, box[0] + margin, box[2] - margin)
        near_y = jnp.clip(y, box[1] + margin, box[3] - margin)
        away = (near_x - x) ** 2 + (near_y - y) ** 2
        closer = off & (away < best)
        best = jnp.where(closer, away, best)
        new_x, new_y = jnp.where(closer, near_x, new_x), jnp.where(closer, near_y, new_y)
    return new_x, new_y, off


def course(world: World, scenario: Scenario, along: Float[Array, "*batch"]) -> Course:
    """Return the car's route at its point nearest to ``along`` [m]."""
    table = world.tables.course
    last = table.shape[-2] - 1
    index = jnp.clip(jnp.round(along / ROUTE_SPACING).astype(jnp.int32), 0, last)
    columns = look_up_row(table, scenario.map, scenario.route, index)
    return Course(*columns[:4], *jnp.split(columns[4:], (len(POINTS),)))


def goal(world: World, scenario: Scenario) -> tuple[Float[Array, "*batch"], Float[Array, "*batch"]]:
    """Return where the car is to go [m]: the end of its route, in its lane."""
    x, y, _ = look_up_row(world.tables.finish, scenario.map, scenario.route)
    return x, y


def route_length(world: World, scenario: Scenario) -> Float[Array, "*batch"]:
    """Return the metres from the start of the car's route to its goal."""
    return look_up_row(world.tables.finish, scenario.map, scenario.route)[2]


def route_frame(vehicle: VehicleState) -> tuple[Array, Array, Array]:
    """Return the car's offset to the left of its route [m], and cosine and sine of its heading in the route's frame."""
    at = vehicle.course
    lateral = (vehicle.y - at.y) * at.cos - (vehicle.x - at.x) * at.sin
    relative_cos, relative_sin = to_frame(vehicle.cos, vehicle.sin, at.cos, at.sin)
    return lateral, relative_cos, relative_sin


def _progress(world: World, vehicle: VehicleState, x: Array, y: Array) -> Array:
    """Return how far along its route the car is [m], at most 1 m from where it was, or one step at top speed."""
    along, at = vehicle.along, vehicle.course
    at_point = jnp.round(along / ROUTE_SPACING) * ROUTE_SPACING
    ahead, _ = to_frame(x - at.x, y - at.y, at.cos, at.sin)
    longest = (world.tables.course.shape[-2] - 1) * ROUTE_SPACING
    reach = jnp.maximum(1.0, world.rules.max_speed * world.rules.dt)
    return jnp.clip(jnp.clip(at_point + ahead, along - reach, along + reach), 0, longest)
