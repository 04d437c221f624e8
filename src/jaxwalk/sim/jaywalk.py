"""Jaywalks: where on the line beside a crossing they begin, and the way across.

A crossing has two sides. Each has a landing, the node of the sidewalks where the crosswalk begins, and beside it a
zone: the line, of one piece or several, from which people jaywalk. On a crosswalk people walk two edges, which meet at
its midpoint.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from jaxwalk.sim.lookup import look_up, look_up_each, look_up_row
from jaxwalk.sim.map_tables import SIDE_COLUMNS, ZONE_COLUMNS
from jaxwalk.sim.parked_gaps import COLUMNS, NO_SLOT
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.state import Leg
from jaxwalk.sim.world import World

ON_LINE = 0.05
"""Who is this close to the line of a zone's first piece, or to its continuation, can follow it straight [m]."""
SAME = 1e-3
"""Places that differ by less are equal, in pieces of a zone's line."""
OFF = -1000.0
"""The place of somebody who isn't on the line of the zone: the way there leads over the landing."""
NOWHERE = -1.0
"""Stands for the place where a jaywalk begins where there is no zone."""


class LinePiece(NamedTuple):
    """A piece of a zone's line (`jaxwalk.sim.map_tables.ZONE_COLUMNS`)."""

    number: Array
    x: Array
    y: Array
    dx: Array
    dy: Array
    kerb: Array

    def at(self, place: Array) -> tuple[Array, Array]:
        """Return the point at a place [m]."""
        share = place - self.number
        return self.x + share * self.dx, self.y + share * self.dy

    def to_kerb(self, dx: Array, dy: Array) -> Array:
        """Return how far a way across (dx, dy) is on this side's sidewalk [m]."""
        across = jnp.abs(self.dx * dy - self.dy * dx) / jnp.sqrt(jnp.maximum(self.dx**2 + self.dy**2, 1e-6))
        return self.kerb * jnp.sqrt(dx * dx + dy * dy) / jnp.maximum(across, 1e-6)


def line_of(world: World, scenario: Scenario, side: Int[Array, "ped *batch"]) -> Callable[[Array], LinePiece]:
    """Return a function that gives the piece of a side's line that holds a place; a single one is looked up once."""
    columns = [world.tables.zone[name] for name in ZONE_COLUMNS]
    pieces = columns[0].shape[-1]

    def piece_at(place: Array) -> LinePiece:
        number = jnp.clip(jnp.floor(place).astype(jnp.int32), 0, pieces - 1)
        return LinePiece(number, *look_up_each(columns, scenario.map, side, number))

    if pieces > 1:
        return piece_at
    number = jnp.zeros_like(side)
    single = LinePiece(number, *look_up_each(columns, scenario.map, side, number))
    return lambda _: single


class Zone(NamedTuple):
    """A side of a crossing, as somebody sees it at the end of a leg. A place is a number of pieces from the landing."""

    here: Float[Array, "ped *batch"]
    """The place of that end; below 0 before the landing."""
    near: Float[Array, "ped *batch"]
    """Where the zone begins."""
    far: Float[Array, "ped *batch"]
    """Where it ends."""
    walk: Float[Array, "ped *batch"]
    """From that end along the line to the landing [m], where it is a node of the line."""
    clear: Float[Array, "ped *batch"]
    """From the landing along the crossing to the roadway [m]."""
    piece: Float[Array, "ped *batch"]
    """Length of a piece, measured half-way between this side's line and the opposite side's [m]."""
    line: Callable[[Array], LinePiece]
    """Gives the piece that holds a place."""

    @property
    def exists(self) -> Bool[Array, "ped *batch"]:
        """Whether people may jaywalk here."""
        return self.far > self.near

    def choose(self, draw: Float[Array, "ped *batch"]) -> Float[Array, "ped *batch"]:
        """Return where a jaywalk begins: uniformly in the part of the zone not yet passed, else in the whole zone."""
        farthest = jnp.where(self.here > self.near, jnp.minimum(self.here, self.far), self.far)
        return self.near + (farthest - self.near) * draw

    def next_node(
        self, begin: Float[Array, "ped *batch"]
    ) -> tuple[Int[Array, "ped *batch"], Bool[Array, "ped *batch"]]:
        """Return the next node of the line on the way to ``begin``, and whether ``begin`` comes first."""
        outward, inward = jnp.maximum(jnp.floor(self.here), 0) + 1, jnp.maximum(jnp.ceil(self.here) - 1, 0)
        off, away = self.here == OFF, begin > self.here
        node = jnp.where(off, 0, jnp.where(away, outward, inward)).astype(jnp.int32)
        return node, ~off & jnp.where(away, begin <= outward, begin >= inward)

    def to_landing(self, length: Array) -> Float[Array, "ped *batch"]:
        """Return the metres of path to the landing, if the next leg toward it is ``length`` metres long."""
        return jnp.where(self.here > 1, self.walk, length)

    def to_place(self, begin: Array, piece: Array, length: Array) -> Float[Array, "ped *batch"]:
        """Return the metres of path to ``begin``, by the length of a piece here and of the next leg [m]."""
        off = self.here == OFF
        return jnp.where(off, length, 0) + piece * jnp.abs(begin - jnp.where(off, 0, self.here))


def zone_of(world: World, scenario: Scenario, leg: Leg, side: Int[Array, "ped *batch"]) -> Zone:
    """Return the zone at a side, seen from the end of everybody's leg."""
    tables, line = world.tables, line_of(world, scenario, side)
    near, far, piece, clear = look_up_each([tables.side[name] for name in SIDE_COLUMNS], scenario.map, side)
    _, x, y, dx, dy, _ = line(jnp.zeros_like(leg.end_x))
    ahead_x, ahead_y = leg.end_x - x, leg.end_y - y
    squared = jnp.maximum(dx * dx + dy * dy, 1e-6)
    place = (ahead_x * dx + ahead_y * dy) / squared
    aside = jnp.abs(ahead_x * dy - ahead_y * dx) / jnp.sqrt(squared)
    rounded = jnp.round(place)
    place = jnp.where(jnp.abs(place - rounded) < SAME, rounded, place)
    elsewhere, walk = jnp.full_like(place, OFF), jnp.zeros_like(place)
    if tables.zone["x"].shape[-1] > 1:
        node_place, walk = look_up_each((tables.place, tables.walk), scenario.map, side, leg.node)
        elsewhere = jnp.where(node_place >= 0, node_place, OFF)
    here = jnp.where((aside < ON_LINE) & (place <= 1), place, elsewhere)
    return Zone(here, near, far, walk, clear, piece, line)


class Jaywalk(NamedTuple):
    """A way across; arrays ``(ped, *batch)``."""

    x: Array
    """Where it leaves the line of the zone [m]."""
    y: Array
    landing_x: Array
    """Where it reaches the opposite line [m]."""
    landing_y: Array
    enter: Array
    """From its begin to the roadway [m]."""
    leave: Array
    """From the roadway to its end [m]."""
    node: Array
    """First node after it."""
    piece: Array
    """Length of a piece of the line on which it begins [m]."""


def jaywalk_from(
    world: World,
    scenario: Scenario,
    side: Int[Array, "ped *batch"],
    zone: Zone,
    begin: Float[Array, "ped *batch"],
    goal: Int[Array, "ped *batch"],
) -> Jaywalk:
    """Return the jaywalk that each pedestrian would make from a place of the zone at a side.

    It is slanted toward the goal by at most 45 degrees within the opposite zone, so it is clear of crosswalks and
    junctions. Where vehicles are parked on this side, it is not slanted.
    """
    tables, opposite = world.tables, side ^ 1
    near, far, piece = look_up_each([tables.side[name] for name in ("near", "far", "piece")], scenario.map, opposite)
    straight, line = begin * (zone.piece / piece), line_of(world, scenario, opposite)
    one, other = zone.line(begin), line(straight)
    x, y = one.at(begin)
    straight_x, straight_y = other.at(straight)
    width = jnp.sqrt((straight_x - x) ** 2 + (straight_y - y) ** 2)
    goal_x, goal_y = look_up_each((world.maps.node_x, world.maps.node_y), scenario.map, goal)
    ahead = (goal_x - straight_x) * other.dx + (goal_y - straight_y) * other.dy
    toward = straight + ahead / jnp.maximum(other.dx**2 + other.dy**2, 1e-6)
    reach = width / piece
    if world.parked_gaps is not None:
        reach = jnp.where(_parked_beside(world.parked_gaps, scenario, side)[0].any(axis=0), 0, reach)
    end = jnp.clip(jnp.clip(toward, straight - reach, straight + reach), near, far)

    there = line(end)
    landing_x, landing_y = there.at(end)
    dx, dy = landing_x - x, landing_y - y
    past_first = end > look_up(tables.turn, scenario.map, opposite, there.number, goal)
    node = look_up(world.maps.zone_node, scenario.map, opposite, there.number + past_first)
    return Jaywalk(
        x=x,
        y=y,
        landing_x=landing_x,
        landing_y=landing_y,
        enter=one.to_kerb(dx, dy),
        leave=there.to_kerb(dx, dy),
        node=node,
        piece=jnp.sqrt(one.dx**2 + one.dy**2),
    )


def into_gap(
    world: World, scenario: Scenario, side: Int[Array, "ped *batch"], begin: Float[Array, "ped *batch"]
) -> Float[Array, "ped *batch"]:
    """Return where jaywalks from a side begin: beside a parked vehicle in the nearest gap, else at ``begin``."""
    if world.parked_gaps is None:
        return begin
    stands, low, high, before, behind = _parked_beside(world.parked_gaps, scenario, side)
    instead = jnp.where(begin - before <= behind - begin, before, behind)
    in_the_way = stands & (low < begin) & (begin < high)
    for one in range(len(low)):  # gaps are free, so nobody is moved twice
        begin = jnp.where(in_the_way[one], instead[one], begin)
    return begin


def _parked_beside(
    table: Float[Array, "map side vehicle 5"], scenario: Scenario, side: Int[Array, "ped *batch"]
) -> tuple[Bool[Array, "vehicle ped *batch"], *tuple[Float[Array, "vehicle ped *batch"], ...]]:
    """Return in which entries of each person's side a vehicle is parked, and their other columns."""
    assert scenario.parked is not None
    rows = look_up_row(table.reshape(*table.shape[:2], -1), scenario.map, side)
    slot, *places = jnp.moveaxis(rows.reshape(-1, COLUMNS, *side.shape), 1, 0)
    number = jnp.maximum(slot, 0).astype(jnp.int32)
    stands = jnp.take_along_axis(scenario.parked[:, None], number, axis=0, mode="promise_in_bounds")
    return stands & (slot != NO_SLOT), *places
