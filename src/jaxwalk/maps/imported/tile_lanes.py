"""The car's side of an imported street: the lanes in its region, and routes that meet its crossings."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely
import shapely.ops
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.generated.lane_paths import FROM_END, smallest_radius
from jaxwalk.maps.imported.kerb_ground import line_parts
from jaxwalk.maps.imported.source_map import SourceMap
from jaxwalk.maps.network import Lane, LaneRoute, without_repeats

SHORTEST_LANE = 3.0
"""A shorter piece of a lane at the street's edge is left out [m]."""
ENDS = 0.03
"""A lane ends where the roadway does if it is so close to its edge [m]."""
TIGHTEST_DRIVEN = 4.6
"""Routes lead over no lane that bends with a smaller radius [m]. The car turns within 4.54 m; ways through
junctions are made with a little more (`lane_net`), because places are rounded later."""
LONGEST_ROUTE, SHORTEST_ROUTE = 220.0, 40.0
"""Length of routes [m]: 220 m at 30 km/h take 26 s of an episode's 50."""
LONGEST_DRIVE, ORACLE_LEVEL = 40.0, 5 / 3
"""A route takes at most this long [s] at the largest multiple of ``ORACLE_LEVEL`` [m/s] within the speed limit: the
oracle plans in such levels, so that it drives at 6 km/h where 10 km/h are allowed. Maps can't import policies, so a
test compares it with `jaxwalk.policies.oracle.LEVEL`, which is less by 0.0007 m/s."""
MOST_ROUTES = 32
"""Most routes of a street, unless its crossings need more."""
BEFORE = 8.0
"""A route meets a crossing if it begins at least this far before it [m]."""
REACH = 80.0
"""A crossing that no route between the street's edges meets gets one from and to this far around it [m]."""


class _Piece(NamedTuple):
    """A part of a lane."""

    line: np.ndarray
    lane: int
    begins: bool
    """Whether it has the lane's begin."""
    ends: bool
    """Whether it has its end."""


def lanes_within(source: SourceMap, region: BaseGeometry, roadway: BaseGeometry) -> tuple[list[Lane], np.ndarray]:
    """Return the lanes in a region, and which of them lead through junctions.

    A lane through a junction is left out if it isn't wholly inside, and so is whatever then leads nowhere.
    """
    shapely.prepare(region)
    pieces: list[_Piece] = []
    for number in _near(source, region):
        lane = source.lanes[number]
        line = shapely.LineString(lane.line)
        if region.covers(line):
            pieces.append(_Piece(lane.line, number, True, True))
        elif not source.in_junction[number]:
            pieces += [_piece(part, number, lane) for part in line_parts(line.intersection(region), SHORTEST_LANE)]
    kept = _that_lead_somewhere(source, pieces, roadway)
    begins = {piece.lane: k for k, piece in enumerate(kept) if piece.begins}
    lanes = []
    for piece in kept:
        lane = source.lanes[piece.lane]
        after = tuple(begins[x] for x in lane.successors if x in begins) if piece.ends else ()
        lanes.append(Lane(piece.line, lane.width, lane.speed_limit, after))
    return lanes, np.array([source.in_junction[piece.lane] for piece in kept], bool)


def _near(source: SourceMap, region: BaseGeometry) -> list[int]:
    low_x, low_y, high_x, high_y = region.bounds
    return [
        n for n, lane in enumerate(source.lanes)
        if (lane.line.max(axis=0) >= (low_x, low_y)).all() and (lane.line.min(axis=0) <= (high_x, high_y)).all()
    ]  # fmt: skip


def _piece(part: shapely.LineString, number: int, lane: Lane) -> _Piece:
    """Return a part of a lane, in the direction of travel."""
    line = shapely.get_coordinates(part)
    whole = shapely.LineString(lane.line)
    first, last = (whole.project(shapely.Point(line[k])) for k in (0, -1))
    line = line if first <= last else line[::-1]
    begins, ends = (bool(np.hypot(*(line[k] - lane.line[k])) < 1e-6) for k in (0, -1))
    return _Piece(line, number, begins, ends)


def _that_lead_somewhere(source: SourceMap, pieces: Sequence[_Piece], roadway: BaseGeometry) -> list[_Piece]:
    """Return the pieces that have successors, or end where the roadway does."""
    edge = roadway.boundary
    at_edge = {id(piece) for piece in pieces if edge.distance(shapely.Point(piece.line[-1])) <= ENDS}
    kept = list(pieces)
    while True:
        begins = {piece.lane for piece in kept if piece.begins}
        good = [
            piece for piece in kept if id(piece) in at_edge
            or (piece.ends and any(x in begins for x in source.lanes[piece.lane].successors))
        ]  # fmt: skip
        if len(good) == len(kept):
            return kept
        kept = good


def without_lanes(
    lanes: Sequence[Lane], in_junction: np.ndarray, bad: set[int], roadway: BaseGeometry
) -> tuple[list[Lane], np.ndarray]:
    """Return lanes and which of them lead through junctions, without bad ones and what then leads nowhere."""
    edge = roadway.boundary
    at_edge = [edge.distance(shapely.Point(lane.line[-1])) <= ENDS for lane in lanes]
    kept = [n for n in range(len(lanes)) if n not in bad]
    while True:
        good = [n for n in kept if at_edge[n] or any(x in kept for x in lanes[n].successors)]
        if len(good) == len(kept):
            break
        kept = good
    number = {n: k for k, n in enumerate(kept)}
    found = [replace(lanes[n], successors=tuple(number[x] for x in lanes[n].successors if x in number)) for n in kept]
    return found, in_junction[kept]


def _planned(limit: float) -> float:
    """Return the speed at which the oracle drives under a speed limit [m/s]."""
    return ORACLE_LEVEL * max(np.floor(limit / ORACLE_LEVEL + 0.01), 1.0)


class RouteFinder:
    """Finds routes over lanes that the car can drive."""

    def __init__(self, lanes: Sequence[Lane]) -> None:
        self.lanes = lanes
        self.lengths = [lane.length() for lane in lanes]
        self.good = [smallest_radius(lane.line) >= TIGHTEST_DRIVEN for lane in lanes]
        self.worth = [max(1.0, LONGEST_ROUTE / (LONGEST_DRIVE * _planned(lane.speed_limit))) for lane in lanes]
        """Metres of a route's greatest length that a metre of a lane takes: more than one where cars are slow."""
        self.followed = {after for lane in lanes for after in lane.successors}

    def routes(self, crosswalks: Sequence[Sequence[shapely.Polygon]]) -> tuple[list[LaneRoute], list[bool]]:
        """Return routes, and which of the crossings (each given by its areas) some route meets."""
        whole = [shapely.union_all(list(areas)) for areas in crosswalks]
        candidates = [route for way in self._ways() for route in self._cut(way)]
        candidates = [route for route in candidates if self._length(route) >= SHORTEST_ROUTE]
        met = [self._met(route, whole) for route in candidates]
        chosen: list[int] = []
        left = set(range(len(whole)))
        while left and (best := max(range(len(met)), key=lambda n: len(met[n] & left), default=None)) is not None:
            if not met[best] & left:
                break
            chosen.append(best)
            left -= met[best]
        others = [n for n in range(len(candidates)) if n not in chosen and (met[n] or not whole)]
        room = max(MOST_ROUTES - len(chosen), 0)
        chosen += [others[n] for n in np.unique(np.linspace(0, len(others) - 1, min(room, len(others))).astype(int))]
        found = [candidates[n] for n in sorted(chosen)]
        for crossing in sorted(left):
            extra = self._past(whole[crossing])
            if extra is not None and crossing in self._met(extra, whole):
                found.append(extra)
                left.discard(crossing)
        return found, [n not in left for n in range(len(whole))]

    def _ways(self) -> Iterator[tuple[int, ...]]:
        """Yield the shortest way from each lane that begins at the street's edge to each that ends there."""
        for first in range(len(self.lanes)):
            if first not in self.followed and self.good[first]:
                ways = self._from(first)
                yield from (way for last, way in sorted(ways.items()) if not self.lanes[last].successors)

    def _from(self, first: int) -> dict[int, tuple[int, ...]]:
        """Return the shortest way from a lane to each that it leads to."""
        found: dict[int, tuple[int, ...]] = {}
        waiting: list[tuple[float, tuple[int, ...]]] = [(self.lengths[first], (first,))]
        while waiting:
            metres, way = heapq.heappop(waiting)
            if way[-1] in found:
                continue
            found[way[-1]] = way
            onward = [after for after in self.lanes[way[-1]].successors if after not in found and self.good[after]]
            for after in onward:
                heapq.heappush(waiting, (metres + self.lengths[after], (*way, after)))
        return found

    def _cut(self, way: tuple[int, ...]) -> Iterator[LaneRoute]:
        """Yield the routes along a way: one, or several that overlap where it is too long for one."""
        first, last = self.lengths[way[0]], self.lengths[way[-1]]
        begin, end = min(FROM_END, first / 2), sum(self.lengths[n] for n in way) - min(FROM_END, last / 2)
        metres, worth = self._along(way)
        low, high = np.interp([begin, end], metres, worth).tolist()
        count = int(np.ceil((high - low) / LONGEST_ROUTE))
        if count <= 1:
            yield self._route(way, begin, end)
            return
        for start in np.linspace(low, high - LONGEST_ROUTE, count + 1).tolist():
            begin, end = np.interp([start, start + LONGEST_ROUTE], worth, metres).tolist()
            yield self._route(way, begin, end)

    def _along(self, way: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
        """Return how far the ends of a way's lanes lie from its begin, and what that takes of a longest route [m]."""
        lengths = np.array([self.lengths[n] for n in way])
        worth = np.array([self.worth[n] for n in way])
        metres, taken = (np.concatenate([[0.0], np.cumsum(each)]) for each in (lengths, lengths * worth))
        return metres, taken

    def _route(self, way: Sequence[int], begin: float, end: float) -> LaneRoute:
        """Return the route between two places of a way [m]."""
        ends = np.cumsum([self.lengths[n] for n in way])
        low = int(np.searchsorted(ends, begin, side="right"))
        high = min(int(np.searchsorted(ends, end, side="left")), len(way) - 1)
        before = [0.0, *ends.tolist()]
        goal = min(end - before[high], self.lengths[way[high]])
        return LaneRoute(tuple(way[low : high + 1]), max(begin - before[low], 0.0), goal)

    def _length(self, route: LaneRoute) -> float:
        return sum(self.lengths[n] for n in route.lanes[:-1]) + route.goal - route.start

    def _met(self, route: LaneRoute, crosswalks: Sequence[BaseGeometry]) -> set[int]:
        """Return the crossings that a route leads over, some metres after its start."""
        line = shapely.LineString(without_repeats(np.concatenate([self.lanes[n].line for n in route.lanes])))
        begin = route.start + BEFORE
        driven = shapely.ops.substring(line, begin, route.start + self._length(route))
        return {n for n, area in enumerate(crosswalks) if driven.intersects(area)}

    def _past(self, crosswalk: BaseGeometry) -> LaneRoute | None:
        """Return a route over a crosswalk from and to some way around it."""
        over = [
            n
            for n, lane in enumerate(self.lanes)
            if self.good[n] and shapely.LineString(lane.line).intersects(crosswalk)
        ]
        for lane in over:
            way = [lane]
            while self._metres(way, lane) < REACH and (before := self._before(way[0], way)) is not None:
                way.insert(0, before)
            while (
                self._metres(way[way.index(lane) :], way[-1]) < REACH
                and (after := self._after(way[-1], way)) is not None
            ):
                way.append(after)
            total = sum(self.lengths[n] for n in way)
            begin = min(1.0, self.lengths[way[0]] / 4)
            if total - 2 * begin >= SHORTEST_ROUTE:
                at = sum(self.lengths[n] for n in way[: way.index(lane)]) + self.lengths[lane] / 2
                metres, worth = self._along(way)
                low, middle, high = np.interp([begin, at, total - begin], metres, worth).tolist()
                low = max(low, middle - LONGEST_ROUTE / 2)
                ends = np.interp([low, min(high, low + LONGEST_ROUTE)], worth, metres).tolist()
                return self._route(way, *ends)
        return None

    def _metres(self, way: Sequence[int], until: int) -> float:
        """Return the metres of a way up to the begin of one of its lanes."""
        return sum((self.lengths[n] for n in way[: list(way).index(until)]), 0.0)

    def _before(self, lane: int, way: Sequence[int]) -> int | None:
        leading = [n for n, x in enumerate(self.lanes) if lane in x.successors and self.good[n] and n not in way]
        return leading[0] if leading else None

    def _after(self, lane: int, way: Sequence[int]) -> int | None:
        return next((n for n in self.lanes[lane].successors if self.good[n] and n not in way), None)
