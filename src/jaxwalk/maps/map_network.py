"""The network of a map file: lanes cut out of its straight roads, with the arcs that its routes take."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from jaxwalk.maps.file import MapFile, Rectangle
from jaxwalk.maps.navigation import NEARLY, build_graph
from jaxwalk.maps.network import (
    Area,
    AreaKind,
    Crossing,
    JaywalkZone,
    Lane,
    LaneRoute,
    Network,
    WalkGraph,
    along,
    corners,
)  # fmt: skip
from jaxwalk.maps.routes import Road, RoutePiece, centre_lines, lane_route, make_road, sample
from jaxwalk.maps.zones import zone_from_landing

ARC_SPACING = 0.1
"""Distance between the points of an arc [m]: of the tightest one, a chord is then within 0.3 mm of it."""
SPEED_LIMIT = 8.33
"""Speed limit of all lanes of a map file [m/s]."""
MET = 1e-4
"""Ends of lanes that are this close are one place [m]."""


class _Stretch(NamedTuple):
    """A lane before its successors are known."""

    line: np.ndarray
    width: float
    road: Road | None
    """None for an arc."""


def network_of(file: MapFile) -> Network:
    """Return the network of a map file without faults. Waypoints, edges, crosswalks and routes keep their order."""
    graph = build_graph(file)
    areas = [*_areas("roadway", file.roads), *_areas("sidewalk", file.sidewalks)]
    first = len(areas)
    areas += _areas("crosswalk", {name: crosswalk.area for name, crosswalk in file.crosswalks.items()})
    pieces = _pieces(file)
    lanes = _lanes(file, pieces)
    shapes = _shapes(lanes)
    return Network(
        size=file.size,
        lanes=tuple(lanes),
        areas=tuple(areas),
        walk=WalkGraph(nodes=graph.points, edges=graph.edges, waypoints=graph.waypoints),
        crossings=tuple(_crossings(file, first)),
        routes=tuple(_route(route, length, lanes, shapes) for route, length in pieces),
    )


def _areas(kind: AreaKind, rectangles: dict) -> list[Area]:
    return [Area(kind=kind, outline=corners(rectangle)) for rectangle in rectangles.values()]


def _crossings(file: MapFile, first_area: int) -> Iterator[Crossing]:
    """Yield the crossing of each crosswalk; ``first_area`` is the number of the first one's area."""
    index = {name: number for number, name in enumerate(file.waypoints)}
    for number, crosswalk in enumerate(file.crosswalks.values()):
        (one, other), middle = crosswalk.sides, len(index) + number
        _, begin, end = zone_from_landing(crosswalk, one, file.waypoints)
        yield Crossing(
            kind="zebra",
            areas=(first_area + number,),
            nodes=(index[one.landing], middle, index[other.landing]),
            zone=JaywalkZone(
                sides=((index[one.landing], index[one.outer]), (index[other.landing], index[other.outer])),
                begin=begin,
                end=end,
            ),
        )


def _pieces(file: MapFile) -> list[tuple[list[RoutePiece], float]]:
    """Return the pieces and the length [m] of each route."""
    lines, radii = centre_lines(file), (file.car.right_turn_radius, file.car.left_turn_radius)
    return [lane_route(lines, start, goal, radii) for start, goal in file.car.pairs()]


def _lanes(file: MapFile, routes: list[tuple[list[RoutePiece], float]]) -> list[Lane]:
    """Return the arcs of all routes, and both lanes of every road, cut where an arc begins or ends."""
    roads = [make_road(name, area) for name, area in file.roads.items()]
    narrowest = min(road.width for road in roads) / 2
    found: dict[tuple, _Stretch] = {}
    for piece in (piece for pieces, _ in routes for piece in pieces if np.isfinite(piece.radius)):
        line = _arc(piece)
        found.setdefault(tuple(np.round([*line[0], *line[-1]], 3)), _Stretch(line, narrowest, None))
    ends = np.array([arc.line[end] for arc in found.values() for end in (0, -1)]).reshape(-1, 2)
    stretches = [*found.values(), *(x for road in roads for sign in (1, -1) for x in _cut(road, sign, ends))]
    return _joined(_without_stubs(stretches, roads))


def _arc(piece: RoutePiece) -> np.ndarray:
    """Return the points of a quarter of a circle, (point, 2)."""
    length = np.pi / 2 * piece.radius
    points, _ = sample([piece._replace(begin=0.0)], np.linspace(0, length, int(np.ceil(length / ARC_SPACING)) + 1))
    return points


def _cut(road: Road, sign: int, ends: np.ndarray) -> Iterator[_Stretch]:
    """Yield one lane of a road in pieces, in the direction of travel: to the east or north (1), or back (-1)."""
    low, high = road.area[road.axis], road.area[road.axis + 2]
    to_the_right = -sign if road.axis == 0 else sign  # of somebody who drives east, the right-hand lane is south
    across = road.centre + to_the_right * road.width / 4
    on = ends[np.abs(ends[:, 1 - road.axis] - across) < MET][:, road.axis]
    places = np.unique(np.round(np.concatenate([[low, high], on[(on > low) & (on < high)]]), 6))
    for begin, end in pairwise(places[::sign]):
        line = np.empty((2, 2))
        line[:, road.axis], line[:, 1 - road.axis] = (begin, end), across
        yield _Stretch(line, road.width / 2, road)


def _without_stubs(stretches: list[_Stretch], roads: list[Road]) -> list[_Stretch]:
    """Return the stretches without those that end or begin in another road, where no lane continues them."""
    starts, ends = (np.array([x.line[k] for x in stretches]) for k in (0, -1))

    def loose(point: np.ndarray, others: np.ndarray, road: Road | None) -> bool:
        into = any(_covers(other.area, point) for other in roads if road is not None and other is not road)
        return into and not (np.hypot(*(others - point).T) < MET).any()

    return [x for x in stretches if not loose(x.line[-1], starts, x.road) and not loose(x.line[0], ends, x.road)]


def _covers(area: Rectangle, point: np.ndarray) -> bool:
    return all(area[k] - NEARLY <= point[k] <= area[k + 2] + NEARLY for k in (0, 1))


def _joined(stretches: list[_Stretch]) -> list[Lane]:
    """Return lanes with their successors: those that begin where one ends, in its direction."""
    starts = np.array([x.line[0] for x in stretches])
    ahead = np.array([_direction(x.line[0], x.line[1]) for x in stretches])
    lanes = []
    for line, width, _ in stretches:
        near = np.hypot(*(starts - line[-1]).T) < MET
        onward = ahead @ _direction(line[-2], line[-1]) > 0.99
        found = tuple(np.flatnonzero(near & onward).tolist())
        lanes.append(Lane(line=line, width=width, speed_limit=SPEED_LIMIT, successors=found))
    return lanes


def _direction(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (b - a) / np.linalg.norm(b - a)


class _Shapes(NamedTuple):
    """What routes ask of all lanes."""

    begins: np.ndarray
    """(lane, 2) [m]."""
    ahead: np.ndarray
    """Unit vectors of travel where the lanes begin, (lane, 2)."""
    straight: np.ndarray
    """Length of each straight lane [m]; 0 for an arc."""
    lengths: list[float]
    """Length of each lane [m]."""
    middles: np.ndarray
    """The point half-way along each lane, (lane, 2) [m]."""


def _shapes(lanes: list[Lane]) -> _Shapes:
    lines = [lane.line for lane in lanes]
    lengths = [lane.length() for lane in lanes]
    halves = [
        [np.interp(length / 2, along(line), line[:, k]) for k in (0, 1)]
        for line, length in zip(lines, lengths, strict=True)
    ]
    return _Shapes(
        begins=np.array([line[0] for line in lines]),
        ahead=np.array([_direction(line[0], line[1]) for line in lines]),
        straight=np.array([np.linalg.norm(line[-1] - line[0]) if len(line) == 2 else 0.0 for line in lines]),
        lengths=lengths,
        middles=np.array(halves),
    )


def _route(pieces: list[RoutePiece], length: float, lanes: list[Lane], shapes: _Shapes) -> LaneRoute:
    """Return the lanes that a route takes: from lane to lane, the one whose middle the route is nearest to."""
    (begin,), (direction,) = sample(pieces, np.zeros(1))
    first = _first_lane(begin, direction, shapes)
    taken, start = [first], float(np.linalg.norm(begin - lanes[first].line[0]))
    reached = shapes.lengths[first] - start
    while reached < length - NEARLY:
        onward = np.array(lanes[taken[-1]].successors)
        there, _ = sample(pieces, reached + np.take(shapes.lengths, onward) / 2)
        taken.append(int(onward[np.hypot(*(there - shapes.middles[onward]).T).argmin()]))
        reached += shapes.lengths[taken[-1]]
    return LaneRoute(lanes=tuple(taken), start=start, goal=shapes.lengths[taken[-1]] - (reached - length))


def _first_lane(point: np.ndarray, direction: np.ndarray, shapes: _Shapes) -> int:
    """Return the straight lane that a point lies on, before its end, and that leads in a direction."""
    offset = point - shapes.begins
    here = (offset * shapes.ahead).sum(axis=1)
    aside = np.hypot(*(offset - here[:, None] * shapes.ahead).T)
    on = (aside < MET) & (here > -MET) & (here < shapes.straight - MET)
    onward = shapes.ahead @ direction > 0.99
    return int(np.flatnonzero(on & onward)[-1])  # of two that meet there, the one that begins
