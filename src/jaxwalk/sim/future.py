"""The future, which no real car can know: how near people will be to each place of the route if all of them go.

The speed limits at the same places stand beside it.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from jaxwalk.maps.routes import ROUTE_SPACING
from jaxwalk.sim import pedestrian
from jaxwalk.sim.everybody import for_everybody
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


def clearances(world: World, scenario: Scenario, state: State) -> Float[Array, "moment place *batch"]:
    """Return the distance from each place ahead to the nearest person at each moment to come, at most `FAR` [m].

    The simulator itself walks on with the scenario's own draws, so jaywalks that are not yet decided are known too.
    Everybody is assumed to go from now on, also people who wait now; but scripted people who wait for the car don't
    set out.
    """
    place_x, place_y = _places(world, scenario, state)
    go = jnp.ones(state.pedestrian.going.shape, bool)

    def stride(people: PedestrianState, _: None) -> tuple[PedestrianState, None]:
        return pedestrian.walk(world, scenario, people, go), None

    def moment(people: PedestrianState, _: None) -> tuple[PedestrianState, Array]:
        people, _ = jax.lax.scan(stride, people, None, length=STEPS)
        return people, _nearest(people.x, people.y, place_x, place_y)

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


def _places(world: World, scenario: Scenario, state: State) -> tuple[Array, Array]:
    """Return places of the route ahead of the car [m], ``(place, *batch)``; beyond its last point, that point."""
    maps, (along, point) = world.maps, _ahead(world, state)
    columns = (maps.route_x, maps.route_y, maps.route_cos, maps.route_sin)
    x, y, cos, sin = look_up_each(columns, scenario.map, scenario.route, point)
    beyond = jnp.clip(along - point * ROUTE_SPACING, -ROUTE_SPACING, ROUTE_SPACING)
    return x + cos * beyond, y + sin * beyond


def _nearest(x: Array, y: Array, place_x: Array, place_y: Array) -> Float[Array, "place *batch"]:
    """Return the distance from each place to the nearest person [m]; people are ``(ped, *batch)``."""

    def compare(person: tuple[Array, Array], nearest: Array) -> Array:
        return jnp.minimum(nearest, (place_x - person[0]) ** 2 + (place_y - person[1]) ** 2)

    return jnp.sqrt(for_everybody((x, y), compare, jnp.full(place_x.shape, FAR**2)))
