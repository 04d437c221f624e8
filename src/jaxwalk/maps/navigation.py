"""The navigation graph on foot: waypoints, crosswalk midpoints, and the shortest ways between them."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from jaxwalk.maps.file import MapFile

NEARLY = 1e-6
"""Lengths closer than this are equal [m]: far above rounding, far below anything a map means."""


class Graph(NamedTuple):
    """Waypoints in the order of the file, then one midpoint for each crosswalk."""

    names: list[str]
    """What to call each node in a message."""
    points: np.ndarray
    """float64 (node, 2) [m]."""
    edges: np.ndarray
    """int64 (edge, 2), smaller index first: the walkways' in the order of the file, then the crosswalks'."""
    waypoints: int
    """How many nodes are waypoints; the rest are midpoints."""


def build_graph(file: MapFile) -> Graph:
    """The graph of a map file. Joins with an unknown name or of a waypoint to itself are left out (and are faults)."""
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
    """Dijkstra over all nodes: lengths float64 (node, goal) [m], inf without a way, and next hops int64 (node, goal).

    The next hop is the node itself at its goal and where there is no way.
    """
    nodes = len(graph.points)
    first, second = graph.edges.T
    lengths = np.linalg.norm(graph.points[first] - graph.points[second], axis=1)
    matrix = csr_array((lengths, (first, second)), shape=(nodes, nodes))
    distance, before = dijkstra(matrix, directed=False, return_predecessors=True)
    # Walked backwards from the goal, the node before another is the one after it on the way to the goal.
    next_hop = np.where(before.T >= 0, before.T, np.arange(nodes)[:, None])
    return distance.T, next_hop


def goal_choices(graph: Graph, distance: np.ndarray, spacing: float) -> list[np.ndarray]:
    """For each node, the waypoints that can be walked to and are at least ``spacing`` metres of walking away."""
    to_waypoint = distance[:, : graph.waypoints]
    far = (to_waypoint >= spacing - NEARLY) & np.isfinite(to_waypoint)
    return [np.flatnonzero(row) for row in far]


def start_choices(graph: Graph, car: tuple[float, float], clearance: float) -> np.ndarray:
    """The waypoints at least ``clearance`` metres, as the crow flies, from a car at ``car`` (x, y)."""
    away = np.linalg.norm(graph.points[: graph.waypoints] - np.asarray(car), axis=1)
    return np.flatnonzero(away >= clearance - NEARLY)
