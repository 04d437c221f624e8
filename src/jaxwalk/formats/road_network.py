"""Lanes for formats that need them: a map's rectangles as straight roads that meet in junctions.

Every junction cuts its roads' rectangles. The remaining pieces are arms, with a lane in each direction. Connections
lead from arm to arm through a junction, straight on or along a quarter of a circle. Right-hand traffic.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from jaxwalk.formats.tracks import TracksError
from jaxwalk.maps import RoadMap

Rectangle = tuple[float, float, float, float]
"""x0, y0, x1, y1 [m]."""
ROOM = 5.0
"""Length by which a junction reaches beyond the wider road's edge, unless a crosswalk or junction is nearer [m]."""
EAST, NORTH = 0.0, math.pi / 2


@dataclass(frozen=True)
class Junction:
    """A place where roads meet."""

    x: float
    """Point where the centre lines meet [m]."""
    y: float
    reach: float
    """Distance from that point to the junction's arms [m]."""


@dataclass(frozen=True)
class Arm:
    """A straight piece of road, with a lane in each direction."""

    x: float
    """First point of the centre line [m]."""
    y: float
    heading: float
    """EAST or NORTH [rad]."""
    length: float
    """Length of the centre line [m]."""
    width: float
    """Width of both lanes together [m]."""
    ends: tuple[int | None, int | None]
    """The junctions where it begins and ends; None at the end of a road."""


@dataclass(frozen=True)
class Connection:
    """A lane through a junction. It lies to the right of a line from arm to arm."""

    junction: int
    """Number of the junction."""
    incoming: int
    """Number of the arm from which it leads."""
    outgoing: int
    """Number of the arm to which it leads."""
    x: float
    """First point of its line [m]."""
    y: float
    heading: float
    """Heading at the first point [rad]."""
    length: float
    """Length of the line [m]."""
    curvature: float
    """Curvature, positive to the left [1/m]; 0 if it is straight."""
    widths: tuple[float, float]
    """Width of the lane at its beginning and end [m]."""


@dataclass(frozen=True)
class RoadNetwork:
    """The lanes of a map."""

    junctions: tuple[Junction, ...]
    arms: tuple[Arm, ...]
    connections: tuple[Connection, ...]
    crosswalks: tuple[Rectangle, ...]
    sidewalks: tuple[Rectangle, ...]

    def bounds(self) -> Rectangle:
        """Return the bounding rectangle of all arms [m]."""
        boxes = []
        for arm in self.arms:
            along, half = (arm.length, 0.0) if arm.heading == EAST else (0.0, arm.length), arm.width / 2
            wide = (0.0, half) if arm.heading == EAST else (half, 0.0)
            boxes.append((arm.x - wide[0], arm.y - wide[1], arm.x + along[0] + wide[0], arm.y + along[1] + wide[1]))
        x0, y0, x1, y1 = zip(*boxes, strict=True)
        return min(x0), min(y0), max(x1), max(y1)

    def arms_at(self, junction: int) -> Iterator[tuple[int, Arm, bool]]:
        """Yield the arms at a junction: number, arm, and whether the arm ends there (else it begins there)."""
        for (number, arm), at_end in product(enumerate(self.arms), (False, True)):
            if arm.ends[at_end] == junction:
                yield number, arm, at_end


def road_network(road_map: RoadMap) -> RoadNetwork:
    """Return the lanes of a map (not a stack of maps).

    Raises TracksError if two junctions, or a junction and a crosswalk, are too close.
    """
    roads, crosswalks, sidewalks = (_real(getattr(road_map, name)) for name in ("roads", "crosswalks", "sidewalks"))
    junctions = _junctions(roads, crosswalks)
    arms = tuple(arm for road in roads for arm in _arms(road, junctions))
    bare = RoadNetwork(junctions, arms, (), crosswalks, sidewalks)
    connections = tuple(one for number in range(len(junctions)) for one in _connections(bare, number))
    return RoadNetwork(junctions, arms, connections, crosswalks, sidewalks)


def _real(rectangles: np.ndarray) -> tuple[Rectangle, ...]:
    """Return the rectangles that aren't padding."""
    x0, y0, x1, y1 = np.asarray(rectangles, float).T
    return tuple(zip(*(side[x0 <= x1].tolist() for side in (x0, y0, x1, y1)), strict=True))


def _leads_east(road: Rectangle) -> bool:
    return road[2] - road[0] >= road[3] - road[1]


def _junctions(roads: tuple[Rectangle, ...], crosswalks: tuple[Rectangle, ...]) -> tuple[Junction, ...]:
    """Return the junctions: places where perpendicular roads overlap or share a piece of edge."""
    half: dict[tuple[float, float], float] = {}
    for east, north in product(filter(_leads_east, roads), (road for road in roads if not _leads_east(road))):
        if east[0] <= north[2] and north[0] <= east[2] and east[1] <= north[3] and north[1] <= east[3]:
            place = (north[0] + north[2]) / 2, (east[1] + east[3]) / 2
            wider = max(north[2] - north[0], east[3] - east[1]) / 2
            half[place] = max(wider, half.get(place, 0.0))
    return tuple(Junction(*place, _reach(place, half, crosswalks)) for place in half)


def _reach(
    place: tuple[float, float], half: dict[tuple[float, float], float], crosswalks: tuple[Rectangle, ...]
) -> float:
    """Return how far a junction reaches [m]: to the next crosswalk, or halfway to the next junction, at most.

    Raises TracksError if that is less than half the road's width.
    """
    x, y = place
    free = [half[place] + ROOM]
    free += [max(abs(x - a), abs(y - b)) / 2 for a, b in half if (a, b) != place and (a == x or b == y)]
    for x0, y0, x1, y1 in crosswalks:
        if y0 < y < y1:
            free.append(min(abs(x0 - x), abs(x1 - x)))
        if x0 < x < x1:
            free.append(min(abs(y0 - y), abs(y1 - y)))
    if min(free) < half[place]:
        raise TracksError(f"the junction at ({x:g}, {y:g}) has no room for lanes: move crosswalks or junctions away")
    return min(free)


def _arms(road: Rectangle, junctions: tuple[Junction, ...]) -> Iterator[Arm]:
    """Yield the pieces of a road that its junctions leave."""
    x0, y0, x1, y1 = road
    east = _leads_east(road)
    begin, end, centre, width = (x0, x1, (y0 + y1) / 2, y1 - y0) if east else (y0, y1, (x0 + x1) / 2, x1 - x0)
    along = sorted(
        (place, number, one.reach)
        for number, one in enumerate(junctions)
        for place, across in [(one.x, one.y) if east else (one.y, one.x)]
        if across == centre and begin - one.reach < place < end + one.reach
    )
    starts = [(begin, None), *((place + reach, number) for place, number, reach in along)]
    stops = [*((place - reach, number) for place, number, reach in along), (end, None)]
    for (start, before), (stop, after) in zip(starts, stops, strict=True):
        if stop - start > 0:
            x, y = (start, centre) if east else (centre, start)
            yield Arm(x, y, EAST if east else NORTH, stop - start, width, (before, after))


def _connections(network: RoadNetwork, junction: int) -> Iterator[Connection]:
    """Yield a lane from every arm of a junction to every other one."""
    reach = network.junctions[junction].reach
    for (number, arm, at_end), (target, other, other_end) in permutations(network.arms_at(junction), 2):
        heading = arm.heading + (0 if at_end else math.pi)
        turn = math.remainder(other.heading + (math.pi if other_end else 0) - heading, 2 * math.pi)
        straight = abs(turn) < 0.1
        begin = arm.length if at_end else 0.0
        yield Connection(
            junction=junction,
            incoming=number,
            outgoing=target,
            x=arm.x + begin * math.cos(arm.heading),
            y=arm.y + begin * math.sin(arm.heading),
            heading=heading,
            length=2 * reach if straight else reach * math.pi / 2,
            curvature=0.0 if straight else math.copysign(1 / reach, turn),
            widths=(arm.width / 2, other.width / 2),
        )
