"""The people's side of a street: the walk graph along its sidewalks, and its crossings."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely
import shapely.ops

from jaxwalk.maps.generated.crossing_sites import ISLAND_ASIDE, Site, landings, nearest_walk
from jaxwalk.maps.generated.ground_shapes import Ground
from jaxwalk.maps.generated.town_plan import TownPlan
from jaxwalk.maps.network import Crossing, JaywalkZone, WalkGraph, along

PIECE, BENT = 5.0, 0.02
"""Longest piece of a jaywalk zone's kerb that turns by more than ``BENT`` [m, rad]; a straight kerb is one piece."""
WAYPOINT_EVERY = 24.0
"""Waypoints follow each other along a sidewalk at about this distance, or less [m]."""
STRAIGHTENED = 0.1
"""Ways may be so far from the middle of the sidewalk [m]."""
END = 0.5
"""A zone's sides go on beyond it by this [m]."""
SAME = 0.05
"""Nodes that are this close along a sidewalk are one [m]."""


class _Walks:
    """A walk graph while it grows."""

    def __init__(self, ground: Ground) -> None:
        self.ground = ground
        self.points: list[np.ndarray] = []
        self.is_waypoint: list[bool] = []
        self.edges: list[tuple[int, int]] = []
        self.on_walk: list[list[tuple[float, int]]] = [[] for _ in ground.walks]
        """For each sidewalk its nodes: how far along its middle [m], and their numbers."""
        self.straight: set[frozenset[int]] = set()
        """Neighbours that are joined without nodes between."""

    def add(self, point: np.ndarray, *, waypoint: bool = False) -> int:
        self.points.append(np.asarray(point, float))
        self.is_waypoint.append(waypoint)
        return len(self.points) - 1

    def add_at_kerb(self, point: np.ndarray, *, waypoint: bool = False) -> int:
        node, walk = self.add(point, waypoint=waypoint), nearest_walk(self.ground, point)
        self.on_walk[walk].append((self.ground.walks[walk].project(shapely.Point(point)), node))
        return node

    def renumbered(self) -> tuple[WalkGraph, np.ndarray]:
        """Return the graph, waypoints first, and each node's number in it."""
        order = np.argsort(~np.array(self.is_waypoint), kind="stable")
        number = np.argsort(order)
        edges = np.sort(number[np.array(self.edges)], axis=1)
        return WalkGraph(np.stack(self.points)[order], edges, sum(self.is_waypoint)), number


def make_walks(plan: TownPlan, ground: Ground, sites: list[Site], areas: list[tuple[int, ...]]) -> tuple[
    WalkGraph, tuple[Crossing, ...]
]:  # fmt: skip
    """Return the walk graph and the crossings; ``areas`` are the numbers of each site's crosswalk areas."""
    walks = _Walks(ground)
    chains, zones = [], []
    for site in sites:
        right, left = (walks.add_at_kerb(point, waypoint=True) for point in landings(plan, site))
        chains.append((right, *_over(walks, plan, site), left))
        zones.append(_zone(walks, plan, site, (right, left)))
    for chain in chains:
        walks.edges += pairwise(chain)
    for number in range(len(ground.walks)):
        _join(walks, number)
    graph, number = walks.renumbered()
    crossings = []
    for site, chain, zone, own in zip(sites, chains, zones, areas, strict=True):
        nodes = tuple(int(number[node]) for node in chain)
        if zone is not None:
            sides, begin, end = zone
            right, left = (tuple(int(number[n]) for n in side) for side in sides)
            zone = JaywalkZone((right, left), begin, end)
        crossings.append(Crossing(site.kind, own, nodes, zone))
    return graph, tuple(crossings)


def _over(walks: _Walks, plan: TownPlan, site: Site) -> list[int]:
    """Add the nodes of a crossing between its landings: the middle of each of its areas, and of its island."""
    road = plan.roads[site.road]
    right, left = -road.profile.right, road.profile.left
    if not site.island:
        return [walks.add(road.curve.beside(site.at, (right + left) / 2))]
    half = island_width(road.profile.median) / 2
    return [walks.add(road.curve.beside(site.at, offset)) for offset in ((right - half) / 2, 0.0, (left + half) / 2)]


def island_width(median: float) -> float:
    """Return the width of an island in a median [m]."""
    return median - 2 * ISLAND_ASIDE


def _zone(walks: _Walks, plan: TownPlan, site: Site, ends: tuple[int, int]) -> tuple | None:
    """Add the nodes of a site's zone; return its sides, its begin and its end [m along the middle]."""
    if site.zone is None:
        return None
    begin, end = site.zone
    curve, length = plan.roads[site.road].curve, end + END
    turn = abs(curve.heading(site.at) - curve.heading(site.at + site.outward * length))
    pieces = int(np.ceil(length / PIECE)) if turn > BENT else 1
    sides = ([ends[0]], [ends[1]])
    for n in range(1, pieces + 1):
        for side, point in zip(sides, landings(plan, site, site.outward * length * n / pieces), strict=True):
            side.append(walks.add_at_kerb(point, waypoint=n == pieces))
    walks.straight |= {frozenset(pair) for side in sides for pair in pairwise(side)}
    middle = np.stack([np.stack([walks.points[n] for n in side]) for side in sides]).mean(axis=0)
    scale = along(middle)[-1] / length  # the line half-way between the kerbs isn't quite the road's curve
    return sides, begin * scale, end * scale


def _join(walks: _Walks, number: int) -> None:
    """Join the nodes of one sidewalk one after the other, with waypoints between and nodes around bends."""
    line = walks.ground.walks[number]
    nodes = sorted(walks.on_walk[number])
    if not nodes or nodes[0][0] > SAME:
        nodes.insert(0, (0.0, walks.add(shapely.get_coordinates(line)[0], waypoint=True)))
    if nodes[-1][0] < line.length - SAME:
        nodes.append((line.length, walks.add(shapely.get_coordinates(line)[-1], waypoint=True)))
    for (begin, one), (end, other) in pairwise(nodes):
        if frozenset((one, other)) in walks.straight:
            walks.edges.append((one, other))
            continue
        cuts = np.linspace(begin, end, int(np.ceil((end - begin) / WAYPOINT_EVERY)) + 1)
        between = [walks.add(shapely.get_coordinates(line.interpolate(cut))[0], waypoint=True) for cut in cuts[1:-1]]
        for (low, first), (high, last) in pairwise(zip(cuts, [one, *between, other], strict=True)):
            piece = shapely.simplify(shapely.ops.substring(line, low, high), STRAIGHTENED)
            bends = [walks.add(point) for point in shapely.get_coordinates(piece)[1:-1]]
            walks.edges += pairwise([first, *bends, last])
