"""The pedestrians' navigation graph: waypoints, crosswalk midpoints, and the shortest ways between them."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from jaxwalk.maps.file import MapFile

NEARLY = 1e-6
"""Lengths that differ by less are equal [m]: far above rounding errors, far below any real distance on a map."""


class Graph(NamedTuple):
    """Waypoints in the order of the file, then one midpoint for each crosswalk."""

    names: list[str]
    """Name of each node in messages."""
    points: np.ndarray
    """float64 (node, 2) [m]."""
    edges: np.ndarray
    """int64 (edge, 2), smaller index first: the walkways' in the order of the file, then the crosswalks'."""
    waypoints: int
    """Number of nodes that are waypoints; the rest are midpoints."""


def build_graph(file: MapFile) -> Graph:
    """Build the graph of a map file. It leaves out faults: unknown names, and waypoints joined to themselves."""
    index = {name: number for number, name in enumerate(file.waypoints)}
    middles = [((c.area[0] + c.area[2]) / 2, (c.area[1] + c.area[3]) / 2) for c in file.crosswalks.values()]
    joins = [
        tuple(sorted((index[a], index[b])))
        for chain in file.walkways.values()
        for a, b in pairwise(chain)
        if a in index and b in index and a != b
    ]
    for number, crosswalk in enumerate(file.crosswalks.values()):
        landings = [index[side.landing] for side in crosswalk.sides if side.landing in index]
        joins += [(landing, len(index) + number) for landing in landings]
    return Graph(
        names=[*file.waypoints, *(f"the middle of crosswalk {name}" for name in file.crosswalks)],
        points=np.array([*file.waypoints.values(), *middles], float).reshape(-1, 2),
        edges=np.array(list(dict.fromkeys(joins)), int).reshape(-1, 2),
        waypoints=len(index),
    )


def shortest_ways(graph: Graph) -> tuple[np.ndarray, np.ndarray]:
    """Run Dijkstra's algorithm over all nodes.

    Returns the lengths float64 (node, goal) [m], inf without a way, and the next hops int64 (node, goal). At the goal,
    and without a way, the next hop is the node itself.
    """
    nodes = len(graph.points)
    first, second = graph.edges.T
    lengths = np.linalg.norm(graph.points[first] - graph.points[second], axis=1)
    matrix = scipy.sparse.csr_array((lengths, (first, second)), shape=(nodes, nodes))
    distance, before = scipy.sparse.csgraph.dijkstra(matrix, directed=False, return_predecessors=True)
    # On the way from a goal, the node before another one is the next hop on the way to the goal.
    next_hop = np.where(before.T >= 0, before.T, np.arange(nodes)[:, None])
    return distance.T, next_hop


def goal_choices(graph: Graph, distance: np.ndarray, spacing: float) -> list[np.ndarray]:
    """Return for each node the waypoints that a pedestrian can reach by a walk of at least ``spacing`` metres."""
    to_waypoint = distance[:, : graph.waypoints]
    far = (to_waypoint >= spacing - NEARLY) & np.isfinite(to_waypoint)
    return [np.flatnonzero(row) for row in far]


def start_choices(graph: Graph, car: tuple[float, float], clearance: float) -> np.ndarray:
    """Return the waypoints at least ``clearance`` metres, in a straight line, from a car at ``car`` (x, y) [m]."""
    away = np.linalg.norm(graph.points[: graph.waypoints] - np.asarray(car), axis=1)
    return np.flatnonzero(away >= clearance - NEARLY)
