"""The ground of SUMO networks: lanes as bands, and junctions as they are mapped, without their walking areas."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.imported.kerb_ground import surface
from jaxwalk.maps.imported.mapped_lanes import band, beyond_end
from jaxwalk.maps.imported.smoothing import with_rounded_corners
from jaxwalk.maps.imported.source_map import Box
from jaxwalk.maps.imported.sumo_reading import CARS, PEOPLE, SumoNet

LIGHT = frozenset({PEOPLE, "wheelchair", "bicycle", "scooter", "moped"})
"""A lane for people that nobody else may use is a sidewalk."""
TRACKS = frozenset({"tram", "rail", "rail_urban", "rail_electric", "rail_fast", "subway"})
ROAD = frozenset({"all", CARS, "bus", "coach", "taxi", "truck"})
"""An edge that none of these may use is no road."""
BACK = "t"
"""The direction of a connection on which vehicles turn back."""
AT_EDGE = 30.0
"""A road that ends this close to the network's edge goes on beyond it [m]."""
AROUND_JUNCTION, AROUND_CORNERS = 4.0, 8.0
"""A junction's region reaches this far beyond it; its corners are rounded this far around it [m]."""


def is_for(lane: Any, kind: str) -> bool:
    """Return whether a class of vehicles, or people, may use a lane."""
    return not lane.getPermissions().isdisjoint((kind, "all"))


def is_walk(lane: Any) -> bool:
    """Return whether a lane is a sidewalk or a path."""
    return is_for(lane, PEOPLE) and "all" not in lane.getPermissions() and lane.getPermissions() <= LIGHT


def is_road(edge: Any) -> bool:
    """Return whether an edge has a lane for cars, lorries or buses."""
    return any(lane.getPermissions() & ROAD for lane in edge.getLanes())


def is_roadway(lane: Any) -> bool:
    """Return whether a lane of a road is a part of its roadway: those for buses are, green strips aren't."""
    return bool(lane.getPermissions()) and not is_walk(lane)


def roadway(net: SumoNet, edges: Sequence[Any]) -> BaseGeometry:
    """Return all that lies between the kerbs of some edges."""
    bands = [band(net.points(lane.getShape()), lane.getWidth()) for edge in edges for lane in _paved(edge)]
    walked: dict[str, list[BaseGeometry]] = defaultdict(list)
    for area in net.walking_areas:
        walked[area.getFromNode().getID()].append(_polygon(net.points(area.getLanes()[0].getShape())))
    grounds, corners = [], []
    for node, own in _junctions(edges):
        hull = shapely.MultiPoint(np.concatenate([_corners(net, edge, at_end) for edge, at_end in own])).convex_hull
        mapped = _polygon(net.points(node.getShape()))
        ground = hull if mapped.is_empty else hull.intersection(mapped)
        walks = walked.get(node.getID(), [])
        grounds.append(surface(ground.difference(shapely.union_all(walks))))
        corners += [] if walks else [hull.buffer(AROUND_CORNERS)]
    whole = shapely.union_all([*bands, *grounds])
    return with_rounded_corners(whole, shapely.union_all(corners))


def junction_regions(net: SumoNet, edges: Sequence[Any], kind: str = "") -> list[BaseGeometry]:
    """Return the regions of junctions that no street's edge may cut; ``kind``: only those whose type begins so."""
    return [
        shapely.MultiPoint(
            np.concatenate([_corners(net, edge, at_end) for edge, at_end in own] + [net.points(node.getShape())])
        ).convex_hull.buffer(AROUND_JUNCTION)
        for node, own in _junctions(edges) if node.getType().startswith(kind)
    ]  # fmt: skip


def open_ends(net: SumoNet, edges: Sequence[Any], extent: Box) -> Iterator[BaseGeometry]:
    """Yield a region across each road that ends at the network's edge, that leads only in or only out, or that goes on
    as a road which isn't imported.
    """
    west, south, east, north = extent
    inside = {id(node) for node, _ in _junctions(edges)}
    imported = set(map(id, edges))
    at = _by_node(edges)
    for node, own in at.values():
        if id(node) in inside:
            continue
        x, y = net.points([node.getCoord()])[0]
        one_way = len({at_end for _, at_end in own}) == 1
        goes_on = any(id(x) not in imported and is_road(x) for x in (*node.getIncoming(), *node.getOutgoing()))
        if one_way or goes_on or min(x - west, east - x, y - south, north - y) < AT_EDGE:
            lanes = [(lane, at_end) for edge, at_end in own for lane in _paved(edge)]
            lines = [(net.points(lane.getShape())[:: 1 if at_end else -1], lane.getWidth()) for lane, at_end in lanes]
            yield shapely.union_all([beyond_end(line, width) for line, width in lines if len(line) > 1])


def _junctions(edges: Sequence[Any]) -> Iterator[tuple[Any, list[tuple[Any, bool]]]]:
    """Yield the junctions that lead on, with their edges, and whether each of those ends there."""
    for node, own in _by_node(edges).values():
        others = {(edge.getFromNode() if at_end else edge.getToNode()).getID() for edge, at_end in own}
        if len(others) > 1 and any(leads_on(lane) for edge, at_end in own if at_end for lane in _paved(edge)):
            yield node, own


def ending_at_junctions(edges: Sequence[Any]) -> Iterator[Any]:
    """Yield the edges that end where some road leads on."""
    yield from (edge for _, own in _junctions(edges) for edge, at_end in own if at_end)


def leads_on(lane: Any) -> bool:
    """Return whether vehicles may go on from a lane to another road, and don't only turn back."""
    return any(x.getDirection() != BACK and not x.getTo().getFunction() for x in lane.getOutgoing())


def _by_node(edges: Iterable[Any]) -> dict[str, tuple[Any, list[tuple[Any, bool]]]]:
    found: dict[str, tuple[Any, list[tuple[Any, bool]]]] = {}
    for edge in edges:
        for node, at_end in ((edge.getFromNode(), False), (edge.getToNode(), True)):
            found.setdefault(node.getID(), (node, []))[1].append((edge, at_end))
    return found


def _paved(edge: Any) -> list[Any]:
    return [lane for lane in edge.getLanes() if is_roadway(lane) and len(lane.getShape()) > 1]


def _corners(net: SumoNet, edge: Any, at_end: bool) -> np.ndarray:
    """Return the corners of an edge's lanes (corner, 2) at its begin or its end [m]."""
    found = [np.zeros((0, 2))]
    for lane in _paved(edge):
        line = net.points(lane.getShape())[:: -1 if at_end else 1]
        if len(line) > 1:
            ahead = (line[1] - line[0]) / np.hypot(*(line[1] - line[0]))
            aside = lane.getWidth() / 2 * np.array([-ahead[1], ahead[0]])
            found.append(line[0] + np.stack([aside, -aside]))
    return np.concatenate(found)


def _polygon(points: np.ndarray) -> BaseGeometry:
    """Return the surface in an outline (point, 2), empty if it is none."""
    return surface(shapely.Polygon(points)) if len(points) > 2 else shapely.Polygon()
