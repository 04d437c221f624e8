"""The lanes of OpenStreetMap's roads: along chains, and through junctions, where short chains between nodes vanish."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.generated.lane_paths import (
    FROM_KERB,
    Gate,
    LaneBuilder,
    connect,
    joined_lanes,
    turning,
    way_through,
)
from jaxwalk.maps.imported.lane_net import SWATH, LaneNet, along, fits, heading
from jaxwalk.maps.imported.osm_ground import sides
from jaxwalk.maps.imported.road_chains import RoadChain
from jaxwalk.maps.imported.smoothing import KERB_RADIUS, without_gaps

SHORTEST = 4.0
"""A chain that has less than this left between its mouths is a part of the junction [m]."""
U_TURN = 2.6
"""Nobody turns by more than this [rad]."""
AROUND = 2.0
"""A junction's region reaches this far beyond its lanes [m]."""


@dataclass
class _Cluster:
    """The nodes of a junction, with the lanes that lead in and out."""

    into: list[Gate] = field(default_factory=list)
    out: list[Gate] = field(default_factory=list)
    nodes_in: list[int] = field(default_factory=list)
    """The node of each gate that leads in."""
    nodes_out: list[int] = field(default_factory=list)
    places: list[np.ndarray] = field(default_factory=list)
    """Points of its roads [m]."""


def lane_net(chains: Sequence[RoadChain], roadway: BaseGeometry, ends: Sequence[tuple[float, float]]) -> LaneNet:
    """Return the lanes of all chains; ``ends`` are the places between which the kerbs of each run along it."""
    built = LaneBuilder()
    inside = [high - low < SHORTEST for low, high in ends]
    clusters = _clusters(chains, inside)
    by_cluster: dict[int, _Cluster] = defaultdict(_Cluster)
    for number, chain in enumerate(chains):
        for end, node in enumerate(chain.ends):
            own = [chain.curve.points[-end]] if inside[number] else []  # the first point, or the last
            by_cluster[clusters[node]].places += own
        if not inside[number]:
            _add_lanes(built, (number, chain), ends[number], clusters, by_cluster)
    count, ways, no_turns = len(built.lines), [], 0
    clear = roadway.buffer(-FROM_KERB)
    shapely.prepare([clear, roadway])
    inner = _Inner(chains, inside)
    for cluster in by_cluster.values():
        made = list(_through(built, cluster, inner, (clear, roadway)))
        ways += [line for line in made if line is not None]
        no_turns += sum(line is None for line in made)
    swaths = [shapely.LineString(line).buffer(SWATH, quad_segs=4) for line in ways]
    whole = without_gaps(shapely.union_all([roadway, *swaths]))
    junctions = tuple(
        shapely.MultiPoint(np.array(x.places)).convex_hull.buffer(AROUND) for x in by_cluster.values() if len(x.places)
        and len(x.into) + len(x.out) > 2
    )  # fmt: skip
    return LaneNet(built.lanes(), np.arange(len(built.lines)) >= count, whole, junctions, no_turns)


def _clusters(chains: Sequence[RoadChain], inside: Sequence[bool]) -> dict[int, int]:
    """Return the junction of each node: nodes that a short chain joins have the same."""
    cluster = {node: node for chain in chains for node in chain.ends}

    def root(node: int) -> int:
        while cluster[node] != node:
            node = cluster[node]
        return node

    for chain, short in zip(chains, inside, strict=True):
        if short:
            cluster[root(chain.ends[0])] = root(chain.ends[1])
    return {node: root(node) for node in cluster}


def _add_lanes(
    built: LaneBuilder, numbered: tuple[int, RoadChain], between: tuple[float, float], clusters: dict[int, int],
    by_cluster: dict[int, _Cluster],
) -> None:  # fmt: skip
    """Add the lanes of a chain, and its gates to the junctions at its ends."""
    number, chain = numbered
    profile = chain.profile
    for forward in (True, False):
        offsets = [profile.offset(forward, n) for n in range(profile.forward if forward else profile.backward)]
        if not offsets:
            continue
        lines = [chain.curve.parallel(offset, *between) for offset in offsets]
        lanes = tuple(built.add(line if forward else line[::-1], profile.lane_width, profile.limit) for line in lines)
        for leaving in (True, False):
            end = int(forward == leaving)
            right, left = sides(chain, chain.pieces[-1 if end else 0])
            kerbs = tuple((x + right, left - x) if forward else (left - x, x + right) for x in offsets)
            heading = chain.curve.heading(between[end]) + (0.0 if forward else np.pi)
            gate = Gate(heading, lanes, kerbs, number)
            cluster = by_cluster[clusters[chain.ends[end]]]
            (cluster.into if leaving else cluster.out).append(gate)
            (cluster.nodes_in if leaving else cluster.nodes_out).append(chain.ends[end])
            cluster.places += [built.lines[lane][-1 if leaving else 0] for lane in lanes]


class _Inner:
    """The chains inside junctions: which nodes they lead from and to."""

    def __init__(self, chains: Sequence[RoadChain], inside: Sequence[bool]) -> None:
        self.onward: dict[int, list[tuple[int, np.ndarray]]] = defaultdict(list)
        """By node: the nodes that it leads to, and the lines to them."""
        for chain, short in zip(chains, inside, strict=True):
            (begin, end), line = chain.ends, chain.curve.points
            if short and chain.profile.forward:
                self.onward[begin].append((end, line))
            if short and chain.profile.backward:
                self.onward[end].append((begin, line[::-1]))

    def ways(self, node: int) -> dict[int, np.ndarray]:
        """Return the nodes that a node leads to, itself among them, with a line (point, 2) to each."""
        found = {node: np.zeros((0, 2))}
        waiting = [node]
        while waiting:
            here = waiting.pop(0)
            for there, line in (ahead for ahead in self.onward[here] if ahead[0] not in found):
                found[there] = np.concatenate([found[here], line])
                waiting.append(there)
        return found


def _through(
    built: LaneBuilder, cluster: _Cluster, inner: _Inner, room: tuple[BaseGeometry, BaseGeometry]
) -> Iterator[np.ndarray | None]:
    """Add the ways through a junction and yield their lines; None for each turn that has no room."""
    clear, roadway = room
    ways = [inner.ways(node) for node in cluster.nodes_in]
    pairs = [
        (a, b) for a, b in product(range(len(cluster.into)), range(len(cluster.out)))
        if cluster.into[a].road != cluster.out[b].road and cluster.nodes_out[b] in ways[a]
        and abs(turning(cluster.into[a], cluster.out[b])) < U_TURN
    ]  # fmt: skip
    place_in = {id(gate): n for n, gate in enumerate(cluster.into)}
    place_out = {id(gate): n for n, gate in enumerate(cluster.out)}
    for before, after in joined_lanes(cluster.into, cluster.out, pairs):
        inner_line = ways[place_in[id(before[0])]].get(cluster.nodes_out[place_out[id(after[0])]])
        line = way_through(built, before, after, (KERB_RADIUS, clear))
        one, other = built.lines[before[0].lanes[before[1]]], built.lines[after[0].lanes[after[1]]]
        headings = (heading(one[-2:]), heading(other[:2]))
        if inner_line is not None and len(inner_line) and not fits(line, headings, roadway):
            line = along(line, headings, inner_line)
        if not fits(line, headings, roadway):
            yield None
            continue
        connect(built, before[0].lanes[before[1]], line, after[0].lanes[after[1]])
        yield line
