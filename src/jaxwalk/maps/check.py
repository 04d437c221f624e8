"""All checks of a map. Each one returns its faults: one line each, which says what is wrong and what to do."""

from __future__ import annotations

from itertools import combinations, pairwise, product

import numpy as np
import shapely

from jaxwalk.maps.check_crossings import crossing_faults
from jaxwalk.maps.check_reach import reach_faults
from jaxwalk.maps.file import MapFile
from jaxwalk.maps.navigation import NEARLY, Graph, build_graph, start_choices
from jaxwalk.maps.routes import ROUTE_SPACING, RouteFault, centre_lines, lane_route, make_road, meet, road_of, sample
from jaxwalk.maps.scene import Scene

SMALLEST_TURN = 2.5 / float(np.tan(0.52))
"""The car's smallest turning radius [m]: the wheelbase over the tangent of the largest steering angle."""
CAR_MARGIN = 0.5
"""Smallest distance of a route from the road's edge [m]. The simulator moves a car that leaves the road back to it."""


def find_faults(file: MapFile, *, goal_spacing: float, start_clearance: float) -> list[str]:
    """Return all faults of a map file, one line each; empty if the map can be used.

    Args:
        file: the map.
        goal_spacing: shortest walk to a next goal [m].
        start_clearance: shortest distance between the car's start and a pedestrian's start [m].
    """
    scene = Scene.of(file)
    graph = build_graph(file)
    return [
        *_rectangle_faults(file),
        *_road_faults(file, scene),
        *_name_faults(file),
        *_waypoint_faults(file, scene),
        *_walkway_faults(file, scene),
        *crossing_faults(file, scene, graph),
        *_reach_faults(graph, goal_spacing),
        *_place_faults(file),
        *_route_faults(file, scene, graph, start_clearance),
    ]


def _rectangle_faults(file: MapFile) -> list[str]:
    """Check that rectangles have an area and that everything lies inside the map."""
    faults = []
    width, height = file.size
    if min(file.size) <= 0:
        faults.append(f"size: {width:g} x {height:g} m is no area; both must be above 0")
    rectangles = {f"roads.{name}": area for name, area in file.roads.items()}
    rectangles |= {f"sidewalks.{name}": area for name, area in file.sidewalks.items()}
    rectangles |= {f"crosswalks.{name}.area": crosswalk.area for name, crosswalk in file.crosswalks.items()}
    for name, (x0, y0, x1, y1) in rectangles.items():
        if not (x0 < x1 and y0 < y1):
            faults.append(f"{name}: empty; write [x0, y0, x1, y1] with x0 < x1 and y0 < y1")
    corners = [(name, corner) for name, area in rectangles.items() for corner in (area[:2], area[2:])]
    corners += [(f"waypoints.{name}", point) for name, point in file.waypoints.items()]
    corners += [(f"car.places[{number}]", point) for number, point in enumerate(file.car.places)]
    outside = [name for name, (x, y) in corners if not (0 <= x <= width and 0 <= y <= height)]
    faults += [f"{name}: outside the map; move it inside, or correct size" for name in dict.fromkeys(outside)]
    return faults


def _road_faults(file: MapFile, scene: Scene) -> list[str]:
    """Check that roads have a direction, that parallel roads don't touch, and that sidewalks don't overlap roads."""
    faults = [] if file.roads else ["roads: none; add at least one"]
    roads = [make_road(name, area) for name, area in file.roads.items()]
    for road in roads:
        if road.area[road.axis + 2] - road.area[road.axis] <= road.width + NEARLY:
            faults.append(f"roads.{road.name}: not longer than wide; the longer side is the direction of traffic")
    for a, b in combinations(roads, 2):
        if a.axis == b.axis and meet(a.area, b.area):
            faults.append(f"roads.{a.name} and roads.{b.name}: parallel and touching; make them one road")
    faults += [
        f"sidewalks.{name}: overlaps roads.{road}; end it at the kerb"
        for (name, sidewalk), (road, area) in product(scene.sidewalks.items(), scene.roads.items())
        if sidewalk.intersection(area).area > NEARLY
    ]
    return faults


def _name_faults(file: MapFile) -> list[str]:
    """Check that walkways and crosswalks name only waypoints that exist."""
    used = [(f"walkways.{walkway}", name) for walkway, chain in file.walkways.items() for name in chain]
    for crosswalk, definition in file.crosswalks.items():
        for number, side in enumerate(definition.sides):
            field = f"crosswalks.{crosswalk}.sides[{number}]"
            used += [(f"{field}.landing", side.landing), (f"{field}.outer", side.outer)]
    return [
        f"{field}: no waypoint is called {name!r}; add it to waypoints or correct the name"
        for field, name in dict.fromkeys(used)
        if name not in file.waypoints
    ]


def _waypoint_faults(file: MapFile, scene: Scene) -> list[str]:
    """Check that waypoints lie on sidewalks, each at its own place."""
    faults = []
    for name, point in file.waypoints.items():
        if not scene.on_foot(shapely.Point(point), crosswalks=False):
            faults.append(f"waypoints.{name}: not on a sidewalk; move it onto one")
    for (a, point), (b, other) in combinations(file.waypoints.items(), 2):
        if np.hypot(point[0] - other[0], point[1] - other[1]) < NEARLY:
            faults.append(f"waypoints.{a} and waypoints.{b}: in the same place; remove one")
    return faults


def _walkway_faults(file: MapFile, scene: Scene) -> list[str]:
    """Check that walkways stay on sidewalks. Only the two edges of a crosswalk enter a roadway."""
    faults = [
        f"walkways.{walkway}: joins nothing; name at least two waypoints"
        for walkway, chain in file.walkways.items()
        if len(chain) < 2
    ]
    seen: dict[frozenset[str], str] = {}
    for walkway, a, b in ((walkway, a, b) for walkway, chain in file.walkways.items() for a, b in pairwise(chain)):
        field = f"walkways.{walkway}, {a} to {b}"
        if a == b:
            faults.append(f"{field}: a waypoint is joined to itself; remove the repetition")
            continue
        if frozenset((a, b)) in seen:
            faults.append(f"{field}: already joined by walkways.{seen[frozenset((a, b))]}; remove one of the two")
        seen.setdefault(frozenset((a, b)), walkway)
        if a in file.waypoints and b in file.waypoints:
            faults += _edge_faults(field, shapely.LineString([file.waypoints[a], file.waypoints[b]]), scene)
    return faults


def _edge_faults(field: str, edge: shapely.LineString, scene: Scene) -> list[str]:
    """Check one edge of a walkway."""
    if edge.intersection(scene.roadway).length > NEARLY:
        return [f"{field}: crosses a roadway; remove it, people cross at a crosswalk's landings"]
    if not scene.on_foot(edge, crosswalks=False):
        return [f"{field}: leaves the sidewalks; add a sidewalk there, or waypoints around the corner"]
    return []


def _reach_faults(graph: Graph, goal_spacing: float) -> list[str]:
    """Check that every waypoint is connected to every other, and has a goal to walk to."""
    if not graph.waypoints:
        return ["waypoints: none; add them along the sidewalks"]
    names = [f"waypoints.{name}" for name in graph.names[: graph.waypoints]]
    return reach_faults(graph, names, goal_spacing, join="a walkway")


def _place_faults(file: MapFile) -> list[str]:
    """Check that the car's places lie on centre lines, at different points, and that routes and radii are possible."""
    faults = []
    roads = [make_road(name, area) for name, area in file.roads.items()]
    places = file.car.places
    for number, (x, y) in enumerate(places):
        if road_of((x, y), roads) is None:
            faults.append(f"car.places[{number}]: ({x:g}, {y:g}) isn't on one road's centre line; move it there")
    for a, b in combinations(range(len(places)), 2):
        if np.hypot(places[a][0] - places[b][0], places[a][1] - places[b][1]) < NEARLY:
            faults.append(f"car.places[{a}] and car.places[{b}]: the same; remove one")
    pairs = file.car.pairs()
    if not pairs:
        faults.append("car.routes: none; list at least one, between two places")
    for pair in dict.fromkeys(pairs):
        if pairs.count(pair) > 1:
            faults.append(f"car.routes: {list(pair)} is listed {pairs.count(pair)} times; once is enough")
        if not all(0 <= place < len(places) for place in pair) or pair[0] == pair[1]:
            faults.append(f"car.routes: {list(pair)} must be two different places, 0 to {len(places) - 1}")
    for name in ("right_turn_radius", "left_turn_radius"):
        radius = getattr(file.car, name)
        if radius < SMALLEST_TURN:
            faults.append(f"car.{name}: the car can't turn within {radius:g} m; at least {SMALLEST_TURN:.2f} m")
    return faults


def _route_faults(file: MapFile, scene: Scene, graph: Graph, start_clearance: float) -> list[str]:
    """Check that the car can drive every route, and that pedestrians have waypoints to start from."""
    faults = []
    lines = centre_lines(file)
    places, roads = file.car.places, [make_road(name, area) for name, area in file.roads.items()]
    good = {number for number, place in enumerate(places) if road_of(place, roads) is not None}
    radii = (file.car.right_turn_radius, file.car.left_turn_radius)
    for start, goal in dict.fromkeys(file.car.pairs()):
        if start == goal or not {start, goal} <= good:
            continue  # _place_faults reports it
        field = f"route from {list(places[start])} to {list(places[goal])}"
        try:
            pieces, length = lane_route(lines, start, goal, radii)
        except RouteFault as fault:
            faults.append(f"{field}: {fault}")
            continue
        points, _ = sample(pieces, np.append(np.arange(0, length, ROUTE_SPACING), length))
        room = scene.room_on_road(points)
        if room.min() < CAR_MARGIN - NEARLY:
            x, y = points[room.argmin()]
            faults.append(f"{field}: less than {CAR_MARGIN} m from the road's edge at ({x:.1f}, {y:.1f}); "
                          "widen the road, move the place or change the turning radius")  # fmt: skip
        if not len(start_choices(graph, tuple(points[0]), start_clearance)):
            faults.append(f"{field}: no waypoint is {start_clearance:g} m from the car's start; add one farther away")
    return faults
