"""Roads of OpenStreetMap as chains: from junction to junction, or to where their lanes change, each with a curve."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from jaxwalk.maps.generated.curve import Curve
from jaxwalk.maps.imported.osm_reading import OsmData, OsmWay
from jaxwalk.maps.imported.osm_tags import LaneProfile, is_road, road_facts
from jaxwalk.maps.imported.smoothing import rounded


class ChainPiece(NamedTuple):
    """The part of a chain that is of one way."""

    way: OsmWay
    turned: bool
    """Whether the chain follows the way from its end to its begin."""
    begin: float
    """[m] along the chain."""
    end: float


@dataclass(frozen=True)
class RoadChain:
    """A road without junctions between its ends."""

    ends: tuple[int, int]
    """Numbers of the nodes at its begin and its end."""
    curve: Curve
    profile: LaneProfile
    pieces: tuple[ChainPiece, ...]
    nodes: dict[int, float]
    """Where its nodes lie [m]."""

    @property
    def length(self) -> float:
        """Its length [m]."""
        return float(self.curve.metres[-1])


class _Segment(NamedTuple):
    """A straight piece of a way, from one node to the next."""

    way: OsmWay
    begin: int
    end: int
    profile: LaneProfile


def road_chains(data: OsmData) -> list[RoadChain]:
    """Return all roads; what two ways have in common counts once."""
    segments: dict[frozenset[int], _Segment] = {}
    for way in (way for way in data.ways if is_road(way.tags)):
        profile = road_facts(way.tags).profile
        for a, b in pairwise(way.nodes):
            segments.setdefault(frozenset((a, b)), _Segment(way, a, b, profile))
    at: dict[int, list[_Segment]] = defaultdict(list)
    for segment in segments.values():
        at[segment.begin].append(segment)
        at[segment.end].append(segment)
    found = [_chain(data, path) for path in _paths(at)]
    return [chain for chain in found if chain is not None]


def _paths(at: dict[int, list[_Segment]]) -> Iterator[list[tuple[_Segment, bool]]]:
    """Yield paths of segments between breaks, each with whether it is followed backward."""
    used: set[int] = set()
    nodes = sorted(at, key=lambda node: not _breaks(node, at[node]))  # breaks first; the others begin closed roads
    for node, segment in ((x, segment) for x in nodes for segment in at[x]):
        if id(segment) not in used:
            yield _follow(at, node, segment, used)


def _breaks(node: int, own: list[_Segment]) -> bool:
    """Return whether a chain ends at a node: where roads meet or end, or lanes change."""
    if len(own) != 2:
        return True
    into, out = own
    before = into.profile if into.end == node else into.profile.turned()
    after = out.profile if out.begin == node else out.profile.turned()
    return before != after


def _follow(at: dict[int, list[_Segment]], node: int, segment: _Segment, used: set[int]) -> list[tuple[_Segment, bool]]:
    """Return the path from a node along a segment to the next break, or around to the node."""
    path, begin = [], node
    while True:
        used.add(id(segment))
        turned = segment.end == node
        path.append((segment, turned))
        node = segment.begin if turned else segment.end
        onward = [other for other in at[node] if id(other) not in used]
        if node == begin or _breaks(node, at[node]) or not onward:
            return path
        segment = onward[0]


def _chain(data: OsmData, path: list[tuple[_Segment, bool]]) -> RoadChain | None:
    """Return the chain of a path; None if it has no length."""
    nodes = [path[0][0].end if path[0][1] else path[0][0].begin]
    nodes += [segment.begin if turned else segment.end for segment, turned in path]
    line = np.array([data.places[node] for node in nodes])
    first, turned = path[0]
    profile = first.profile.turned() if turned else first.profile
    curve = rounded(line)
    if curve is None:
        return None
    places = _places(line, curve)
    pieces: list[ChainPiece] = []
    for number, (segment, against) in enumerate(path):
        low, high = places[number], places[number + 1]
        last = pieces[-1] if pieces else None
        if last is not None and last.way is segment.way and last.turned == against:
            pieces[-1] = last._replace(end=high)
        else:
            pieces.append(ChainPiece(segment.way, against, low, high))
    where = dict(zip(nodes, places, strict=True))
    return RoadChain((nodes[0], nodes[-1]), curve, profile, tuple(pieces), where)


def _places(line: np.ndarray, curve: Curve) -> list[float]:
    """Return where the points of a line lie on its curve [m], rising."""
    shape = shapely.LineString(curve.points)
    near = np.array([shape.project(shapely.Point(place)) for place in line])
    near[0], near[-1] = 0.0, curve.metres[-1]
    return np.maximum.accumulate(near).tolist()
