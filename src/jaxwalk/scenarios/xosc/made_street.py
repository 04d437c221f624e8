"""A street for a scenario whose road isn't known: along the way of the car, with sidewalks beside."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely

from jaxwalk.maps import ROUTE_SPACING, MapError, MapText, checked
from jaxwalk.maps.check import SMALLEST_TURN
from jaxwalk.maps.network import Area, AreaKind, Crossing, Lane, LaneRoute, Network, WalkGraph, along
from jaxwalk.maps.network_file import network_text
from jaxwalk.scenarios.xosc.elements import XoscRefusal

BEHIND, ROUTE_BEHIND, GOAL_SHORT = 45.0, 10.0, 2.0
"""The street begins so far behind the car, and its route; the route ends so far before the street [m]."""
CROSSWALK, HALF_CROSSWALK, FAR_NODE = 5.0, 2.0, 30.0
"""Where the crosswalk lies behind the car, half its width, and where the second node of each sidewalk is [m]."""
PAVEMENT, MARGIN, LIMIT = 3.0, 10.0, 40.0
"""Width of the sidewalks, room round everything [m], and the speed limit [m/s], which tests set."""
PRECISION = 1e-3
"""Places of edges are multiples of this [m]."""
ROUNDED, FLAT = (0.0, 2.0, 4.0, 8.0, 12.0), 1e-3
"""Lengths over which places of a way are averaged, until it is smooth enough, and how flat a straight way is [m]."""
LANE_WIDTHS = 3.0, 5.0
"""Smallest and largest width of the lane [m]."""
LARGEST_STREET = 1500.0
"""Largest extent of a street [m]."""


class Strip(NamedTuple):
    """The way of the car and the roadway beside it."""

    line: np.ndarray
    """Points of the middle of its lane, from where the car begins, float64 (point, 2) [m]."""
    heading: float
    """Its direction there [rad]."""
    right: float
    """Roadway to the right of the line [m]."""
    left: float


class MadeStreet(NamedTuple):
    """A street, and how it lies in the document."""

    track: MapText
    line: np.ndarray
    """The route in the map, float64 (point, 2) [m]; the car begins `ROUTE_BEHIND` metres along it."""
    shift: np.ndarray
    """What is added to places of the document (2,) [m]."""


def made_street(strip: Strip, places: np.ndarray, name: str) -> MadeStreet:
    """Return a street along a strip. Raise XoscRefusal if none can be made.

    Args:
        strip: where the car goes.
        places: what must lie on the map too, float64 (place, 2) [m].
        name: the street's name.
    """
    behind = strip.line[0] - BEHIND * np.array([np.cos(strip.heading), np.sin(strip.heading)])
    line = rounded(np.concatenate([behind[None], strip.line]))
    roadway, ground = _strips(line, strip)
    every = np.concatenate([shapely.get_coordinates(ground), places])
    shift = MARGIN - every.min(axis=0)
    size = every.max(axis=0) + shift + MARGIN
    if size.max() > LARGEST_STREET:
        raise XoscRefusal(f"the way of the car and people span {size.max():.0f} m; at most {LARGEST_STREET:g} m")
    network = _network(line + shift, strip, (roadway, ground), shift, (float(size[0]), float(size[1])))
    text = network_text(network)
    try:
        checked(text, name, goal_spacing=20.0, start_clearance=10.0)
    except MapError as error:
        reason = " ".join(str(error).partition(": ")[2].split()).removeprefix("- ")[:200]
        raise XoscRefusal(f"no street can be made along the way of the car: {reason}") from None
    metres = along(line)
    begin = BEHIND - ROUTE_BEHIND
    first, after = np.array([np.interp(begin, metres, line[:, k]) for k in (0, 1)]), metres > begin
    return MadeStreet(MapText.of(name, text), np.concatenate([first[None], line[after]]) + shift, shift)


def rounded(line: np.ndarray) -> np.ndarray:
    """Return a line (point, 2) without corners that are too sharp for the car: its places are averaged along it.

    Its ends stay where they are. Raise XoscRefusal if it bends too sharply all the same.
    """
    metres = along(line)
    count = int(np.ceil(metres[-1] / ROUTE_SPACING))
    even = np.linspace(0, metres[-1], count + 1)
    points = np.stack([np.interp(even, metres, line[:, k]) for k in (0, 1)], axis=1)
    for window in ROUNDED:
        half = int(window / 2 / ROUTE_SPACING)
        before, after = (2 * end - inner[::-1] for end, inner in (
            (points[0], points[1 : half + 1]), (points[-1], points[-half - 1 : -1])))  # fmt: skip
        longer = np.concatenate([before, points, after]) if half else points
        sums = np.concatenate([np.zeros((1, 2)), longer.cumsum(axis=0)])
        smooth = (sums[2 * half + 1 :] - sums[: len(sums) - 2 * half - 1]) / (2 * half + 1)
        steps = np.diff(smooth, axis=0)
        bends = np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))
        if np.abs(bends).max(initial=0) <= ROUTE_SPACING / SMALLEST_TURN:
            return shapely.get_coordinates(shapely.simplify(shapely.LineString(smooth), FLAT)) if not window else smooth
    raise XoscRefusal("the way of the tested car bends too sharply for it; write a smoother one")


def _strips(line: np.ndarray, strip: Strip) -> tuple[shapely.Polygon, shapely.Polygon]:
    """Return the roadway along a line, and with its sidewalks. Raise XoscRefusal where it bends too much."""
    middle = shapely.offset_curve(shapely.LineString(line), (strip.left - strip.right) / 2, quad_segs=32)
    half = (strip.left + strip.right) / 2
    found = [
        shapely.set_precision(shapely.buffer(middle, half + more, cap_style="flat", quad_segs=32), PRECISION)
        for more in (0.0, PAVEMENT)
    ]
    roadway, ground = found
    if not (isinstance(roadway, shapely.Polygon) and isinstance(ground, shapely.Polygon)):
        raise XoscRefusal("the way of the tested car bends too sharply for a street along it; write a smoother one")
    return roadway, ground


def _network(line: np.ndarray, strip: Strip, shapes: tuple, shift: np.ndarray, size: tuple[float, float]) -> Network:
    roadway, ground = (shapely.transform(shape, lambda points: points + shift) for shape in shapes)
    ahead = (line[1] - line[0]) / np.hypot(*(line[1] - line[0]))
    left = np.array([-ahead[1], ahead[0]])

    def at(along_line: float, to_left: float) -> np.ndarray:
        return line[0] + along_line * ahead + to_left * left

    near, far = CROSSWALK - HALF_CROSSWALK, CROSSWALK + HALF_CROSSWALK
    crosswalk = np.array([at(near, -strip.right), at(far, -strip.right), at(far, strip.left), at(near, strip.left)])
    beyond = PAVEMENT / 2
    sides = -strip.right - beyond, strip.left + beyond
    nodes = [at(place, side) for side in sides for place in (CROSSWALK, FAR_NODE)]
    nodes.append(at(CROSSWALK, (strip.left - strip.right) / 2))
    areas = [
        _area("roadway", roadway),
        *(
            _area("sidewalk", one)
            for one in shapely.get_parts(shapely.difference(ground, roadway, grid_size=PRECISION))
        ),
    ]
    areas.append(Area("crosswalk", np.round(crosswalk, 4)))
    lane = Lane(line=np.round(line, 4), width=float(np.clip(2 * strip.right, *LANE_WIDTHS)), speed_limit=LIMIT)
    walk = WalkGraph(nodes=np.round(np.array(nodes), 4), edges=np.array([(0, 1), (2, 3), (0, 4), (4, 2)]), waypoints=4)
    route = LaneRoute(lanes=(0,), start=BEHIND - ROUTE_BEHIND, goal=lane.length() - GOAL_SHORT)
    crossing = Crossing("unmarked", (len(areas) - 1,), (0, 4, 2))
    return Network(size=size, lanes=(lane,), areas=tuple(areas), walk=walk, crossings=(crossing,), routes=(route,))


def _area(kind: AreaKind, shape: shapely.geometry.base.BaseGeometry) -> Area:
    assert isinstance(shape, shapely.Polygon)
    outer, *holes = (np.round(shapely.get_coordinates(ring)[:-1], 4) for ring in (shape.exterior, *shape.interiors))
    return Area(kind, outer, tuple(holes))
