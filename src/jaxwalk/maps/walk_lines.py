"""A walk graph that grows along lines: the middles of sidewalks."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely
import shapely.ops

from jaxwalk.maps.network import WalkGraph

WAYPOINT_EVERY = 24.0
"""Waypoints follow each other along a sidewalk at about this distance, or less [m]."""
STRAIGHTENED = 0.1
"""Ways may be so far from the middle of the sidewalk [m]."""
SAME = 0.05
"""Nodes that are this close along a sidewalk are one [m]."""


class WalkLines:
    """Nodes on lines and beside them, which `join` joins."""

    def __init__(self, lines: Sequence[shapely.LineString]) -> None:
        self.lines = lines
        self.points: list[np.ndarray] = []
        self.is_waypoint: list[bool] = []
        self.edges: list[tuple[int, int]] = []
        self.on_line: list[list[tuple[float, int]]] = [[] for _ in lines]
        """For each line its nodes: how far along it [m], and their numbers."""
        self.straight: set[frozenset[int]] = set()
        """Neighbours that are joined without nodes between."""

    def add(self, point: np.ndarray, *, waypoint: bool = False) -> int:
        """Add a node that lies on no line, and return its number."""
        self.points.append(np.asarray(point, float))
        self.is_waypoint.append(waypoint)
        return len(self.points) - 1

    def add_on(self, line: int, point: np.ndarray, *, waypoint: bool = False) -> int:
        """Add a node on a line."""
        node = self.add(point, waypoint=waypoint)
        self.on_line[line].append((self.lines[line].project(shapely.Point(point)), node))
        return node

    def join(self, number: int) -> None:
        """Join the nodes of one line one after the other, with waypoints between and nodes around bends.

        A closed line is joined all around, from its first node on.
        """
        line, nodes = self.lines[number], sorted(self.on_line[number])
        closed = line.is_ring
        if closed and nodes:
            line, nodes = _from(line, nodes)
        if not nodes or nodes[0][0] > SAME:
            nodes.insert(0, (0.0, self.add(shapely.get_coordinates(line)[0], waypoint=True)))
        if nodes[-1][0] < line.length - SAME:
            nodes.append((line.length, self.add(shapely.get_coordinates(line)[-1], waypoint=True)))
        # Two nodes of a closed line may follow each other both ways around: only the shorter way is without nodes.
        for (begin, one), (end, other) in pairwise(nodes):
            is_shorter = not closed or end - begin <= line.length / 2
            if frozenset((one, other)) in self.straight and is_shorter:
                self.edges.append((one, other))
                continue
            cuts = np.linspace(begin, end, int(np.ceil((end - begin) / WAYPOINT_EVERY)) + 1)
            between = [self.add(shapely.get_coordinates(line.interpolate(cut))[0], waypoint=True) for cut in cuts[1:-1]]
            for (low, first), (high, last) in pairwise(zip(cuts, [one, *between, other], strict=True)):
                piece = shapely.simplify(shapely.ops.substring(line, low, high), STRAIGHTENED)
                bends = [self.add(point) for point in shapely.get_coordinates(piece)[1:-1]]
                self.edges += pairwise([first, *bends, last])

    def renumbered(self) -> tuple[WalkGraph, np.ndarray]:
        """Return the graph, waypoints first, and each node's number in it."""
        order = np.argsort(~np.array(self.is_waypoint), kind="stable")
        number = np.argsort(order)
        edges = np.sort(number[np.array(self.edges)], axis=1)
        return WalkGraph(np.stack(self.points)[order], edges, sum(self.is_waypoint)), number


def _from(
    line: shapely.LineString, nodes: list[tuple[float, int]]
) -> tuple[shapely.LineString, list[tuple[float, int]]]:
    """Return a closed line from its first node on, with the nodes on it; the first one is at both ends."""
    first = nodes[0][0]
    rest, seam = shapely.ops.substring(line, first, line.length), shapely.ops.substring(line, 0.0, first)
    points = np.concatenate([shapely.get_coordinates(rest), shapely.get_coordinates(seam)[1:]])
    turned = shapely.LineString(points)
    return turned, [*((place - first, node) for place, node in nodes), (turned.length, nodes[0][1])]
