"""A scenario holds all random choices of the simulator in an episode (policies draw from keys of their own).

One that is drawn is a function of uniform numbers: a point of the unit cube. Scripts have scenarios too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.scipy.special import ndtr, ndtri
from jaxtyping import Array, Bool, Float, Int, Key

from jaxwalk.platforms import few_launches
from jaxwalk.sim.kept_points import KeptPoints
from jaxwalk.sim.lookup import look_up
from jaxwalk.sim.person_kind import begins
from jaxwalk.sim.script import Script
from jaxwalk.sim.walking_groups import groups_drawn, leaders
from jaxwalk.sim.world import World

TRAITS = 4
"""Traits of a pedestrian, each uniform in [0, 1]: jaywalking tendency, walking speed, and two for policies of
pedestrians; the simulator takes them only as a source of chance (`jaxwalk.sim.perception.chance`)."""
FINEST = 2.0**-17
"""Numbers closer to 0 or 1 than this count as if they were this far away, where they become normal scores."""
FAR_AWAY = -500.0
"""Both coordinates of people who aren't there [m]: nobody sees or meets them."""


class Scenario(eqx.Module):
    """All random choices of one episode; of a batch of them, arrays ``(..., *batch)``."""

    map: Int[Array, "*batch"]
    """Index of the map."""
    route: Int[Array, "*batch"]
    """Index of the car's route, which gives its start and its goal."""
    start: Int[Array, "ped *batch"]
    """The waypoint where each pedestrian starts."""
    traits: Float[Array, "trait ped *batch"]
    """Uniform in [0, 1]; the first decides the jaywalking tendency, the second the walking speed."""
    goals: Int[Array, "goal ped *batch"]
    """The waypoints to walk to, one after the other."""
    jaywalk_draw: Float[Array, "crossing ped *batch"]
    """For each crossing to come: whether it is a jaywalk (`Scenario.jaywalks`)."""
    zone_draw: Float[Array, "crossing ped *batch"]
    """For each crossing to come: where in the jaywalk zone it would begin."""
    parked: Bool[Array, "slot *batch"] | None = None
    """In which slots of the map (`jaxwalk.maps.RoadMap.slots`) a vehicle is parked; None where nobody ever parks."""
    earlier_draw: Float[Array, "earlier ped *batch"] | None = None
    """For each decision that the car saw before the episode: whether it was a jaywalk; None where it saw none."""
    leader: Int[Array, "ped *batch"] | None = None
    """The number of the leader of each pedestrian's group, its own if alone; None where nobody walks in groups."""
    absent: Bool[Array, "ped *batch"] | None = None
    """Who isn't there: an explanation of a failure leaves out those who don't matter. None: everybody is there."""
    script: Script | None = None
    """What car and people do by a script, in place of most of the above; None where everything is drawn."""

    def kind(self, world: World) -> Int[Array, "ped *batch"]:
        """Return the number in ``SimConfig.kinds`` of the kind that each pedestrian is of; 0 where there are none."""
        later = begins(world.rules.kinds)[1:]
        return sum((self.traits[0] >= begin for begin in later), jnp.zeros_like(self.start))

    def of_kind(self, world: World, numbers: Sequence[Any]) -> Float[Array, "ped *batch"]:
        """Return for each pedestrian the number of its kind. ``numbers``: one for each of ``SimConfig.kinds``."""
        own = jnp.full_like(self.traits[0], numbers[0])
        for begin, number in list(zip(begins(world.rules.kinds), numbers, strict=True))[1:]:
            own = jnp.where(self.traits[0] >= begin, number, own)
        return own

    def jaywalking_tendency(self, world: World) -> Float[Array, "ped *batch"]:
        """Return tau of equation 1: the first trait, or that of the person's kind."""
        kinds = world.rules.kinds
        return self.of_kind(world, [kind.tendency for kind in kinds]) if kinds else self.traits[0]

    def own_traits(self, world: World) -> Float[Array, "trait ped *batch"]:
        """Return the traits as people know them: with tau as the first one."""
        return self.traits if not world.rules.kinds else self.traits.at[0].set(self.jaywalking_tendency(world))

    def walking_speed(self, world: World) -> Float[Array, "ped *batch"]:
        """Return each pedestrian's own speed [m/s]."""
        if self.script is not None:
            return self.script.pace
        slowest, fastest = world.rules.slowest_walk, world.rules.fastest_walk
        if any(kind.walk for kind in world.rules.kinds):
            paces = [kind.walk or (slowest, fastest) for kind in world.rules.kinds]
            slowest, fastest = (self.of_kind(world, speeds) for speeds in zip(*paces, strict=True))
        return slowest + (fastest - slowest) * self.traits[1]

    def jaywalking_speed(self, world: World) -> Float[Array, "ped *batch"]:
        """Return each pedestrian's speed on the way across on a jaywalk [m/s]; who walks fast runs fast."""
        if self.script is not None:
            return self.script.pace
        usual = world.rules.slowest_walk, world.rules.fastest_walk
        paces = [kind.jaywalk or kind.walk or usual for kind in world.rules.kinds] or [usual]
        slowest, fastest = (self.of_kind(world, speeds) for speeds in zip(*paces, strict=True))
        return slowest + (fastest - slowest) * self.traits[1]

    def jaywalks(self, world: World, draw: Float[Array, "..."]) -> Bool[Array, "..."]:
        """Return which crossings are jaywalks (equation 1), by their ``jaywalk_draw``: ``(ped, *batch)`` or more."""
        return draw < self.jaywalking_tendency(world) * world.rules.jaywalk_multiplier

    def earlier_jaywalks(self, world: World) -> Int[Array, "ped *batch"]:
        """Return how many of the ``earlier_decisions`` of each person were jaywalks (equation 1)."""
        if self.earlier_draw is None:
            return jnp.zeros_like(self.start)
        return self.jaywalks(world, self.earlier_draw).sum(axis=0)


def without_people(maps: Int[Array, "*batch"], routes: Int[Array, "*batch"]) -> Scenario:
    """Return scenarios of these maps and routes in which there is nobody but the car, and nobody parks."""
    nobody = jnp.zeros((0, *maps.shape))
    none = nobody.astype(jnp.int32)
    return Scenario(
        map=maps, route=routes, start=none, traits=nobody[None], goals=none[None], jaywalk_draw=nobody[None],
        zone_draw=nobody[None],
    )  # fmt: skip


def draw(world: World, key: Key[Array, ""], like: Scenario | None = None, kept: KeptPoints | None = None) -> Scenario:
    """Draw one scenario (no batch axes). ``like``: keep its map and route; ``kept``: scenarios to draw from too."""
    if kept is None:
        return from_uniforms(world, uniforms(key, dimensions(world)), like)
    key, choice = jax.random.split(key)
    return from_uniforms(world, kept.mixed(choice, uniforms(key, dimensions(world))), like)


def dimensions(world: World) -> int:
    """Return how many uniform numbers a scenario is a function of."""
    return 2 + sum(_counts(world))


def uniforms(key: Key[Array, ""], count: int) -> Float[Array, " count"]:
    """Draw numbers in (0, 1).

    They are odd multiples of 2**-17, two from each random word, because it is random words that take time.
    """
    words = jax.random.bits(key, (-(-count // 2),), jnp.uint32)
    halves = jnp.concatenate([words >> 16, words & 0xFFFF])[:count]
    return (halves.astype(jnp.float32) + 0.5) / 65536


def from_uniforms(world: World, numbers: Float[Array, " count"], like: Scenario | None = None) -> Scenario:
    """Return the scenario at a point of the unit cube: `dimensions` numbers in [0, 1).

    The first two choose map and route. Then come the rows of a table with one column for each pedestrian: start, goals,
    traits, one row of jaywalk draws for each crossing, one of zone draws for each. With ``pace_correlation``, the
    second trait depends on the first one too. Then come those of parking slots, if anybody parks: a vehicle is in a
    slot if its number is below ``parked``. Then come those of earlier decisions. The last ones are of groups, if there
    are any: who follows somebody has that one's numbers, but its own last two traits and earlier decisions.

    Args:
        world: gives the tables to choose from.
        numbers: where in the cube.
        like: keep the map and the route of this scenario.
    """
    maps, correlation = world.maps, world.rules.pace_correlation
    of, leader = parts(world, numbers), None
    start_draw, goal_draws, traits, jaywalk_draw, zone_draw = of.start, of.goals, of.traits, of.jaywalk, of.zone
    if world.rules.grouped:
        leader = leaders(of.groups, world.rules.pedestrians, world.rules.grouped)
        start_draw, goal_draws, jaywalk_draw, zone_draw = (
            rows[..., leader] for rows in (start_draw, goal_draws, jaywalk_draw, zone_draw)
        )
        traits = traits.at[:2].set(traits[:2, leader])
    if correlation:
        traits = traits.at[1].set(correlated(traits[0], traits[1], correlation))
    map_index = jnp.floor(numbers[0] * world.map_count).astype(jnp.int32)
    routes = look_up(maps.route_count, map_index)
    route = jnp.minimum((numbers[1] * routes).astype(jnp.int32), routes - 1)
    if like is not None:
        map_index, route = like.map, like.route
    starts = look_up(maps.start_count, map_index, route)
    start = _choose(maps.start_choices, starts, (map_index, route), start_draw)

    def next_goal(node, draw):
        goal = _choose(maps.goal_choices, look_up(maps.goal_count, map_index, node), (map_index, node), draw)
        return goal, goal

    _, goals = jax.lax.scan(next_goal, start, goal_draws, unroll=len(goal_draws) if few_launches() else 1)
    return Scenario(
        map=map_index,
        route=route,
        start=start,
        traits=traits,
        goals=goals,
        jaywalk_draw=jaywalk_draw,
        zone_draw=zone_draw,
        parked=_parked(world, map_index, of.parked) if world.slots else None,
        earlier_draw=of.earlier if len(of.earlier) else None,
        leader=leader,
    )


class Parts(NamedTuple):
    """Uniform numbers by what they decide about; arrays of any library."""

    street: Any
    """Map and route, ``(2,)``."""
    start: Any
    """``(ped,)``"""
    goals: Any
    """``(goal, ped)``"""
    traits: Any
    """``(trait, ped)``"""
    jaywalk: Any
    """``(crossing, ped)``"""
    zone: Any
    """``(crossing, ped)``"""
    parked: Any
    """``(slot,)``"""
    earlier: Any
    """``(decision, ped)``"""
    groups: Any
    """``(group,)``"""


def parts(world: World, numbers: Any) -> Parts:
    """Return `dimensions` numbers by what they decide about, in the order of `from_uniforms`.

    Of ``numpy.arange(dimensions(world))`` it is where each of them is.
    """
    people, of_goals = world.rules.pedestrians, world.goals
    ends = 2 + np.cumsum(_counts(world))
    table = numbers[2 : ends[0]].reshape(-1, people)
    rows = np.cumsum([1, of_goals, TRAITS, world.crossings, world.crossings])
    return Parts(
        street=numbers[:2],
        start=table[0],
        goals=table[rows[0] : rows[1]],
        traits=table[rows[1] : rows[2]],
        jaywalk=table[rows[2] : rows[3]],
        zone=table[rows[3] : rows[4]],
        parked=numbers[ends[0] : ends[1]],
        earlier=numbers[ends[1] : ends[2]].reshape(-1, people),
        groups=numbers[ends[2] : ends[3]],
    )


def correlated(
    one: Float[Array, "*batch"], other: Float[Array, "*batch"], correlation: float
) -> Float[Array, "*batch"]:
    """Return a uniform number that depends on two independent ones: as the other one, correlated with the first one.

    It has the Gaussian copula with this correlation of the normal scores, so its rank correlation with ``one`` is
    6 / pi asin(correlation / 2).
    """
    first, second = (ndtri(jnp.clip(number, FINEST, 1 - FINEST)) for number in (one, other))
    return ndtr(correlation * first + math.sqrt(1 - correlation**2) * second)


def _counts(world: World) -> tuple[int, int, int, int]:
    """Return how many uniform numbers are of people, parking slots, earlier decisions, and groups."""
    people = world.rules.pedestrians
    groups = groups_drawn(people) if world.rules.grouped else 0
    rows = 1 + world.goals + TRAITS + 2 * world.crossings
    return rows * people, world.slots, world.rules.earlier_decisions * people, groups


def _parked(world: World, map_index: Array, of_slots: Float[Array, " slot"]) -> Bool[Array, " slot"]:
    """Return the slots in which a vehicle is parked; never one that only pads the map."""
    real = jnp.arange(world.slots) < look_up(world.maps.slot_count, map_index)
    return real & (of_slots < world.rules.parked)


def _choose(table: Array, count: Array, row: tuple[Array, ...], uniform: Array) -> Array:
    """Return one of the first ``count`` entries of a row of a choice table, chosen by a number in [0, 1)."""
    column = jnp.minimum((uniform * count).astype(jnp.int32), count - 1)
    return look_up(table, *row, column)
