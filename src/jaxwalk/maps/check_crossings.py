"""Checks of crosswalks and their jaywalk zones."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.file import Crosswalk, MapFile, Side
from jaxwalk.maps.navigation import NEARLY, Graph
from jaxwalk.maps.routes import Road, make_road
from jaxwalk.maps.scene import Scene
from jaxwalk.maps.zones import zone_from_landing

ZONE = (1.0, 25.0)
"""Smallest and largest distance of a jaywalk zone from its crosswalk's edge [m]."""


def crossing_faults(file: MapFile, scene: Scene, graph: Graph) -> list[str]:
    """Return all faults of the crosswalks of a map file, one line each."""
    faults = [] if file.crosswalks else ["crosswalks: none; add at least one"]
    faults += _shared_faults(file, scene)
    for name, crosswalk in file.crosswalks.items():
        field = f"crosswalks.{name}"
        road = _spanned(crosswalk, file)
        if road is None or _in_junction(scene, name, road):
            faults.append(f"{field}.area: doesn't span one road from kerb to kerb, clear of junctions; "
                          "let it end exactly at both kerbs of one arm")  # fmt: skip
            continue
        if not all(n in file.waypoints for side in crosswalk.sides for n in (side.landing, side.outer)):
            continue  # the check of names reports it
        own = _landing_faults(field, crosswalk, road, file, scene)
        own += _side_faults(field, crosswalk, road, file, graph)
        faults += own or _clear_faults(field, crosswalk, road, file, scene)
    return faults


def _in_junction(scene: Scene, name: str, road: Road) -> bool:
    """Return whether a crosswalk overlaps another road than its own, that is, a junction."""
    area = scene.crosswalks[name]
    return any(_overlap(area, shape) for other, shape in scene.roads.items() if other != road.name)


def _shared_faults(file: MapFile, scene: Scene) -> list[str]:
    """Check that no two crosswalks overlap or share a landing."""
    faults = [
        f"crosswalks.{a} and crosswalks.{b}: overlap; move them apart"
        for (a, area), (b, other) in combinations(scene.crosswalks.items(), 2)
        if _overlap(area, other)
    ]
    landings = [side.landing for crosswalk in file.crosswalks.values() for side in crosswalk.sides]
    faults += [
        f"waypoints.{name}: the landing of {landings.count(name)} sides; give each side its own"
        for name in dict.fromkeys(landings)
        if landings.count(name) > 1
    ]
    return faults


def _spanned(crosswalk: Crosswalk, file: MapFile) -> Road | None:
    """Return the road that a crosswalk crosses from kerb to kerb, or None."""
    for name, area in file.roads.items():
        road = make_road(name, area)
        along, across = road.axis, 1 - road.axis
        ends = np.subtract(crosswalk.area, area)[[across, across + 2]]
        inside = area[along] - NEARLY <= crosswalk.area[along] and crosswalk.area[along + 2] <= area[along + 2] + NEARLY
        if np.abs(ends).max() < NEARLY and inside:
            return road
    return None


def _landing_faults(field: str, crosswalk: Crosswalk, road: Road, file: MapFile, scene: Scene) -> list[str]:
    """Check that the landings lie straight across the crosswalk's middle, one at each kerb."""
    faults = []
    points = np.array([file.waypoints[side.landing] for side in crosswalk.sides])
    along, across = road.axis, 1 - road.axis
    middle = np.array([crosswalk.area[0] + crosswalk.area[2], crosswalk.area[1] + crosswalk.area[3]]) / 2
    for number, point in enumerate(points):
        if abs(point[along] - middle[along]) > NEARLY:
            where = f"{'xy'[along]} = {middle[along]:g}"
            faults.append(f"{field}.sides[{number}].landing: not straight across the middle; move it to {where}")
        elif not scene.on_foot(shapely.LineString([point, middle]), crosswalks=True):
            faults.append(f"{field}.sides[{number}].landing: the way to the crosswalk leaves the sidewalk; "
                          "let the sidewalk reach the kerb there")  # fmt: skip
    beyond = points[:, across] - middle[across]
    if not (np.prod(beyond) < 0 and np.abs(beyond).min() > road.width / 2 - NEARLY):
        faults.append(f"{field}.sides: the landings must be at opposite kerbs")
    return faults


def _side_faults(field: str, crosswalk: Crosswalk, road: Road, file: MapFile, graph: Graph) -> list[str]:
    """Check that the zones lie within one edge along the kerb, at an allowed distance, opposite each other."""
    faults = []
    units = []
    for number, side in enumerate(crosswalk.sides):
        if file.waypoints[side.landing] == file.waypoints[side.outer]:
            faults.append(f"{field}.sides[{number}].outer: where the landing is; name its neighbour along the kerb")
            continue
        own, unit = _zone_faults(crosswalk, side, road, file, graph)
        faults += [f"{field}.sides[{number}].{fault}" for fault in own]
        units.append(unit)
    if len(units) == 2 and np.abs(units[0] - units[1]).max() > NEARLY:
        faults.append(f"{field}.sides: the zones go in different directions; let both lead away from the junction")
    if crosswalk.sides[0].zone != crosswalk.sides[1].zone:  # otherwise a straight way across could miss the other zone
        faults.append(f"{field}.sides: the zones differ; give both the same [from, to]")
    return faults


def _zone_faults(
    crosswalk: Crosswalk, side: Side, road: Road, file: MapFile, graph: Graph
) -> tuple[list[str], np.ndarray]:
    """Return the faults of one side, and the unit vector (2,) of its zone."""
    faults = []
    unit, _, far = zone_from_landing(crosswalk, side, file.waypoints)
    if abs(abs(unit[road.axis]) - 1) > NEARLY:
        faults.append("outer: not along the landing's kerb; name its neighbour on the same kerb")
    landing = np.array(file.waypoints[side.landing])
    neighbours = _neighbours(graph, side.landing)
    if side.outer not in neighbours:
        faults.append(f"outer: no walkway joins {side.outer} to {side.landing}; join them, or name a neighbour")
    for name in neighbours:
        away = np.array(file.waypoints[name]) - landing
        if abs(unit[0] * away[1] - unit[1] * away[0]) > NEARLY:
            faults.append(f"landing: its neighbour {name} is off the straight line of the kerb; put a waypoint between")
    low, high = side.zone
    if not ZONE[0] <= low < high <= ZONE[1]:
        faults.append(f"zone: must be [from, to] with {ZONE[0]:g} <= from < to <= {ZONE[1]:g} m")
    length = float(np.linalg.norm(np.array(file.waypoints[side.outer]) - landing))
    if far >= length - NEARLY:
        limit = length - (far - high)
        faults.append(f"zone: reaches past {side.outer}; end it before {limit:g}, or move that waypoint")
    return faults, unit


def _neighbours(graph: Graph, landing: str) -> list[str]:
    """Return the names of the waypoints joined to a landing, without the crosswalk's middle."""
    node = graph.names.index(landing)
    joined = graph.edges[(graph.edges == node).any(axis=1)].sum(axis=1) - node
    return [graph.names[other] for other in joined if other < graph.waypoints]


def _clear_faults(field: str, crosswalk: Crosswalk, road: Road, file: MapFile, scene: Scene) -> list[str]:
    """Check that straight lines between the zones stay on sidewalks and this road, off crosswalks and other roads."""
    ends = []
    for side in crosswalk.sides:
        unit, near, far = zone_from_landing(crosswalk, side, file.waypoints)
        ends += [np.array(file.waypoints[side.landing]) + unit * distance for distance in (near, far)]
    swept = shapely.MultiPoint(ends).convex_hull
    hit = [f"roads.{n}" for n, shape in scene.roads.items() if n != road.name and _overlap(swept, shape)]
    hit += [f"crosswalks.{n}" for n, shape in scene.crosswalks.items() if _overlap(swept, shape)]
    faults = [f"{field}.sides: the way between the zones meets {other}; end the zones before it" for other in hit]
    ground = shapely.union_all([scene.pavement, scene.roads[road.name]])
    if not hit and not ground.covers(swept):
        faults.append(f"{field}.sides: the way between the zones leaves road and sidewalks; shorten the zones")
    return faults


def _overlap(a: BaseGeometry, b: BaseGeometry) -> bool:
    """Return whether two shapes share an area."""
    return a.intersection(b).area > NEARLY
