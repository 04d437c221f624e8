"""The people's side of a street: the walk graph along its sidewalks, and its crossings."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from jaxwalk.maps.generated.crossing_sites import ISLAND_ASIDE, Site, landings, nearest_walk
from jaxwalk.maps.generated.ground_shapes import Ground
from jaxwalk.maps.generated.town_plan import TownPlan
from jaxwalk.maps.network import Crossing, JaywalkZone, WalkGraph, along
from jaxwalk.maps.walk_lines import WalkLines

PIECE, BENT = 5.0, 0.02
"""Longest piece of a jaywalk zone's kerb that turns by more than ``BENT`` [m, rad]; a straight kerb is one piece."""
END = 0.5
"""A zone's sides go on beyond it by this [m]."""


def make_walks(plan: TownPlan, ground: Ground, sites: list[Site], areas: list[tuple[int, ...]]) -> tuple[
    WalkGraph, tuple[Crossing, ...]
]:  # fmt: skip
    """Return the walk graph and the crossings; ``areas`` are the numbers of each site's crosswalk areas."""
    walks = WalkLines(ground.walks)
    chains, zones = [], []
    for site in sites:
        right, left = (_add_at_kerb(walks, ground, point, waypoint=True) for point in landings(plan, site))
        chains.append((right, *_over(walks, plan, site), left))
        zones.append(_zone(walks, (plan, ground), site, (right, left)))
    for chain in chains:
        walks.edges += pairwise(chain)
    for number in range(len(ground.walks)):
        walks.join(number)
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


def _add_at_kerb(walks: WalkLines, ground: Ground, point: np.ndarray, *, waypoint: bool = False) -> int:
    return walks.add_on(nearest_walk(ground, point), point, waypoint=waypoint)


def _over(walks: WalkLines, plan: TownPlan, site: Site) -> list[int]:
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


def _zone(walks: WalkLines, town: tuple[TownPlan, Ground], site: Site, ends: tuple[int, int]) -> tuple | None:
    """Add the nodes of a site's zone; return its sides, its begin and its end [m along the middle]."""
    if site.zone is None:
        return None
    plan, ground = town
    begin, end = site.zone
    curve, length = plan.roads[site.road].curve, end + END
    turn = abs(curve.heading(site.at) - curve.heading(site.at + site.outward * length))
    pieces = int(np.ceil(length / PIECE)) if turn > BENT else 1
    sides = ([ends[0]], [ends[1]])
    for n in range(1, pieces + 1):
        for side, point in zip(sides, landings(plan, site, site.outward * length * n / pieces), strict=True):
            side.append(_add_at_kerb(walks, ground, point, waypoint=n == pieces))
    walks.straight |= {frozenset(pair) for side in sides for pair in pairwise(side)}
    middle = np.stack([np.stack([walks.points[n] for n in side]) for side in sides]).mean(axis=0)
    scale = along(middle)[-1] / length  # the line half-way between the kerbs isn't quite the road's curve
    return sides, begin * scale, end * scale
