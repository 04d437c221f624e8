"""How pedestrians walk: along shortest paths, and straight across a roadway where they have decided to jaywalk."""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Shaped

from jaxwalk.platforms import few_launches
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK, NO_CROSSING, LegKind
from jaxwalk.sim.free_walk import pace_of_script, stand, walk_freely
from jaxwalk.sim.jaywalk import NOWHERE, Zone, into_gap, jaywalk_from, zone_of
from jaxwalk.sim.lookup import look_up, look_up_each
from jaxwalk.sim.map_tables import Hop, unpack_hop
from jaxwalk.sim.scenario import FAR_AWAY, Scenario
from jaxwalk.sim.state import Leg, PedestrianState
from jaxwalk.sim.walking_groups import behind
from jaxwalk.sim.world import World


def place(world: World, scenario: Scenario) -> PedestrianState:
    """Return all pedestrians at their start waypoints, as if each had just finished a leg.

    Who follows somebody starts later, by as many metres as it walks behind. Scripted people stand where their way
    begins.
    """
    if scenario.script is not None:
        return stand(world, scenario)
    x, y = look_up_each((world.maps.node_x, world.maps.node_y), scenario.map, scenario.start)
    if scenario.absent is not None:
        x, y = (jnp.where(scenario.absent, FAR_AWAY, place) for place in (x, y))
    zero, none, no = jnp.zeros_like(x), jnp.zeros_like(scenario.start), jnp.zeros(x.shape, bool)
    leg = Leg(
        end_x=x, end_y=y, cos=zero, sin=zero, length=zero, kind=none, node=scenario.start, side=none, begin=zero,
        road_end=zero, kerb_past_end=jnp.full_like(x, jnp.inf), crossing=none, decisions=none, goal=scenario.goals[0],
        arrivals=none,
    )  # fmt: skip
    return PedestrianState(
        leg=leg, following=leg, planned=no, remaining=zero if scenario.leader is None else behind(scenario.leader),
        going=~no, on_roadway=no, on_crosswalk=no,
    )  # fmt: skip


def walk(world: World, scenario: Scenario, people: PedestrianState, go: Bool[Array, "ped *batch"]) -> PedestrianState:
    """Make one step: people who go walk along their committed path at their own pace, and people who wait stand.

    The rest of a step after the end of a leg is carried into the next leg (but not over a second end). What follows a
    leg depends on nothing that happens during it, so it is computed for everybody at once whenever somebody needs it:
    in about a tenth of the steps. To ask whether somebody does makes a GPU's host wait: there it is computed in every
    step, and never kept. Scripted people walk as `jaxwalk.sim.free_walk` says.
    """
    if scenario.script is not None:
        return walk_freely(world, scenario, people, go)
    if scenario.absent is not None:
        go = go & ~scenario.absent
    stride = jnp.where(go, pace(world, scenario, people) * world.rules.dt, 0)
    carry = stride - people.remaining
    finished = go & (carry >= 0)
    missing = None if few_launches() else (finished & ~people.planned).any()
    if missing is None:
        following = next_leg(world, scenario, people.leg)
    else:
        following = jax.lax.cond(missing, lambda: next_leg(world, scenario, people.leg), lambda: people.following)
    people = PedestrianState(
        leg=jax.tree.map(lambda new, old: jnp.where(finished, new, old), following, people.leg),
        following=people.following if missing is None else following,
        planned=jnp.zeros_like(people.planned) if missing is None else (people.planned | missing) & ~finished,
        remaining=jnp.where(finished, jnp.maximum(following.length - carry, 0), people.remaining - stride),
        going=go,
        on_roadway=people.on_roadway,
        on_crosswalk=people.on_crosswalk,
    )
    on_roadway = (people.to_kerb < 0) & (people.remaining > people.leg.road_end)
    on_crosswalk = on_roadway & (people.leg.kind == LegKind.CROSSWALK)
    return eqx.tree_at(lambda p: (p.on_roadway, p.on_crosswalk), people, (on_roadway, on_crosswalk))


def pace(world: World, scenario: Scenario, people: PedestrianState) -> Float[Array, "ped *batch"]:
    """Return the speed of people who go [m/s]: their own walking speed, or on a jaywalk that of their kind."""
    if scenario.script is not None:
        return pace_of_script(scenario.script, people)
    own = scenario.walking_speed(world)
    if not any(kind.jaywalk for kind in world.rules.kinds):
        return own
    return jnp.where(people.leg.kind == LegKind.ACROSS, scenario.jaywalking_speed(world), own)


def velocity(world: World, scenario: Scenario, people: PedestrianState) -> tuple[Array, Array]:
    """Return the velocity along the leg [m/s]: zero for people who waited in the last step."""
    speed = jnp.where(people.going, pace(world, scenario, people), 0)
    return speed * people.leg.cos, speed * people.leg.sin


def at_kerb(world: World, people: PedestrianState) -> Bool[Array, "ped *batch"]:
    """Return which pedestrians are on a sidewalk, and enter a roadway within ``kerb_distance`` of their path."""
    return (people.to_kerb > 0) & (people.to_kerb <= world.rules.kerb_distance)


def enters_roadway(people: PedestrianState) -> Bool[Array, "ped *batch"]:
    """Return which pedestrians are on a leg that leads into a roadway, so that they don't turn before it."""
    return people.leg.kerb_past_end < 0


def next_leg(world: World, scenario: Scenario, leg: Leg) -> Leg:
    """Return the leg that follows.

    A pedestrian at the point where its jaywalk begins goes across. One that is on its way there follows the line of its
    zone. All others continue along the graph: to the next node, or after a jaywalk to the node of the first edge.
    """
    begins, landed = leg.kind == LegKind.TO_ZONE, leg.kind == LegKind.ACROSS
    arrived = (leg.kind <= LegKind.CROSSWALK) & (leg.node == leg.goal)
    arrivals = leg.arrivals + arrived
    goal = jnp.where(arrived, _take(scenario.goals, arrivals), leg.goal)
    hop = unpack_hop(look_up(world.tables.hop, scenario.map, leg.node, goal))
    choice = _choose(world, scenario, leg, hop)
    zone, seeks = choice.zone, choice.seeks
    way = jaywalk_from(world, scenario, choice.side, zone, choice.begin, goal)

    place, begin_first = zone.next_node(choice.begin)
    at_begin = seeks & begin_first
    along = look_up(world.maps.zone_node, scenario.map, choice.side, place)
    onward = jnp.where(landed, leg.node, hop.node)
    node = jnp.where(begins, way.node, jnp.where(seeks, along, onward))
    nodes = (world.maps.node_x, world.maps.node_y, world.maps.node_clear)
    node_x, node_y, clear = look_up_each(nodes, scenario.map, node)
    end_x = jnp.where(begins, way.landing_x, jnp.where(at_begin, way.x, node_x))
    end_y = jnp.where(begins, way.landing_y, jnp.where(at_begin, way.y, node_y))
    dx, dy = end_x - leg.end_x, end_y - leg.end_y
    length = jnp.sqrt(dx * dx + dy * dy)

    on_crosswalk = (hop.to_midpoint | hop.from_midpoint) & ~landed & ~seeks
    clear_here = look_up(world.maps.node_clear, scenario.map, leg.node)
    no_longer = jnp.where(choice.done, jnp.inf, leg.kerb_past_end)
    to_kerb = jnp.where(choice.decided, zone.clear + zone.to_landing(length), no_longer)
    to_kerb = jnp.where(on_crosswalk & (clear_here > 0), clear_here, to_kerb)  # from a landing, or from an island
    to_begin = jnp.where(begins, 0, zone.to_place(choice.begin, way.piece, length))
    to_kerb = jnp.where(begins | seeks, to_begin + way.enter, to_kerb)
    walks = jnp.where(at_begin, LegKind.TO_ZONE, jnp.where(on_crosswalk, LegKind.CROSSWALK, LegKind.SIDEWALK))
    divisor = jnp.maximum(length, 1e-6)
    return Leg(
        end_x=end_x, end_y=end_y, cos=dx / divisor, sin=dy / divisor, length=length,
        kind=jnp.where(begins, LegKind.ACROSS, walks), node=node, side=choice.side, begin=choice.begin,
        road_end=jnp.where(begins, way.leave, jnp.where(clear > 0, clear, -1)), kerb_past_end=to_kerb - length,
        crossing=choice.crossing, decisions=leg.decisions + (choice.decided & zone.exists), goal=goal,
        arrivals=arrivals,
    )  # fmt: skip


class _Choice(NamedTuple):
    """Who crosses where; arrays ``(ped, *batch)``."""

    done: Array
    """A crossing lies behind."""
    decided: Array
    """A crossing is decided now."""
    seeks: Array
    """It is on its way to where its jaywalk begins."""
    crossing: Array
    side: Array
    begin: Array
    zone: Zone
    """The zone at that side."""


def _choose(world: World, scenario: Scenario, leg: Leg, hop: Hop) -> _Choice:
    """Decide about crossings (equation 1).

    People decide when they begin the last edge before a crossing; along a crossing's zone, when they begin to follow
    its line towards the crossing; and at the landing, if only there they turn to the crossing.
    """
    begins, landed = leg.kind == LegKind.TO_ZONE, leg.kind == LegKind.ACROSS
    done = landed | ((leg.kind == LegKind.CROSSWALK) & ~hop.from_midpoint)
    crossing = jnp.where(done, NO_CROSSING, leg.crossing)
    offered = jnp.where(landed & ~hop.to_midpoint, -1, hop.side)
    decided = (offered >= 0) & (crossing == NO_CROSSING)
    side = jnp.where(decided, offered, leg.side)
    zone = zone_of(world, scenario, leg, side)
    begin = into_gap(world, scenario, side, zone.choose(_take(scenario.zone_draw, leg.decisions)))
    jaywalk = decided & zone.exists & scenario.jaywalks(world, _take(scenario.jaywalk_draw, leg.decisions))
    return _Choice(
        done=done,
        decided=decided,
        seeks=jaywalk | ((crossing == JAYWALK) & ~begins),
        crossing=jnp.where(decided, jnp.where(jaywalk, JAYWALK, CROSSWALK), crossing),
        side=side,
        begin=jnp.where(decided, jnp.where(zone.exists, begin, NOWHERE), leg.begin),
        zone=zone,
    )


def _take(table: Shaped[Array, "row ped *batch"], row: Array) -> Array:
    """Return each pedestrian's own entry of a table of the scenario."""
    return jnp.take_along_axis(table, row[None], axis=0, mode="promise_in_bounds")[0]
