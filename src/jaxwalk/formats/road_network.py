"""Roads for formats that need them: lanes side by side, and the ways through junctions between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from jaxwalk.formats.lane_edges import LaneEdges, LaneJoints
from jaxwalk.formats.tracks import TracksError
from jaxwalk.maps.junctions import LanePlaces, junction_of
from jaxwalk.maps.network import Network

MET = 0.1
"""Ends of edges that are this close are one place [m]."""


@dataclass(frozen=True)
class LaneGroup:
    """A road: lanes side by side. Its line is the left edge of its first lane that leads along it."""

    along: tuple[int, ...]
    """The lanes that lead along it, from the left."""
    against: tuple[int, ...]
    """The lanes that lead in the opposite direction, from the line outward."""

    def number(self, lane: int) -> int:
        """Return a lane's number in OpenDRIVE: -1, -2, ... along the road, and 1, 2, ... against it."""
        return -1 - self.along.index(lane) if lane in self.along else 1 + self.against.index(lane)

    def end_of(self, lane: int) -> int:
        """Return at which end of the road a lane ends: 0, where the road's line begins, or 1."""
        return int(lane in self.along)


@dataclass(frozen=True)
class Connection:
    """A way through a junction, from a lane of a road to one of another."""

    junction: int
    incoming: int
    """The lane from which it leads."""
    outgoing: int
    """The lane to which it leads."""
    lanes: tuple[int, ...]
    """The lanes in the junction."""


@dataclass(frozen=True)
class RoadNetwork:
    """The roads of a street; lanes have the numbers that they have in the network."""

    network: Network
    joints: LaneJoints
    junction: np.ndarray
    """The junction of each lane; -1 outside (`jaxwalk.maps.junctions`)."""
    roads: tuple[LaneGroup, ...]
    connections: tuple[Connection, ...]

    def road_of(self, lane: int) -> int:
        """Return the number of the road that a lane outside junctions belongs to."""
        return next(n for n, road in enumerate(self.roads) if lane in road.along or lane in road.against)

    def beyond(self, lane: int, *, end: bool) -> tuple[int, int] | None:
        """Return what lies beyond the end, or the begin, of a lane outside junctions.

        That is (junction, -1), or (-1, lane) for a lane that follows directly; None at the end of the street.
        """
        lanes = self.network.lanes
        found = lanes[lane].successors if end else [n for n, other in enumerate(lanes) if lane in other.successors]
        if not found:
            return None
        first = found[0]
        return (-1, first) if self.junction[first] < 0 else (int(self.junction[first]), -1)


def road_network(network: Network) -> RoadNetwork:
    """Return the roads of a street.

    Raises TracksError if a lane forks into one, or merges from one, that isn't a way from lane to lane.
    """
    places = LanePlaces.of(network.lanes)
    joints, junction = LaneJoints(network.lanes, places), junction_of(network.lanes, places)
    outside = np.flatnonzero(junction < 0).tolist()
    edges = {lane: joints.edges((lane,)) for lane in outside}
    bare = RoadNetwork(network, joints, junction, tuple(LaneGroup((lane,), ()) for lane in outside), ())
    grouped = _side_by_side(bare, edges)
    ways = tuple(way for lane in outside for way in _ways(network, junction, lane))
    return RoadNetwork(network, joints, junction, tuple(grouped), ways)


def _ways(network: Network, junction: np.ndarray, first: int) -> Iterator[Connection]:
    """Yield all ways through the junction at the end of a lane."""
    after = network.lanes[first].successors
    if any(junction[lane] < 0 for lane in after) and len(after) > 1:
        raise TracksError(f"lanes[{first}] forks into a lane that ends the street: add lanes[] between the two")
    for chain, last in _through(network, junction, (first,)):
        if len(chain) > 1:
            yield Connection(int(junction[chain[1]]), first, last, chain[1:])


def _through(
    network: Network, junction: np.ndarray, chain: tuple[int, ...]
) -> Iterator[tuple[tuple[int, ...], int]]:  # fmt: skip
    """Yield the ways on from the last of some lanes: all lanes up to the junction's end, and the one after it."""
    for lane in network.lanes[chain[-1]].successors:
        if junction[lane] < 0:
            yield chain, lane
        elif lane not in chain:
            yield from _through(network, junction, (*chain, lane))


def _side_by_side(bare: RoadNetwork, edges: dict[int, LaneEdges]) -> list[LaneGroup]:
    """Return roads of lanes whose edges are common and that lead from the same to the same."""
    free, found = list(edges), []
    while free:
        lane = free.pop(0)
        alike = [other for other in free if _same_ends(bare, lane, other)]
        rightward, leftward = (_neighbours(lane, alike, edges, left=left) for left in (False, True))
        along = (*leftward[::-1], lane, *rightward)
        against = _opposite(along[0], alike, edges)
        found.append(LaneGroup(along, against))
        free = [other for other in free if other not in along + against]
    return found


def _neighbours(lane: int, others: list[int], edges: dict[int, LaneEdges], *, left: bool) -> tuple[int, ...]:
    """Return the lanes beside a lane that lead in its direction, outward."""
    here = edges[lane].left if left else edges[lane].right
    for other in others:
        there = edges[other].right if left else edges[other].left
        if meets(here, there):
            return (other, *_neighbours(other, [n for n in others if n != other], edges, left=left))
    return ()


def _opposite(lane: int, others: list[int], edges: dict[int, LaneEdges]) -> tuple[int, ...]:
    """Return the lanes to the left of a lane that lead in the opposite direction, outward."""
    for other in others:
        if meets(edges[lane].left, edges[other].left[::-1]):
            return (other, *_neighbours(other, [n for n in others if n != other], edges, left=False))
    return ()


def meets(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two edges (point, 2) begin and end at the same places."""
    return bool(np.linalg.norm(one[[0, -1]] - other[[0, -1]], axis=1).max() < MET)


def _same_ends(bare: RoadNetwork, lane: int, other: int) -> bool:
    """Return whether two lanes lead from the same to the same, or the other way round, so that one road can."""

    def kinds(of: int) -> list[int | None]:
        found = [bare.beyond(of, end=end) for end in (False, True)]
        return [None if x is None else x[0] for x in found]  # -1 for every lane that follows

    return kinds(lane) in (kinds(other), kinds(other)[::-1])
