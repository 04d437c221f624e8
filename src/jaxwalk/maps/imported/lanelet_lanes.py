"""The lanes of Lanelet2 maps: lanelets that follow each other as one, and the ways over those that lie over others."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.imported.lanelet_ground import LaneletGround
from jaxwalk.maps.imported.lanelet_shapes import End, LaneletShape
from jaxwalk.maps.imported.mapped_lanes import PULLED, MappedLane, MappedTurn

LANE_WIDTHS = (2.0, 8.0)
"""Narrowest and widest lane [m]."""
MOST_OVER = 6
"""A way through a junction leads over at most this number of lanelets."""
AROUND_JOINT = 2.0
"""No street's edge comes closer than this to where lanes of different kinds meet [m]."""


class LaneletGraph(NamedTuple):
    """Lanes, the ways between them, and regions around their joints."""

    lanes: list[MappedLane]
    turns: list[MappedTurn]
    joints: list[BaseGeometry]


def lanelet_graph(driven: Sequence[LaneletShape], limits: Sequence[float], ground: LaneletGround) -> LaneletGraph:
    """Return the lanes of driven lanelets, with their speed limits [m/s]."""
    after = _followers(driven)
    before = _turned(after)
    inner = {n for n in ground.inner if after[n] and before[n]}
    chains = list(_chains(driven, limits, after, before, inner))
    number = {chain[0]: n for n, chain in enumerate(chains)}
    lanes = [_lane([driven[k] for k in chain], limits[chain[0]]) for chain in chains]
    turns: dict[tuple[int, int], MappedTurn] = {}
    paths = [(n, path) for n, chain in enumerate(chains) for path in _paths(chain[-1], after, inner)]
    for n, path in paths:
        line = np.concatenate([np.zeros((0, 2)), *(driven[k].middle for k in path[:-1])])
        turns.setdefault((n, number[path[-1]]), MappedTurn(n, number[path[-1]], line))
    joints = [_joint(driven[chains[n][-1]]) for n, path in paths if len(path) == 1]
    return LaneletGraph(lanes, list(turns.values()), joints)


def _followers(driven: Sequence[LaneletShape]) -> list[list[int]]:
    """Return for each lanelet the numbers of those that begin where it ends, other than itself in return."""
    begins: dict[End, list[int]] = defaultdict(list)
    for n, lanelet in enumerate(driven):
        begins[lanelet.end(0)].append(n)
    return [[k for k in begins[x.end(-1)] if driven[k].number != x.number] for x in driven]


def _turned(after: Sequence[Sequence[int]]) -> list[list[int]]:
    before: list[list[int]] = [[] for _ in after]
    for n, others in enumerate(after):
        for k in others:
            before[k].append(n)
    return before


def _chains(
    driven: Sequence[LaneletShape], limits: Sequence[float], after: Sequence[Sequence[int]],
    before: Sequence[Sequence[int]], inner: set[int],
) -> Iterator[list[int]]:  # fmt: skip
    """Yield the lanelets that follow each other between forks and merges, at one speed limit."""

    def onward(n: int) -> int | None:
        k = after[n][0] if len(after[n]) == 1 else None
        return k if k is not None and len(before[k]) == 1 and k not in inner and limits[k] == limits[n] else None

    outer = [n for n in range(len(driven)) if n not in inner]
    followed = {k for n in outer if (k := onward(n)) is not None}
    used: set[int] = set()
    for first in sorted(outer, key=lambda n: n in followed):  # those that follow nothing first; then closed roads
        if first in used:
            continue
        chain = [first]
        while (k := onward(chain[-1])) is not None and k not in used and k not in chain:
            chain.append(k)
        used |= set(chain)
        yield chain


def _lane(chain: Sequence[LaneletShape], limit: float) -> MappedLane:
    lengths = [shapely.LineString(x.middle).length for x in chain]
    width = float(np.clip(np.average([x.width for x in chain], weights=lengths), *LANE_WIDTHS))
    line = np.concatenate([chain[0].middle[:1], *(x.middle[1:] for x in chain)])
    return MappedLane(line, round(width, 2), limit)


def _paths(first: int, after: Sequence[Sequence[int]], inner: set[int]) -> Iterator[list[int]]:
    """Yield the lanelets on each way from one to the next that lies over no other."""
    waiting = [[k] for k in after[first]]
    while waiting:
        path = waiting.pop(0)
        if path[-1] not in inner:
            yield path
        elif len(path) <= MOST_OVER:
            waiting += [[*path, k] for k in after[path[-1]] if k not in path]


def _joint(lanelet: LaneletShape) -> BaseGeometry:
    across = shapely.LineString([lanelet.left[-1], lanelet.right[-1]])
    return across.buffer(PULLED + AROUND_JOINT)
