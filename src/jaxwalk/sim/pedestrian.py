"""How pedestrians walk: scripted shortest ways, and jaywalks that are decided once per crossing and then kept."""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from jaxwalk.maps import RoadMap
from jaxwalk.sim.config import SimConfig
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import PedestrianState
from jaxwalk.sim.tables import WalkTables, inside, look_up, unpack_hop
from jaxwalk.sim.trajectory import CROSSWALK, JAYWALK, NO_CROSSING

SIDEWALK, ON_CROSSWALK, TO_ZONE, ACROSS = 0, 1, 2, 3
"""Kinds of leg: along an edge of the graph (on a sidewalk, or half a crosswalk), to the point where a jaywalk begins,
and from there straight across the roadway."""


class Leg(NamedTuple):
    """Where a pedestrian that has finished a leg goes next; arrays ``(ped, *batch)``."""

    end_x: Array
    end_y: Array
    leg: Array
    node: Array
    landing_x: Array
    landing_y: Array
    to_kerb: Array
    crossing: Array
    decided: Array


def place(maps: RoadMap, scenario: Scenario) -> PedestrianState:
    """Everybody at their start waypoint, as at the end of a leg."""
    x = look_up(maps.node_x, scenario.map, scenario.start)
    y = look_up(maps.node_y, scenario.map, scenario.start)
    zero, none, no = jnp.zeros_like(x), jnp.zeros_like(scenario.start), jnp.zeros(x.shape, bool)
    return PedestrianState(
        end_x=x, end_y=y, cos=zero, sin=zero, remaining=zero, leg=none, node=scenario.start,
        landing_x=zero, landing_y=zero, to_kerb=jnp.full_like(x, jnp.inf), crossing=none, decisions=none,
        goal=scenario.goals[0], arrivals=none, going=~no, on_roadway=no, on_crosswalk=no,
    )  # fmt: skip


def walk(
    maps: RoadMap, tables: WalkTables, config: SimConfig, multiplier: Float[Array, ""], scenario: Scenario,
    people: PedestrianState, go: Bool[Array, "ped *batch"],
) -> PedestrianState:  # fmt: skip
    """One step: who goes moves along the committed path at their own speed; who waits stands.

    What is left of the step at the end of a leg is carried into the next. The direction, the goal and the decision
    about a crossing change only there, so all chance is looked up in the scenario at that moment.
    """
    stride = jnp.where(go, scenario.walking_speed(config) * config.dt, 0)
    carry = stride - people.remaining
    finished = go & (carry >= 0)

    arrived = finished & (people.leg <= ON_CROSSWALK) & (people.node == people.goal)
    arrivals = people.arrivals + arrived
    goal = jnp.where(arrived, _take(scenario.goals, arrivals), people.goal)

    new = _next_leg(maps, tables, multiplier, scenario, people, goal)
    dx, dy = new.end_x - people.end_x, new.end_y - people.end_y
    length = jnp.sqrt(dx * dx + dy * dy)
    scale = 1 / jnp.maximum(length, 1e-6)

    def update(then, now):
        return jnp.where(finished, then, now)

    moved = eqx.tree_at(
        lambda p: (p.end_x, p.end_y, p.cos, p.sin, p.remaining, p.leg, p.node, p.landing_x, p.landing_y, p.to_kerb,
                   p.crossing, p.decisions, p.goal, p.arrivals, p.going),
        people,
        (update(new.end_x, people.end_x), update(new.end_y, people.end_y),
         update(dx * scale, people.cos), update(dy * scale, people.sin),
         update(length - carry, people.remaining - stride), update(new.leg, people.leg), update(new.node, people.node),
         update(new.landing_x, people.landing_x), update(new.landing_y, people.landing_y),
         update(new.to_kerb - carry, people.to_kerb - stride), update(new.crossing, people.crossing),
         people.decisions + (finished & new.decided), goal, arrivals, go),
    )  # fmt: skip
    return on_surface(maps, scenario, moved)


def on_surface(maps: RoadMap, scenario: Scenario, people: PedestrianState) -> PedestrianState:
    """Note where everybody stands, by the geometry of the map."""
    surfaces = (
        inside(maps.roads, scenario.map, people.x, people.y),
        inside(maps.crosswalks, scenario.map, people.x, people.y),
    )
    return eqx.tree_at(lambda p: (p.on_roadway, p.on_crosswalk), people, surfaces)


def velocity(config: SimConfig, scenario: Scenario, people: PedestrianState) -> tuple[Array, Array]:
    """Velocity in the last step [m/s]: zero for who waited (and before the first step)."""
    speed = jnp.where(people.going, scenario.walking_speed(config), 0)
    return speed * people.cos, speed * people.sin


def at_kerb(config: SimConfig, people: PedestrianState) -> Bool[Array, "ped *batch"]:
    """On a sidewalk, the committed path enters a roadway within ``kerb_distance``."""
    return (people.to_kerb > 0) & (people.to_kerb <= config.kerb_distance)


def _next_leg(
    maps: RoadMap, tables: WalkTables, multiplier: Float[Array, ""], scenario: Scenario, people: PedestrianState,
    goal: Float[Array, "ped *batch"],
) -> Leg:  # fmt: skip
    """What follows the current leg, for everybody (used only where the leg is finished).

    Someone who begins a jaywalk goes across; everybody else continues along the graph: to the next node, or, from where
    a jaywalk landed, to the node of the first edge. Leaving for the last edge before a crosswalk (or its landing, for who
    turns there) is where the crossing is decided: equation 1.
    """
    hop = unpack_hop(look_up(tables.hop, scenario.map, people.node, goal))
    begins, landed = people.leg == TO_ZONE, people.leg == ACROSS
    node = jnp.where(begins | landed, people.node, hop.node)
    node_x, node_y = look_up(maps.node_x, scenario.map, node), look_up(maps.node_y, scenario.map, node)
    to_crosswalk = hop.to_midpoint & ~landed
    on_crosswalk = to_crosswalk | (hop.from_midpoint & ~landed)

    left = landed | ((people.leg == ON_CROSSWALK) & ~hop.from_midpoint)
    crossing = jnp.where(left, NO_CROSSING, people.crossing)
    side = jnp.where(landed & ~hop.to_midpoint, -1, hop.side)
    decided = (side >= 0) & (crossing == NO_CROSSING)
    probability = scenario.jaywalking_tendency * multiplier
    jaywalk = decided & (_take(scenario.jaywalk_draw, people.decisions) < probability)

    way = _jaywalk(maps, tables, scenario, people, goal, jnp.maximum(side, 0))
    edge = jnp.sqrt((node_x - people.end_x) ** 2 + (node_y - people.end_y) ** 2)
    to_kerb = jnp.where(left, jnp.inf, people.to_kerb - people.remaining)
    by_crosswalk = way.kerb + jnp.where(to_crosswalk, 0, edge)
    return Leg(
        end_x=jnp.where(begins, people.landing_x, jnp.where(jaywalk, way.x, node_x)),
        end_y=jnp.where(begins, people.landing_y, jnp.where(jaywalk, way.y, node_y)),
        leg=jnp.where(
            begins, ACROSS, jnp.where(jaywalk, TO_ZONE, jnp.where(on_crosswalk, ON_CROSSWALK, SIDEWALK))
        ),
        node=jnp.where(jaywalk, way.node, node),
        landing_x=jnp.where(jaywalk, way.landing_x, people.landing_x),
        landing_y=jnp.where(jaywalk, way.landing_y, people.landing_y),
        to_kerb=jnp.where(decided, jnp.where(jaywalk, way.to_kerb, by_crosswalk), to_kerb),
        crossing=jnp.where(decided, jnp.where(jaywalk, JAYWALK, CROSSWALK), crossing),
        decided=decided,
    )


class Jaywalk(NamedTuple):
    """A jaywalk from one side of a crosswalk; arrays ``(ped, *batch)``."""

    x: Array
    """Where it leaves the kerb line [m]."""
    y: Array
    landing_x: Array
    """Where it reaches the opposite one [m]."""
    landing_y: Array
    to_kerb: Array
    """Path from here to the roadway [m]."""
    node: Array
    """First node after it."""
    kerb: Array
    """From the crosswalk's landing to the roadway [m]."""


def _jaywalk(maps, tables, scenario, people, goal, side) -> Jaywalk:
    """The jaywalk that someone at the end of a leg would make at a side.

    It begins uniformly in the part of the zone not yet passed (else in the whole zone), and is slanted toward the goal
    by at most 45 degrees within the opposite zone, so it is clear of crosswalks and junctions.
    """
    of = {name: look_up(column, scenario.map, side) for name, column in tables.side.items()}
    here = (people.end_x - of["x"]) * of["ux"] + (people.end_y - of["y"]) * of["uy"]
    farthest = jnp.where(here > of["near"], jnp.minimum(here, of["far"]), of["far"])
    begin = of["near"] + (farthest - of["near"]) * _take(scenario.zone_draw, people.decisions)

    opposite_x, opposite_y = of["x"] + of["across_x"], of["y"] + of["across_y"]
    goal_x, goal_y = look_up(maps.node_x, scenario.map, goal), look_up(maps.node_y, scenario.map, goal)
    toward = (goal_x - opposite_x) * of["ux"] + (goal_y - opposite_y) * of["uy"]
    width = jnp.sqrt(of["across_x"] ** 2 + of["across_y"] ** 2)
    end = jnp.clip(jnp.clip(toward, begin - width, begin + width), of["far_near"], of["far_far"])
    slant = jnp.sqrt((end - begin) ** 2 + width * width) / jnp.maximum(width, 1e-6)

    near_landing = end <= look_up(tables.turn, scenario.map, side ^ 1, goal)
    return Jaywalk(
        x=of["x"] + begin * of["ux"],
        y=of["y"] + begin * of["uy"],
        landing_x=opposite_x + end * of["ux"],
        landing_y=opposite_y + end * of["uy"],
        to_kerb=jnp.abs(begin - here) + of["kerb"] * slant,
        node=jnp.where(near_landing, of["far_landing"], of["far_outer"]).astype(jnp.int32),
        kerb=of["kerb"],
    )


def _take(table: Float[Array, "row ped *batch"], row: Array) -> Array:
    """Each pedestrian's own entry of a table of the scenario."""
    return jnp.take_along_axis(table, row[None], axis=0, mode="promise_in_bounds")[0]
