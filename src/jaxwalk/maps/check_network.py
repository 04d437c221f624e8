"""All checks of a network. Each one returns its faults: one line each, which says what is wrong and what to do."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import shapely

from jaxwalk.maps.check import CAR_MARGIN, SMALLEST_TURN
from jaxwalk.maps.check_size import LARGEST
from jaxwalk.maps.check_walking import walking_faults
from jaxwalk.maps.network import Lane, LaneRoute, Network
from jaxwalk.maps.network_routes import sampled_route
from jaxwalk.maps.network_scene import SLACK, NetworkScene
from jaxwalk.maps.routes import ROUTE_SPACING

MOST_PARTS = {"lanes": 2000, "areas": 2000, "crossings": 200, "routes": 500}
"""Largest number of each part of a network."""
MOST_NODES, MOST_POINTS = 1000, 100_000
"""Largest number of nodes of the walk graph, and of points of all lanes and areas together."""
MOST_GROUND, MOST_ROUTE_METRES = 1e6, 100_000.0
"""Largest area of the map [m2], and largest length of all routes together [m]: tables of some 20 MB each."""
WIDTHS, FASTEST = (1.5, 10.0), 40.0
"""Smallest and largest width of a lane [m], and the highest speed limit [m/s]."""
SHARPEST_JOINT = 0.1
"""A lane's direction differs from its successor's by at most this [rad]."""


def network_faults(network: Network, *, goal_spacing: float, start_clearance: float) -> list[str]:
    """Return all faults of a network, one line each; empty if it can be used.

    Faults of size hide all others, and names of parts that don't exist or damaged outlines hide those of geometry, so
    that a check ends within seconds and never needs much memory.
    """
    if faults := _size_faults(network):
        return faults
    if faults := [*_index_faults(network), *_outline_faults(network)]:
        return faults
    scene = NetworkScene.of(network)
    return [
        *scene.overlap_faults(),
        *(fault for number, lane in enumerate(network.lanes) for fault in _lane_faults(number, lane, network, scene)),
        *walking_faults(network, scene, goal_spacing),
        *(fault for n, route in enumerate(network.routes)
          for fault in _route_faults(f"routes[{n}]", route, network, scene, start_clearance)),
    ]  # fmt: skip


def _size_faults(network: Network) -> list[str]:
    """Check what bounds the time and the memory of all other checks."""
    width, height = network.size
    faults = []
    if min(width, height) <= 0:
        faults.append(f"size: {width:g} x {height:g} m is no area; both must be above 0")
    if max(width, height) > LARGEST or width * height > MOST_GROUND:
        faults.append(f"size: {width:g} x {height:g} m is too large; at most {LARGEST:g} m long and "
                      f"{MOST_GROUND:,.0f} m2: cut the street into parts")  # fmt: skip
    counts = {name: (len(getattr(network, name)), most) for name, most in MOST_PARTS.items()}
    counts["walk.nodes"] = len(network.walk.nodes), MOST_NODES
    counts["walk.edges"] = len(network.walk.edges), 4 * MOST_NODES
    points = sum(len(lane.line) for lane in network.lanes)
    points += sum(len(line) for area in network.areas for line in (area.outline, *area.holes))
    counts["points of lanes and areas"] = points, MOST_POINTS
    named = sum(len(r.lanes) for r in network.routes) + sum(len(lane.successors) for lane in network.lanes)
    counts["lanes of all routes"] = named, MOST_POINTS
    faults += [
        f"{name}: {count:,} are too many; a street has at most {most:,}"
        for name, (count, most) in counts.items()
        if count > most
    ]
    return faults


def _index_faults(network: Network) -> list[str]:
    """Check that whatever is named by its place in a list exists."""
    lanes, areas, nodes = len(network.lanes), len(network.areas), len(network.walk.nodes)
    named = [(f"lanes[{n}].successors", lane.successors, lanes) for n, lane in enumerate(network.lanes)]
    named += [(f"routes[{n}].lanes", route.lanes, lanes) for n, route in enumerate(network.routes)]
    named += [("walk.edges", tuple(network.walk.edges.reshape(-1).tolist()), nodes)]
    for n, crossing in enumerate(network.crossings):
        named += [(f"crossings[{n}].areas", crossing.areas, areas), (f"crossings[{n}].nodes", crossing.nodes, nodes)]
        if crossing.zone is not None:
            named += [(f"crossings[{n}].zone.sides", side, nodes) for side in crossing.zone.sides]
    faults = [
        f"{field}: there is no {wrong[0]}; write numbers from 0 to {count - 1}"
        for field, numbers, count in named
        if (wrong := [x for x in numbers if not 0 <= x < count])
    ]
    if not 0 < network.walk.waypoints <= nodes:
        faults.append(f"walk.waypoints: {network.walk.waypoints} of {nodes} nodes; there must be some")
    faults += [
        f"{name}: none; add at least one" for name in ("lanes", "crossings", "routes") if not getattr(network, name)
    ]
    return faults


def _outline_faults(network: Network) -> Iterator[str]:
    """Yield the faults of outlines and lines by themselves."""
    rings = [(f"areas[{n}].outline", area.outline) for n, area in enumerate(network.areas)]
    rings += [(f"areas[{n}].holes[{k}]", x) for n, area in enumerate(network.areas) for k, x in enumerate(area.holes)]
    for field, line in rings:
        if len(line) < 3:
            yield f"{field}: {len(line)} points are no area; name at least three corners"
        elif not (ring := shapely.Polygon(line)).is_valid:
            yield f"{field}: crosses itself ({shapely.is_valid_reason(ring)}); put its corners in order"
        elif outside := _outside(line, network.size):
            yield f"{field}: {outside}"
    for number, lane in enumerate(network.lanes):
        if len(lane.line) < 2 or not np.hypot(*np.diff(lane.line, axis=0).T).all():
            yield f"lanes[{number}].line: needs at least two points, none like the one before; remove repetitions"
        elif outside := _outside(lane.line, network.size):
            yield f"lanes[{number}].line: {outside}"
    if outside := _outside(network.walk.nodes, network.size):
        yield f"walk.nodes: {outside}"


def _outside(points: np.ndarray, size: tuple[float, float]) -> str:
    """Return what is wrong if some point lies outside the map, else an empty text."""
    wrong = points[((points < 0) | (points > np.asarray(size))).any(axis=1)]
    if not len(wrong):
        return ""
    return f"({wrong[0, 0]:g}, {wrong[0, 1]:g}) is outside the map; move it inside, or correct size"


def _lane_faults(number: int, lane: Lane, network: Network, scene: NetworkScene) -> Iterator[str]:
    """Yield the faults of one lane."""
    field, (x, y) = f"lanes[{number}]", lane.line[-1]
    if not WIDTHS[0] <= lane.width <= WIDTHS[1]:
        yield f"{field}.width: {lane.width:g} m; write {WIDTHS[0]:g} to {WIDTHS[1]:g} m"
    if not 0 < lane.speed_limit <= FASTEST:
        yield f"{field}.speed_limit: {lane.speed_limit:g} m/s; write more than 0 and at most {FASTEST:g}"
    if not scene.wide_roadway.covers(shapely.LineString(lane.line)):
        yield f"{field}.line: leaves the roadway; widen the roadway or move the line"
    for follower in lane.successors:
        after = network.lanes[follower].line
        away = float(np.hypot(*(after[0] - lane.line[-1])))
        if away > SLACK:
            yield f"{field}.successors: lane {follower} begins {away:.2f} m from its end ({x:.2f}, {y:.2f}); join them"
        elif abs(_turn(lane.line[-2:], after[:2])) > SHARPEST_JOINT:
            yield f"{field}.successors: lane {follower} turns off sharply at ({x:.2f}, {y:.2f}); round the bend"
    if not lane.successors and scene.roadway.boundary.distance(shapely.Point(x, y)) > 2 * SLACK:
        yield (f"{field}: leads nowhere: it ends at ({x:.2f}, {y:.2f}) on the roadway; "
               "name its successors, or let it end where the roadway does")  # fmt: skip


def _turn(one: np.ndarray, other: np.ndarray) -> float:
    """Return the angle from one piece (2, 2) to another [rad]."""
    (ax, ay), (bx, by) = np.diff(one, axis=0)[0], np.diff(other, axis=0)[0]
    return float(np.arctan2(ax * by - ay * bx, ax * bx + ay * by))


def _route_faults(
    field: str, route: LaneRoute, network: Network, scene: NetworkScene, start_clearance: float
) -> Iterator[str]:
    """Yield the faults of one route of the car."""
    for a, b in pairwise(route.lanes):
        if b not in network.lanes[a].successors:
            yield f"{field}.lanes: lane {b} doesn't follow lane {a}; name a successor of it"
            return
    first, last = network.lanes[route.lanes[0]].length(), network.lanes[route.lanes[-1]].length()
    ahead = route.goal > (route.start if len(route.lanes) == 1 else 0)
    if not (0 <= route.start <= first and ahead and route.goal <= last):
        yield (f"{field}: start {route.start:g} and goal {route.goal:g} must lie on the first and last lane "
               f"({first:.2f} and {last:.2f} m long), the goal ahead of the start")  # fmt: skip
        return
    driven = sampled_route(network, route)
    points, tangents = driven.points, driven.tangents
    room = scene.room_on_road(points)
    if room.min() < CAR_MARGIN - SLACK:
        x, y = points[room.argmin()]
        yield (f"{field}: less than {CAR_MARGIN} m from the road's edge at ({x:.1f}, {y:.1f}); "
               "widen the road, or move the lane")  # fmt: skip
    bends = np.abs(np.arccos(np.clip((tangents[1:] * tangents[:-1]).sum(axis=1), -1, 1)))
    if bends.max(initial=0) > 1.05 * ROUTE_SPACING / SMALLEST_TURN:
        x, y = points[bends.argmax()]
        yield (f"{field}: bends too sharply at ({x:.1f}, {y:.1f}); the car turns within {SMALLEST_TURN:.2f} m at best: "
               "make the radius larger")  # fmt: skip
    waypoints = network.walk.nodes[: network.walk.waypoints]
    if np.hypot(*(waypoints - points[0]).T).max() < start_clearance:
        yield f"{field}: no waypoint is {start_clearance:g} m from the car's start; add one farther away"
