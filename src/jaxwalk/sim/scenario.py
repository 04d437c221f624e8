"""A scenario holds all chance of an episode; the tables it draws from are in the map."""

from __future__ import annotations

import math

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, Key

from jaxwalk.maps import RoadMap
from jaxwalk.sim.config import SimConfig
from jaxwalk.sim.tables import look_up

TRAITS = 4
"""Traits of a pedestrian, each uniform in [0, 1]: jaywalking tendency, walking speed and two without effect."""


class Scenario(eqx.Module):
    """Everything that chance decides about one episode (batches: arrays ``(..., *batch)``)."""

    map: Int[Array, "*batch"]
    """Index of the map."""
    route: Int[Array, "*batch"]
    """Index of the car's route, which gives its start and its goal."""
    start: Int[Array, "ped *batch"]
    """The waypoint where each pedestrian starts."""
    traits: Float[Array, "trait ped *batch"]
    """Uniform in [0, 1]; the first is the jaywalking tendency, the second sets the walking speed."""
    goals: Int[Array, "goal ped *batch"]
    """The waypoints to walk to, one after the other."""
    jaywalk_draw: Float[Array, "crossing ped *batch"]
    """For each crossing to come: below tendency x multiplier, it is a jaywalk."""
    zone_draw: Float[Array, "crossing ped *batch"]
    """For each crossing to come: where in the jaywalk zone it would begin."""

    @property
    def jaywalking_tendency(self) -> Float[Array, "ped *batch"]:
        """The trait tau of equation 1."""
        return self.traits[0]

    def walking_speed(self, config: SimConfig) -> Float[Array, "ped *batch"]:
        """Each pedestrian's own speed [m/s]."""
        return config.slowest_walk + (config.fastest_walk - config.slowest_walk) * self.traits[1]


def table_sizes(config: SimConfig, *, shortest_crossing: float) -> tuple[int, int]:
    """How many goals and how many crossings the fastest pedestrian could need: (goals, crossings).

    It walks at most horizon x dt x top speed. Between two decisions lies at least one crossing, ``shortest_crossing``
    metres long. Goals are ``goal_spacing`` apart along the graph; a jaywalk is shorter, but no shorter than a crossing.
    """
    reach = config.horizon * config.dt * config.fastest_walk
    apart = min(config.goal_spacing, shortest_crossing)
    return 2 + math.floor(reach / apart), 2 + math.floor(reach / shortest_crossing)


def draw(
    maps: RoadMap, config: SimConfig, sizes: tuple[int, int], key: Key[Array, ""], like: Scenario | None = None
) -> Scenario:
    """Draw one scenario (no batch axes); ``sizes`` as from `table_sizes`. ``like``: with this one's map and route."""
    goals, crossings = sizes
    people = config.pedestrians
    rows = 1 + goals + TRAITS + 2 * crossings
    uniform = _uniform(key, 2 + rows * people)
    start_draw, goal_draws, traits, crossing_draws = jnp.split(
        uniform[2:].reshape(rows, people), (1, 1 + goals, 1 + goals + TRAITS)
    )
    map_index = jnp.floor(uniform[0] * maps.roads.shape[0]).astype(jnp.int32)
    routes = look_up(maps.route_count, map_index)
    route = jnp.minimum((uniform[1] * routes).astype(jnp.int32), routes - 1)
    if like is not None:
        map_index, route = like.map, like.route
    starts = look_up(maps.start_count, map_index, route)
    start = _choose(maps.start_choices, starts, (map_index, route), start_draw[0])

    def next_goal(node, draw):
        goal = _choose(maps.goal_choices, look_up(maps.goal_count, map_index, node), (map_index, node), draw)
        return goal, goal

    _, goal_table = jax.lax.scan(next_goal, start, goal_draws)
    jaywalk_draw, zone_draw = jnp.split(crossing_draws, 2)
    return Scenario(
        map=map_index,
        route=route,
        start=start,
        traits=traits,
        goals=goal_table,
        jaywalk_draw=jaywalk_draw,
        zone_draw=zone_draw,
    )


def _uniform(key: Key[Array, ""], count: int) -> Float[Array, " count"]:
    """Numbers in (0, 1), multiples of 2**-16 and half of that: two for each random word, which are what costs time."""
    words = jax.random.bits(key, (-(-count // 2),), jnp.uint32)
    halves = jnp.concatenate([words >> 16, words & 0xFFFF])[:count]
    return (halves.astype(jnp.float32) + 0.5) / 65536


def _choose(table: Array, count: Array, row: tuple[Array, ...], uniform: Array) -> Array:
    """One of the first ``count`` entries of a row of a choice table, by a number in [0, 1)."""
    column = jnp.minimum((uniform * count).astype(jnp.int32), count - 1)
    return look_up(table, *row, column)
