"""How pedestrians walk: along shortest paths, and straight across a roadway where they have decided to jaywalk."""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Int, Shaped

from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK, NO_CROSSING, LegKind
from jaxwalk.sim.geometry import inside
from jaxwalk.sim.lookup import look_up, look_up_each
from jaxwalk.sim.map_tables import unpack_hop
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import Leg, PedestrianState
from jaxwalk.sim.world import World


def place(world: World, scenario: Scenario) -> PedestrianState:
    """Return all pedestrians at their start waypoints, as if each had just finished a leg."""
    x, y = look_up_each((world.maps.node_x, world.maps.node_y), scenario.map, scenario.start)
    zero, none, no = jnp.zeros_like(x), jnp.zeros_like(scenario.start), jnp.zeros(x.shape, bool)
    leg = Leg(
        end_x=x, end_y=y, cos=zero, sin=zero, length=zero, kind=none, node=scenario.start, landing_x=zero,
        landing_y=zero, kerb_past_end=jnp.full_like(x, jnp.inf), crossing=none, decisions=none, goal=scenario.goals[0],
        arrivals=none,
    )  # fmt: skip
    people = PedestrianState(
        leg=leg, following=leg, planned=no, remaining=zero, going=~no, on_roadway=no, on_crosswalk=no
    )
    return _on_surface(world, scenario, people)


def walk(world: World, scenario: Scenario, people: PedestrianState, go: Bool[Array, "ped *batch"]) -> PedestrianState:
    """Make one step: people who go walk along their committed path at their own speed, and people who wait stand.

    The rest of a step after the end of a leg is carried into the next leg (but not over a second end). What follows a
    leg depends on nothing that happens during it, so it is computed for everybody at once whenever somebody needs it:
    in about a tenth of the steps.
    """
    stride = jnp.where(go, scenario.walking_speed(world) * world.rules.dt, 0)
    carry = stride - people.remaining
    finished = go & (carry >= 0)
    missing = (finished & ~people.planned).any()
    following = jax.lax.cond(missing, lambda: next_leg(world, scenario, people.leg), lambda: people.following)
    people = PedestrianState(
        leg=jax.tree.map(lambda new, old: jnp.where(finished, new, old), following, people.leg),
        following=following,
        planned=(people.planned | missing) & ~finished,
        remaining=jnp.where(finished, jnp.maximum(following.length - carry, 0), people.remaining - stride),
        going=go,
        on_roadway=people.on_roadway,
        on_crosswalk=people.on_crosswalk,
    )
    return _on_surface(world, scenario, people)


def _on_surface(world: World, scenario: Scenario, people: PedestrianState) -> PedestrianState:
    """Return the people with what they stand on, from the geometry of the map."""
    surfaces = (
        inside(world.maps.roads, scenario.map, people.x, people.y),
        inside(world.maps.crosswalks, scenario.map, people.x, people.y),
    )
    return eqx.tree_at(lambda p: (p.on_roadway, p.on_crosswalk), people, surfaces)


def velocity(world: World, scenario: Scenario, people: PedestrianState) -> tuple[Array, Array]:
    """Return the velocity along the leg [m/s]: zero for people who waited in the last step."""
    speed = jnp.where(people.going, scenario.walking_speed(world), 0)
    return speed * people.leg.cos, speed * people.leg.sin


def at_kerb(world: World, people: PedestrianState) -> Bool[Array, "ped *batch"]:
    """Return which pedestrians are on a sidewalk, and enter a roadway within ``kerb_distance`` of their path."""
    return (people.to_kerb > 0) & (people.to_kerb <= world.rules.kerb_distance)


def enters_roadway(people: PedestrianState) -> Bool[Array, "ped *batch"]:
    """Return which pedestrians are on a leg that leads into a roadway, so that they don't turn before it."""
    return people.leg.kerb_past_end < 0


def next_leg(world: World, scenario: Scenario, leg: Leg) -> Leg:
    """Return the leg that follows.

    A pedestrian at the point where its jaywalk begins goes across. All others continue along the graph: to the next
    node, or after a jaywalk to the node of the first edge. A crossing is decided (equation 1) when a pedestrian begins
    the last edge before a crosswalk; or at the crosswalk's landing, if it turns there.
    """
    begins, landed = leg.kind == LegKind.TO_ZONE, leg.kind == LegKind.ACROSS
    arrived = (leg.kind <= LegKind.CROSSWALK) & (leg.node == leg.goal)
    arrivals = leg.arrivals + arrived
    goal = jnp.where(arrived, _take(scenario.goals, arrivals), leg.goal)

    hop = unpack_hop(look_up(world.tables.hop, scenario.map, leg.node, goal))
    node = jnp.where(begins | landed, leg.node, hop.node)
    node_x, node_y = look_up_each((world.maps.node_x, world.maps.node_y), scenario.map, node)
    to_crosswalk = hop.to_midpoint & ~landed
    on_crosswalk = to_crosswalk | (hop.from_midpoint & ~landed)

    done = landed | ((leg.kind == LegKind.CROSSWALK) & ~hop.from_midpoint)
    crossing = jnp.where(done, NO_CROSSING, leg.crossing)
    side = jnp.where(landed & ~hop.to_midpoint, -1, hop.side)
    decided = (side >= 0) & (crossing == NO_CROSSING)
    jaywalk = decided & scenario.jaywalks(world, _take(scenario.jaywalk_draw, leg.decisions))
    way = _jaywalk(world, scenario, leg, goal, jnp.maximum(side, 0))

    end_x = jnp.where(begins, leg.landing_x, jnp.where(jaywalk, way.x, node_x))
    end_y = jnp.where(begins, leg.landing_y, jnp.where(jaywalk, way.y, node_y))
    dx, dy = end_x - leg.end_x, end_y - leg.end_y
    length = jnp.sqrt(dx * dx + dy * dy)
    by_crosswalk = way.landing_to_kerb + jnp.where(to_crosswalk, 0, length)
    no_longer = jnp.where(done, jnp.inf, leg.kerb_past_end)
    to_kerb = jnp.where(decided, jnp.where(jaywalk, way.to_kerb, by_crosswalk), no_longer)
    walks = jnp.where(jaywalk, LegKind.TO_ZONE, jnp.where(on_crosswalk, LegKind.CROSSWALK, LegKind.SIDEWALK))
    return Leg(
        end_x=end_x,
        end_y=end_y,
        cos=dx / jnp.maximum(length, 1e-6),
        sin=dy / jnp.maximum(length, 1e-6),
        length=length,
        kind=jnp.where(begins, LegKind.ACROSS, walks),
        node=jnp.where(jaywalk, way.node, node),
        landing_x=jnp.where(jaywalk, way.landing_x, leg.landing_x),
        landing_y=jnp.where(jaywalk, way.landing_y, leg.landing_y),
        kerb_past_end=to_kerb - length,
        crossing=jnp.where(decided, jnp.where(jaywalk, JAYWALK, CROSSWALK), crossing),
        decisions=leg.decisions + decided,
        goal=goal,
        arrivals=arrivals,
    )


class Jaywalk(NamedTuple):
    """A jaywalk from one side of a crosswalk; arrays ``(ped, *batch)``."""

    x: Array
    """Where it leaves the kerb line [m]."""
    y: Array
    landing_x: Array
    """Where it reaches the opposite kerb line [m]."""
    landing_y: Array
    to_kerb: Array
    """Path from here to the roadway [m]."""
    node: Array
    """First node after it."""
    landing_to_kerb: Array
    """From the crosswalk's landing to the roadway [m]."""


def _jaywalk(
    world: World, scenario: Scenario, leg: Leg, goal: Int[Array, "ped *batch"], side: Int[Array, "ped *batch"]
) -> Jaywalk:
    """Return the jaywalk that each pedestrian would make at a side, from the end of its leg.

    It begins uniformly in the part of the zone not yet passed (else in the whole zone), and is slanted toward the goal
    by at most 45 degrees within the opposite zone, so it is clear of crosswalks and junctions.
    """
    columns = world.tables.side
    of = dict(zip(columns, look_up_each(list(columns.values()), scenario.map, side), strict=True))
    here = (leg.end_x - of["x"]) * of["ux"] + (leg.end_y - of["y"]) * of["uy"]
    farthest = jnp.where(here > of["near"], jnp.minimum(here, of["far"]), of["far"])
    begin = of["near"] + (farthest - of["near"]) * _take(scenario.zone_draw, leg.decisions)

    opposite_x, opposite_y = of["x"] + of["across_x"], of["y"] + of["across_y"]
    goal_x, goal_y = look_up_each((world.maps.node_x, world.maps.node_y), scenario.map, goal)
    toward = (goal_x - opposite_x) * of["ux"] + (goal_y - opposite_y) * of["uy"]
    width = jnp.sqrt(of["across_x"] ** 2 + of["across_y"] ** 2)
    end = jnp.clip(jnp.clip(toward, begin - width, begin + width), of["far_near"], of["far_far"])
    slant = jnp.sqrt((end - begin) ** 2 + width * width) / jnp.maximum(width, 1e-6)

    near_landing = end <= look_up(world.tables.turn, scenario.map, side ^ 1, goal)
    return Jaywalk(
        x=of["x"] + begin * of["ux"],
        y=of["y"] + begin * of["uy"],
        landing_x=opposite_x + end * of["ux"],
        landing_y=opposite_y + end * of["uy"],
        to_kerb=jnp.abs(begin - here) + of["landing_to_kerb"] * slant,
        node=jnp.where(near_landing, of["far_landing"], of["far_outer"]).astype(jnp.int32),
        landing_to_kerb=of["landing_to_kerb"],
    )


def _take(table: Shaped[Array, "row ped *batch"], row: Array) -> Array:
    """Return each pedestrian's own entry of a table of the scenario."""
    return jnp.take_along_axis(table, row[None], axis=0, mode="promise_in_bounds")[0]
