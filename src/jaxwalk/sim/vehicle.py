"""How the car moves: a kinematic bicycle about its centre, kept on the road, and where it is along its route."""

from __future__ import annotations

import functools
from dataclasses import replace

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.maps.road_field import BEYOND, CELL, UNIT
from jaxwalk.maps.routes import ROUTE_SPACING
from jaxwalk.platforms import few_launches
from jaxwalk.safety.bicycle import slip
from jaxwalk.sim.geometry import rotate, to_frame
from jaxwalk.sim.lookup import look_up, look_up_row
from jaxwalk.sim.map_tables import POINTS
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.script import Script
from jaxwalk.sim.state import Course, VehicleState
from jaxwalk.sim.world import World

PUSHES, CLOSE = 3, 1e-4
"""A car off the road is pushed away from the nearest kerb at most this often, since where kerbs meet another one may be
too near; no more if it is within `CLOSE` metres of the place that it is pushed to."""


def place(world: World, scenario: Scenario) -> VehicleState:
    """Return the car at the start of its route, standing, facing along it; a script begins where and how it says."""
    zero = jnp.zeros(scenario.route.shape)
    if scenario.script is not None:
        return _place_by_script(world, scenario, scenario.script)
    at = course(world, scenario, zero)
    return VehicleState(
        x=at.x, y=at.y, cos=at.cos, sin=at.sin, speed=zero, steering=zero, acceleration=zero, along=zero, course=at
    )


def _place_by_script(world: World, scenario: Scenario, script: Script) -> VehicleState:
    at, zero = course(world, scenario, script.start), jnp.zeros_like(script.start)
    past = script.start - jnp.round(script.start / ROUTE_SPACING) * ROUTE_SPACING
    return VehicleState(
        x=at.x + past * at.cos, y=at.y + past * at.sin, cos=at.cos, sin=at.sin, speed=script.speed, steering=zero,
        acceleration=zero, along=script.start, course=at,
    )  # fmt: skip


def drive(world: World, scenario: Scenario, vehicle: VehicleState, action: Float[Array, "2 *batch"]) -> VehicleState:
    """Move the car by one step of the bicycle model (Polack et al. 2017), then put it back onto the road.

    ``action`` holds acceleration (below 0: braking) and steering as shares of their limits, clipped to [-1, 1]. A car
    above its top speed here brakes.
    """
    rules = world.rules
    pedal = jnp.clip(action[0], -1, 1)
    acceleration = jnp.where(pedal < 0, rules.max_braking, rules.max_acceleration) * pedal
    steering = rules.max_steering * jnp.clip(action[1], -1, 1)
    top = jnp.maximum(top_speed(world, vehicle), vehicle.speed - rules.max_braking * rules.dt)
    speed = jnp.clip(vehicle.speed + acceleration * rules.dt, 0, top)
    cos_slip, sin_slip = slip(steering)
    x = vehicle.x + speed * rules.dt * (vehicle.cos * cos_slip - vehicle.sin * sin_slip)
    y = vehicle.y + speed * rules.dt * (vehicle.sin * cos_slip + vehicle.cos * sin_slip)
    turn = speed * rules.dt * sin_slip / (0.5 * rules.wheelbase)
    cos, sin = rotate(vehicle.cos, vehicle.sin, jnp.cos(turn), jnp.sin(turn))
    x, y, off = onto_road(world, scenario, vehicle, x, y)
    speed = jnp.where(off, rules.offroad_speed * speed, speed)
    along = _progress(world, vehicle, x, y)
    return VehicleState(x, y, cos, sin, speed, steering, acceleration, along, course(world, scenario, along))


def top_speed(world: World, vehicle: VehicleState) -> Float[Array, "*batch"]:
    """Return the smaller of the car's top speed and the speed limit where it is [m/s]."""
    return jnp.minimum(world.rules.max_speed, vehicle.course.limit)


def throttle(world: World, vehicle: VehicleState) -> Float[Array, "*batch"]:
    """Return the car's acceleration as a share of the largest, or below 0 of the largest braking, in [-1, 1]."""
    largest = jnp.where(vehicle.acceleration < 0, world.rules.max_braking, world.rules.max_acceleration)
    return vehicle.acceleration / largest


def onto_road(
    world: World, scenario: Scenario, vehicle: VehicleState, x: Array, y: Array
) -> tuple[Array, Array, Array]:
    """Move a position off the road to the nearest place well inside it; also return whether it was off.

    Far off the road, or in a corner too narrow for it, the car stays where it was. No car depends on another. On a
    GPU, whose host would have to wait for the answer whether a car must be pushed again, all pushes are made.
    """
    first = room(world, scenario, x, y)
    off = first[0] <= 0

    def missing(inside: Array) -> Array:
        short = world.rules.offroad_margin - inside
        return jnp.where(off & (short > CLOSE), short, 0)

    def goes_on(pushed: tuple) -> Array:
        count, _, _, (inside, _, _) = pushed
        return (count < PUSHES) & (missing(inside) > 0).any()

    def push(pushed: tuple) -> tuple:
        count, x, y, (inside, east, north) = pushed
        x, y = x + missing(inside) * east, y + missing(inside) * north
        return count + 1, x, y, room(world, scenario, x, y)

    if few_launches():
        pushed = functools.reduce(lambda at, _: push(at), range(PUSHES), (0, x, y, first))
    else:
        pushed = jax.lax.while_loop(goes_on, push, (0, x, y, first))
    _, new_x, new_y, (inside, _, _) = pushed
    lost = off & (inside <= 0)
    return jnp.where(lost, vehicle.x, new_x), jnp.where(lost, vehicle.y, new_y), off


def room(world: World, scenario: Scenario, x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Return the distance to the roadway's edge [m], negative off the roadway, and the direction in which it grows.

    A cell is cut along the diagonal on which the distance changes more, and each half is a plane: so the corners of
    blocks are exact too. More than 3.175 m are cut off. The direction is a unit vector, and 0 far from every edge.
    """
    field = world.maps.field
    rows, columns = field.shape[1:]
    east, north = (jnp.clip((at + BEYOND) / CELL, 0, count - 0.01) for at, count in ((x, columns), (y, rows)))
    column, row = east.astype(jnp.int32), north.astype(jnp.int32)
    packed = look_up(field, scenario.map, row, column)
    sw, se, nw, ne = (UNIT * ((packed << shift) >> 24).astype(jnp.float32) for shift in (24, 16, 8, 0))
    u, v = east - column, north - row
    rising = jnp.abs(ne - sw) >= jnp.abs(se - nw)
    dx = jnp.where(jnp.where(rising, u >= v, u + v <= 1), se - sw, ne - nw)
    dy = jnp.where(jnp.where(rising, u >= v, u + v > 1), ne - se, nw - sw)
    inside = u * dx + v * dy + jnp.where(rising | (u + v <= 1), sw, ne - dx - dy)
    steepness = jnp.maximum(jnp.sqrt(dx * dx + dy * dy), UNIT / 10)
    return inside, dx / steepness, dy / steepness


def course(world: World, scenario: Scenario, along: Float[Array, "*batch"]) -> Course:
    """Return the car's route at its point nearest to ``along`` [m]."""
    table = world.tables.course
    last = table.shape[-2] - 1
    index = jnp.clip(jnp.round(along / ROUTE_SPACING).astype(jnp.int32), 0, last)
    columns = look_up_row(table, scenario.map, scenario.route, index)
    at = Course(*columns[:5], *jnp.split(columns[5:], (len(POINTS),)))
    return at if scenario.script is None else replace(at, limit=jnp.minimum(at.limit, scenario.script.limit))


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
