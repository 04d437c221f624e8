"""A street as CommonRoad's lanelets: a lanelet for each lane, each crosswalk and each way of people."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import shapely

from jaxwalk.formats.lane_edges import LaneEdges
from jaxwalk.formats.road_network import RoadNetwork, meets
from jaxwalk.maps.crosswalk_sides import CrosswalkFrame
from jaxwalk.maps.network import Network

NARROWEST, WIDEST = 0.5, 4.0
"""Widths of a way of people on a sidewalk [m]: as wide as its sidewalk, but no less and no more."""


def decimal(value: float | np.floating) -> str:
    """Return a number as text without an exponent, with six decimals at most."""
    return f"{float(value):.6f}".rstrip("0").rstrip(".")


def add_point(parent: ET.Element, x: float, y: float) -> None:
    """Add a point [m]."""
    point = ET.SubElement(parent, "point")
    for tag, value in (("x", x), ("y", y)):
        ET.SubElement(point, tag).text = decimal(value)


def add_lanelets(root: ET.Element, roads: RoadNetwork) -> None:
    """Add the lanelets of a street. Lane 0 has the id 1, and so on; crosswalks and ways of people follow."""
    lanes = roads.network.lanes
    edges = [roads.joints.edges((lane,)) for lane in range(len(lanes))]
    for number, (left, right, *_) in enumerate(edges):
        kind = "urban" if roads.junction[number] < 0 else "intersection"
        lanelet = _add_lanelet(root, 1 + number, left, right, kind)
        links = [("predecessor", n) for n, lane in enumerate(lanes) if number in lane.successors]
        links += [("successor", n) for n in lanes[number].successors]
        for tag, other in links:
            ET.SubElement(lanelet, tag, ref=str(1 + other))
        for tag, other, direction in _beside(number, edges):
            ET.SubElement(lanelet, tag, ref=str(1 + other), drivingDir=direction)
        ET.SubElement(lanelet, "laneletType").text = kind
        ET.SubElement(lanelet, "userOneWay").text = "vehicle"
    for id, (kind, left, right) in enumerate(_on_foot(roads.network), start=1 + len(lanes)):
        lanelet = _add_lanelet(root, id, left, right, kind)
        ET.SubElement(lanelet, "laneletType").text = kind
        ET.SubElement(lanelet, "userBidirectional").text = "pedestrian"


def _add_lanelet(root: ET.Element, id: int, left: np.ndarray, right: np.ndarray, kind: str) -> ET.Element:
    lanelet = ET.SubElement(root, "lanelet", id=str(id))
    for tag, points in (("leftBound", left), ("rightBound", right)):
        bound = ET.SubElement(lanelet, tag)
        for x, y in points.tolist():
            add_point(bound, x, y)
        ET.SubElement(bound, "lineMarking").text = "unknown" if kind == "urban" else "no_marking"
    return lanelet


def _beside(lane: int, edges: list[LaneEdges]) -> Iterator[tuple[str, int, str]]:
    """Yield the lanes that share an edge with a lane: tag, number, direction."""
    here = edges[lane]
    for tag, direction, edge, others in (
        ("adjacentLeft", "opposite", here.left, [x.left[::-1] for x in edges]),
        ("adjacentLeft", "same", here.left, [x.right for x in edges]),
        ("adjacentRight", "same", here.right, [x.left for x in edges]),
    ):
        shared = [n for n, other in enumerate(others) if n != lane and meets(edge, other)]
        yield from ((tag, other, direction) for other in shared[:1])


def _on_foot(network: Network) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yield kind, left and right bound of crosswalks and of ways on sidewalks."""
    nodes, crossed = network.walk.nodes, set()
    for crossing in network.crossings:
        crossed |= {frozenset(pair) for pair in pairwise(crossing.nodes)}
        for number in crossing.areas:
            frame = CrosswalkFrame.of(network.areas[number], nodes[list(crossing.nodes)])
            right, left = (frame.side(beside) for beside in frame.beside)
            yield "crosswalk", left, right
    edge_of_pavement = network.surface("sidewalk", "island").boundary
    for pair in network.walk.edges.tolist():
        if frozenset(pair) in crossed:
            continue
        begin, end = nodes[pair]
        room = edge_of_pavement.distance(shapely.Point((begin + end) / 2))
        ahead = (end - begin) / np.linalg.norm(end - begin)
        aside = np.array([-ahead[1], ahead[0]]) * np.clip(room, NARROWEST / 2, WIDEST / 2)
        yield "sidewalk", np.array([begin + aside, end + aside]), np.array([begin - aside, end - aside])
