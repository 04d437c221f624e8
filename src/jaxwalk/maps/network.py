"""A street as plain data: lanes, areas, a walk graph with crossings, and the car's routes.

Generators and importers make a `Network`; the checks, the file format and the rasteriser read it. Positions are in
metres, x to the east, y to the north, from (0, 0) to `Network.size`. Parts name each other by their place in their
list, from 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np
import shapely
from pydantic import BeforeValidator, ConfigDict, Field, PlainSerializer
from pydantic.dataclasses import dataclass

from jaxwalk.maps.file import Index, Number, Point

AreaKind = Literal["roadway", "sidewalk", "crosswalk", "island", "parking", "building"]
"""Crosswalks and parking strips lie on the roadway; sidewalks, islands and buildings lie off it."""
CrossingType = Literal["zebra", "raised", "signals", "unmarked"]


def _points(value: Any) -> np.ndarray:
    """Return points as float64 (point, 2). Raise ValueError if they aren't numbers, two a point, or aren't finite."""
    return _table(value, float, "points must be [x, y] with two finite numbers each")


def _pairs(value: Any) -> np.ndarray:
    """Return pairs of indices as int64 (pair, 2). Raise ValueError if they aren't whole numbers, two a pair."""
    return _table(value, int, "must be pairs of whole numbers")


def _table(value: Any, kind: type, wrong: str) -> np.ndarray:
    """Return rows of two numbers of a kind; an array of a wider kind, text or booleans are refused by ``wrong``."""
    try:
        array = np.asarray(value)
    except ValueError:
        raise ValueError(wrong) from None
    if not array.size:
        return np.zeros((0, 2), kind)
    known = array.dtype.kind in ("iu" if kind is int else "iuf")
    if array.ndim != 2 or array.shape[1] != 2 or not known or not np.isfinite(array).all():
        raise ValueError(wrong)
    return array.astype(kind)


def _as_list(array: np.ndarray) -> list:
    return array.tolist()


Points = Annotated[np.ndarray, BeforeValidator(_points), PlainSerializer(_as_list)]
"""float64 (point, 2) [m]."""
Pairs = Annotated[np.ndarray, BeforeValidator(_pairs), PlainSerializer(_as_list)]
"""int64 (pair, 2)."""
_EXACT = ConfigDict(extra="forbid", arbitrary_types_allowed=True)


@dataclass(frozen=True, eq=False, config=_EXACT)
class Lane:
    """A piece of lane in one direction, from a fork or merge to the next."""

    line: Points
    """Its middle, in the direction of travel. An arc has a point at least every 0.5 m."""
    width: Number
    """Width [m]."""
    speed_limit: Number
    """Speed limit [m/s]."""
    successors: tuple[Index, ...] = ()
    """The lanes that begin where it ends; none at the end of the road."""

    def length(self) -> float:
        """Return its length [m]."""
        return float(along(self.line)[-1])


@dataclass(frozen=True, eq=False, config=_EXACT)
class Area:
    """A piece of ground. Areas of one kind may overlap or touch; together they are one surface."""

    kind: AreaKind
    outline: Points
    """Its corners in order, the first one not repeated."""
    holes: tuple[Points, ...] = ()
    """Outlines of what is cut out."""

    def shape(self) -> shapely.Polygon:
        """Return the area as a polygon."""
        return shapely.Polygon(self.outline, self.holes)


@dataclass(frozen=True, eq=False, config=_EXACT)
class WalkGraph:
    """Where people walk: straight ways between nodes, on sidewalks, islands and crosswalks."""

    nodes: Points
    """Nodes 0 to ``waypoints`` - 1 are waypoints, where people start and go; the others only shape the ways."""
    edges: Pairs
    """Nodes that are joined, each pair once. Only the edges of a crossing enter a roadway."""
    waypoints: Index
    """Number of waypoints."""


@dataclass(frozen=True, eq=False, config=_EXACT)
class JaywalkZone:
    """The stretch of two opposite kerbs beside a crossing between which people may jaywalk.

    Positions in it are metres from the landings along the line half-way between the two kerbs. It takes the bends of
    ``sides``; points of the two sides that face each other have equal positions.
    """

    sides: tuple[tuple[Index, ...], tuple[Index, ...]]
    """For each kerb the nodes of its sidewalk from the landing outward, joined by edges. Along straight kerbs two, of
    which only the landings need to face each other. Else equally many on both, those of one number face each other,
    and all pieces are about equally long: the longest at most 1.5 times as long as the shortest."""
    begin: Number
    """Where the zone begins [m]."""
    end: Number
    """Where it ends [m], before the last nodes."""


@dataclass(frozen=True, eq=False, config=_EXACT)
class Crossing:
    """A way over a roadway, from one landing to the other, perhaps over islands."""

    kind: CrossingType
    areas: tuple[Index, ...]
    """The crosswalk areas that it leads over; with an island between them, several."""
    nodes: tuple[Index, ...]
    """The way: a landing, the nodes between, the opposite landing. Landings are waypoints, each of one crossing; the
    nodes between aren't waypoints, and belong to no other way: one in the middle of each area, one on each island."""
    zone: JaywalkZone | None = None
    """Where people may jaywalk instead; None: nowhere."""


@dataclass(frozen=True, eq=False, config=_EXACT)
class LaneRoute:
    """A way of the car over lanes."""

    lanes: Annotated[tuple[Index, ...], Field(min_length=1)]
    """Each is a successor of the one before."""
    start: Number
    """Where it begins: metres along the first lane."""
    goal: Number
    """Where it ends: metres along the last lane."""


@dataclass(frozen=True, eq=False, config=_EXACT)
class Network:
    """A street."""

    size: Point
    """Width (to the east) and height (to the north) [m]."""
    lanes: tuple[Lane, ...]
    areas: tuple[Area, ...]
    walk: WalkGraph
    crossings: tuple[Crossing, ...]
    routes: tuple[LaneRoute, ...]
    attribution: str = ""
    """Whose data it was made from, which is shown wherever it is drawn; empty for what isn't made from others' data."""

    def surface(self, *kinds: AreaKind) -> shapely.geometry.base.BaseGeometry:
        """Return the union of all areas of some kinds."""
        return shapely.union_all([area.shape() for area in self.areas if area.kind in kinds])

    def route_line(self, route: LaneRoute) -> np.ndarray:
        """Return the middle of a route's lanes, float64 (point, 2) [m]: the first and last lane whole."""
        lines = [self.lanes[lane].line for lane in route.lanes]
        return without_repeats(np.concatenate(lines))


def along(line: np.ndarray) -> np.ndarray:
    """Return how far each point of a line (point, 2) is from its first one, along the line [m]."""
    return np.concatenate([[0.0], np.hypot(*np.diff(line, axis=0).T).cumsum()])


def without_repeats(line: np.ndarray, nearly: float = 1e-6) -> np.ndarray:
    """Return a line (point, 2) without points that repeat the one before."""
    return line[np.concatenate([[True], np.hypot(*np.diff(line, axis=0).T) > nearly])]


def corners(rectangle: Sequence[float]) -> np.ndarray:
    """Return the corners of [x0, y0, x1, y1] as an outline (4, 2)."""
    x0, y0, x1, y1 = rectangle
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], float)
