"""The future, which no real car can know: how near people will be to each place of the route if all of them go.

The speed limits at the same places stand beside it.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.maps.routes import ROUTE_SPACING
from jaxwalk.sim import pedestrian
from jaxwalk.sim.events import to_rectangle
from jaxwalk.sim.everybody import for_everybody
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.lookup import look_up, look_up_each
from jaxwalk.sim.manoeuvres import FAR
from jaxwalk.sim.map_tables import LIMIT
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import PedestrianState, State
from jaxwalk.sim.world import World

MOMENTS, STEPS = 48, 2
"""The future is shown at 48 moments, 2 steps apart: 9.6 s with steps of 0.1 s."""
PLACES, SPACING = 161, 0.5
"""Each moment shows 161 places of the route, 0.5 m apart: the car's own, and 80 m ahead, which is enough for 9.6 s."""


class Places(NamedTuple):
    """Places of a route; arrays ``(place, *batch)``."""

    x: Array
    """Position [m]."""
    y: Array
    cos: Array
    """The route's direction."""
    sin: Array


def clearances(world: World, scenario: Scenario, state: State) -> Float[Array, "moment place *batch"]:
    """Return the distance from a car at each place ahead to the nearest person at each moment to come [m].

    By the world's contact it is the distance from the car's centre, or from its rectangle (0 inside) if that faces
    along the route, to the person's centre; at most `FAR`. The simulator itself walks on with the scenario's own draws,
    so jaywalks that are not yet decided are known too. Everybody is assumed to go from now on, also who waits now; but
    scripted people who wait for the car don't set out.
    """
    nearest = _from_centre if world.rules.contact == "disc" else partial(_from_rectangle, world)
    places = _places(world, scenario, state)
    go = jnp.ones(state.pedestrian.going.shape, bool)

    def stride(people: PedestrianState, _: None) -> tuple[PedestrianState, None]:
        return pedestrian.walk(world, scenario, people, go), None

    def moment(people: PedestrianState, _: None) -> tuple[PedestrianState, Array]:
        people, _ = jax.lax.scan(stride, people, None, length=STEPS)
        return people, nearest((people.x, people.y), places)

    return jax.lax.scan(moment, state.pedestrian, None, length=MOMENTS)[1]


def limits(world: World, scenario: Scenario, state: State) -> Float[Array, "place *batch"]:
    """Return the car's top speed at each place ahead [m/s]: of the lane, of the bend, and its own."""
    _, point = _ahead(world, state)
    limit = look_up(world.tables.course, scenario.map, scenario.route, point, jnp.int32(LIMIT))
    limit = limit if scenario.script is None else jnp.minimum(limit, scenario.script.limit)
    return jnp.minimum(limit, world.rules.max_speed)


def _ahead(world: World, state: State) -> tuple[Array, Array]:
    """Return the places ahead as metres along the route and as its nearest points, ``(place, *batch)``."""
    along = state.vehicle.along + (jnp.arange(PLACES) * SPACING).reshape(-1, *(1,) * state.step.ndim)
    last = world.maps.route_x.shape[-1] - 1
    return along, jnp.clip(jnp.round(along / ROUTE_SPACING).astype(jnp.int32), 0, last)


def _places(world: World, scenario: Scenario, state: State) -> Places:
    """Return places of the route ahead of the car; beyond its last point, that point."""
    maps, (along, point) = world.maps, _ahead(world, state)
    columns = (maps.route_x, maps.route_y, maps.route_cos, maps.route_sin)
    x, y, cos, sin = look_up_each(columns, scenario.map, scenario.route, point)
    beyond = jnp.clip(along - point * ROUTE_SPACING, -ROUTE_SPACING, ROUTE_SPACING)
    return Places(x + cos * beyond, y + sin * beyond, cos, sin)


def _from_centre(people: tuple[Array, Array], places: Places) -> Float[Array, "place *batch"]:
    """Return the distance from each place to the nearest person [m]; people are ``(ped, *batch)``."""

    def compare(person: tuple[Array, Array], nearest: Array) -> Array:
        return jnp.minimum(nearest, (places.x - person[0]) ** 2 + (places.y - person[1]) ** 2)

    return jnp.sqrt(for_everybody(people, compare, jnp.full(places.x.shape, FAR**2)))


def _from_rectangle(world: World, people: tuple[Array, Array], places: Places) -> Float[Array, "place *batch"]:
    """Return the distance from a car's rectangle at each place to the nearest person [m]."""
    length, width = world.rules.car_length, world.rules.car_width

    def compare(person: tuple[Array, Array], nearest: Array) -> Array:
        ahead, left = to_frame(person[0] - places.x, person[1] - places.y, places.cos, places.sin)
        return jnp.minimum(nearest, to_rectangle(ahead, left, length, width))

    return for_everybody(people, compare, jnp.full(places.x.shape, FAR))
