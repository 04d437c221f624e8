"""Lane routes for the car: the shortest way along centre lines, moved into the right-hand lane, with rounded corners.

Roads are axis-aligned rectangles whose longer side is their direction. Two perpendicular roads that overlap or share a
piece of edge form a junction where their (extended) centre lines meet.
"""

from __future__ import annotations

from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np
import scipy

from jaxwalk.maps.file import MapFile, Rectangle
from jaxwalk.maps.navigation import NEARLY

ROUTE_SPACING = 0.5
"""Distance between the points of a route [m]."""


class RouteFault(ValueError):
    """A route is impossible. The message says why and what to do."""


class Road(NamedTuple):
    """A road and its direction."""

    name: str
    area: Rectangle
    axis: int
    """0: runs west-east; 1: runs south-north."""
    centre: float
    """Coordinate of the centre line on the other axis [m]."""
    width: float
    """Width of both lanes together [m]."""


class RoutePiece(NamedTuple):
    """A straight line or an arc of a route."""

    begin: float
    """Distance of its first point from the start of the route [m]."""
    point: np.ndarray
    """Its first point: x, y [m]."""
    direction: np.ndarray
    """Unit vector of travel at its first point."""
    inward: np.ndarray
    """Unit vector from the first point to the centre of the arc; unused on a straight line."""
    radius: float
    """Radius of the arc [m]; inf for a straight line."""


class CentreLines(NamedTuple):
    """The network of centre lines between places and junctions."""

    points: np.ndarray
    """float64 (place + junction, 2) [m]."""
    roads: dict[tuple[int, int], Road]
    """The road between two neighbouring points."""
    before: np.ndarray
    """int (place, point): the previous point on the shortest way from the place; negative if there is none."""


def make_road(name: str, area: Rectangle) -> Road:
    """Return the road with this rectangle."""
    extent = (area[2] - area[0], area[3] - area[1])
    axis = int(extent[1] > extent[0])
    across = 1 - axis
    return Road(name, area, axis, (area[across] + area[across + 2]) / 2, extent[across])


def meet(a: Rectangle, b: Rectangle) -> bool:
    """Return whether two rectangles overlap or share a piece of edge (a common corner isn't enough)."""
    shared = [min(a[k + 2], b[k + 2]) - max(a[k], b[k]) for k in (0, 1)]
    return min(shared) > -NEARLY and max(shared) > NEARLY


def road_of(place: tuple[float, float], roads: list[Road]) -> Road | None:
    """Return the road that has the place on its centre line; None in a junction or off the centre lines."""
    on = [r for r in roads if all(r.area[k] - NEARLY <= place[k] <= r.area[k + 2] + NEARLY for k in (0, 1))]
    if len(on) != 1 or abs(place[1 - on[0].axis] - on[0].centre) > NEARLY:
        return None
    return on[0]


def centre_lines(file: MapFile) -> CentreLines:
    """Return the network of a map file. Places off the centre lines have no neighbours."""
    roads = [make_road(name, area) for name, area in file.roads.items()]
    points = list(file.car.places)
    on_road: dict[str, list[int]] = {road.name: [] for road in roads}
    for number, place in enumerate(points):
        road = road_of(place, roads)
        if road is not None:
            on_road[road.name].append(number)
    for a, b in combinations(roads, 2):
        if a.axis == b.axis or not meet(a.area, b.area):
            continue
        for road in (a, b):
            on_road[road.name].append(len(points))
        points.append((b.centre, a.centre) if a.axis == 0 else (a.centre, b.centre))
    neighbours: dict[tuple[int, int], Road] = {}
    for road in roads:
        along = sorted(on_road[road.name], key=lambda number, axis=road.axis: points[number][axis])
        neighbours |= {pair: road for pair in pairwise(along)}
    array = np.array(points, float).reshape(-1, 2)
    before = _shortest(array, neighbours, len(file.car.places))
    return CentreLines(array, neighbours | {(b, a): road for (a, b), road in neighbours.items()}, before)


def _shortest(points: np.ndarray, neighbours: dict[tuple[int, int], Road], places: int) -> np.ndarray:
    """Run Dijkstra's algorithm from each place: int (place, point), the previous point."""
    pairs = np.array(list(neighbours), int).reshape(-1, 2)
    lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    matrix = scipy.sparse.csr_array((lengths, (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    _, before = scipy.sparse.csgraph.dijkstra(
        matrix, directed=False, indices=np.arange(places), return_predecessors=True
    )
    return before


def lane_route(lines: CentreLines, start: int, goal: int, radii: tuple[float, float]) -> tuple[list[RoutePiece], float]:
    """Return the pieces and the length [m] of the route between two places; ``radii`` are of right and left turns [m].

    Raises RouteFault if there is no way, or if a straight piece is too short for the turns at its ends.
    """
    corners, directions = _lane_corners(lines, _way(lines, start, goal))
    turns = [float(a[0] * b[1] - a[1] * b[0]) for a, b in pairwise(directions)]
    cuts = [0.0, *(radii[0] if turn < 0 else radii[1] for turn in turns), 0.0]
    pieces: list[RoutePiece] = []
    begin = 0.0
    for number, direction in enumerate(directions):
        lane = float(direction @ (corners[number + 1] - corners[number]))
        straight = lane - cuts[number] - cuts[number + 1]
        if straight < -NEARLY:
            x, y = corners[number]
            raise RouteFault(
                f"the lane from ({x:g}, {y:g}) is {-straight:.2f} m too short for its turns: "
                "move the place away from the junction, or make the turning radii smaller"
            )
        first = corners[number] + cuts[number] * direction
        pieces.append(RoutePiece(begin, first, direction, np.zeros(2), np.inf))
        begin += straight
        if number < len(turns):
            radius = cuts[number + 1]
            pieces.append(RoutePiece(begin, first + straight * direction, direction, directions[number + 1], radius))
            begin += np.pi / 2 * radius
    return pieces, begin


def _way(lines: CentreLines, start: int, goal: int) -> list[int]:
    """Return the points of the shortest way, which never turns back. Raises RouteFault if there is none."""
    way = [goal]
    while way[-1] != start:
        step = int(lines.before[start, way[-1]])
        if step < 0:
            raise RouteFault("no road leads there: let the roads meet, or remove the route from the list")
        way.append(step)
    return way[::-1]


def _lane_corners(lines: CentreLines, way: list[int]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return start, corners and goal in the lane, float64 (corner, 2) [m], and the directions of travel between."""
    steps = [(a, b, lines.roads[a, b]) for a, b in pairwise(way)]
    # The way bends only where the road changes.
    bends = [k for k in range(1, len(steps)) if steps[k][2] is not steps[k - 1][2]]
    corners = lines.points[[way[k] for k in (0, *bends, len(steps))]].copy()
    directions = []
    for number, k in enumerate((0, *bends)):
        a, b, road = steps[k]
        direction = np.zeros(2)
        direction[road.axis] = np.sign(lines.points[b, road.axis] - lines.points[a, road.axis])
        right = np.array([direction[1], -direction[0]])
        across = 1 - road.axis
        corners[number : number + 2, across] = road.centre + right[across] * road.width / 4
        directions.append(direction)
    return corners, directions


def sample(pieces: list[RoutePiece], along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points [m] and unit tangents, each float64 (point, 2), at ``along`` metres from the start.

    The route goes straight on beyond its last piece.
    """
    which = np.searchsorted([piece.begin for piece in pieces], along, side="right") - 1
    points, tangents = np.empty((2, len(along), 2))
    for number, piece in enumerate(pieces):
        here = which == number
        s = (along[here] - piece.begin)[:, None]
        if np.isinf(piece.radius):
            points[here] = piece.point + s * piece.direction
            tangents[here] = piece.direction
            continue
        sine, cosine = np.sin(s / piece.radius), np.cos(s / piece.radius)
        points[here] = piece.point + piece.radius * (sine * piece.direction + (1 - cosine) * piece.inward)
        tangents[here] = cosine * piece.direction + sine * piece.inward
    return points, tangents
