"""The car's side of a street: lanes, the ways through junctions, and routes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.generated.curve import SPACING
from jaxwalk.maps.generated.town_plan import TownPlan, TownRoad
from jaxwalk.maps.network import Lane, LaneRoute, along, without_repeats

AHEAD, ASIDE = 0.6, 0.3
"""A way that turns by less than ``AHEAD`` leads straight on [rad]; one that turns by less than ``ASIDE`` has no arc."""
GENTLE = 6.0
"""The first way with a larger radius than this is taken; if there is none, the one with the largest radius [m]."""
CHORD = 1.0
"""A bend is measured between pieces of about this length [m], so that single points of a line don't matter."""
ARC_SPACING = 0.25
"""Distance between the points of a way through a junction [m]."""
FROM_KERB = 1.25
"""The middle of a way through a junction stays at least this far from the kerb, if it can [m]."""
SHARES = (1.0, 0.75, 0.5, 0.35)
"""Parts of a way through a junction in which it may bend; the first one that stays clear of kerbs is taken."""
FROM_END = 8.0
"""Routes begin and end at this distance from the street's edge, or in the middle of a shorter lane [m]."""
MOST_ROUTES = 32
"""Most routes of a street."""
CRAWL = 20 / 3.6
"""Speed limit on a raised crosswalk [m/s]: 20 km/h."""


class SlowStretch(NamedTuple):
    """A stretch of a road with a speed limit of its own."""

    begin: float
    end: float


class Gate(NamedTuple):
    """The lanes of a road at a junction, in one direction: those that lead in, or those that lead out."""

    heading: float
    lanes: tuple[int, ...]
    """Numbers of the lanes, from the leftmost."""
    to_kerb: tuple[tuple[float, float], ...]
    """Distance of each lane's middle from the right and from the left kerb [m]."""
    road: int


class LaneBuilder:
    """Lanes while their successors are not known yet."""

    def __init__(self) -> None:
        self.lines: list[np.ndarray] = []
        self.widths: list[float] = []
        self.limits: list[float] = []
        self.next: list[list[int]] = []

    def add(self, line: np.ndarray, width: float, limit: float) -> int:
        """Add a lane and return its number."""
        straightened = shapely.get_coordinates(shapely.simplify(shapely.LineString(line), 1e-6))
        self.lines.append(without_repeats(straightened))
        self.widths.append(width)
        self.limits.append(limit)
        self.next.append([])
        return len(self.lines) - 1

    def lanes(self) -> tuple[Lane, ...]:
        """Return the lanes with their successors."""
        parts = zip(self.lines, self.widths, self.limits, self.next, strict=True)
        return tuple(Lane(line, width, limit, tuple(after)) for line, width, limit, after in parts)


def make_lanes(
    plan: TownPlan, roadway: shapely.Polygon, mouths: list[tuple[float, float]], slow: list[list[SlowStretch]]
) -> tuple[Lane, ...]:  # fmt: skip
    """Return the lanes of a street with their successors.

    Args:
        plan: the street.
        roadway: its roadway.
        mouths: for each road the places between which its kerbs run along it.
        slow: for each road the stretches of its raised crosswalks.
    """
    built = LaneBuilder()
    clear = roadway.buffer(-FROM_KERB)
    shapely.prepare(clear)
    gates_in: dict[int, list[Gate]] = {n: [] for n in range(len(plan.junctions))}
    gates_out: dict[int, list[Gate]] = {n: [] for n in range(len(plan.junctions))}
    for number, (road, ends) in enumerate(zip(plan.roads, mouths, strict=True)):
        for forward in (True, False):
            first, last = _road_lanes(built, road, ends, slow[number], forward)
            _gate(gates_out, number, road, first, (forward, False, ends))
            _gate(gates_in, number, road, last, (forward, True, ends))
    for junction in range(len(plan.junctions)):
        into, out = gates_in[junction], gates_out[junction]
        pairs = [(a, b) for a, b in product(range(len(into)), range(len(out))) if into[a].road != out[b].road]
        for before, after in joined_lanes(into, out, pairs):
            line = way_through(built, before, after, (plan.kerb_radius, clear))
            connect(built, before[0].lanes[before[1]], line, after[0].lanes[after[1]])
    return built.lanes()


def _road_lanes(
    built: LaneBuilder, road: TownRoad, ends: tuple[float, float], slow: list[SlowStretch], forward: bool
) -> tuple[list[int], list[int]]:
    """Add the lanes of one direction; return the numbers of their first and last pieces, from the leftmost lane."""
    cuts = sorted({*ends, *(x for stop in slow for x in stop)})
    firsts, lasts = [], []
    for number in range(road.profile.forward if forward else road.profile.backward):
        offset, pieces = road.profile.lane(forward, number), []
        for begin, end in list(pairwise(cuts))[:: 1 if forward else -1]:
            line = road.curve.parallel(offset, begin, end)
            raised = any(stop.begin <= begin and end <= stop.end for stop in slow)
            limit = min(road.speed_limit, CRAWL) if raised else road.speed_limit
            pieces.append(built.add(line if forward else line[::-1], road.profile.lane_width, limit))
        for one, other in pairwise(pieces):
            built.next[one].append(other)
        firsts.append(pieces[0])
        lasts.append(pieces[-1])
    return firsts, lasts


def _gate(
    gates: dict[int, list[Gate]], number: int, road: TownRoad, lanes: list[int],
    where: tuple[bool, bool, tuple[float, float]],
) -> None:  # fmt: skip
    """Add the lanes of a road to the gates of the junction at which they begin or end."""
    forward, last, ends = where
    at_end = int(forward == last)
    junction = road.junctions[at_end]
    if junction is None or not lanes:
        return
    profile, kerbs = road.profile, []
    for lane in range(len(lanes)):
        offset = profile.lane(forward, lane)
        from_right, from_left = offset + profile.right, profile.left - offset
        kerbs.append((from_right, from_left) if forward else (from_left, from_right))
    heading = road.curve.heading(ends[at_end]) + (0.0 if forward else np.pi)
    gates[junction].append(Gate(heading, tuple(lanes), tuple(kerbs), number))


def joined_lanes(
    into: list[Gate], out: list[Gate], pairs: list[tuple[int, int]]
) -> Iterator[tuple[tuple[Gate, int], tuple[Gate, int]]]:
    """Yield the lanes that a junction joins: so that each lane leads somewhere, and each is reached.

    ``pairs`` are the numbers of the gates between which cars may drive.
    """
    pairs = sorted(pairs, key=lambda pair: abs(turning(into[pair[0]], out[pair[1]])))
    found = {((a, i), (b, j)) for a, b in pairs for i, j in _matching(into[a], out[b])}
    straightest_out = {a: b for a, b in reversed(pairs)}
    straightest_in = {b: a for a, b in reversed(pairs)}
    for a, i in _lanes_of(into) - {before for before, _ in found}:
        if (b := straightest_out.get(a)) is not None:
            found.add(((a, i), (b, min(i, len(out[b].lanes) - 1))))
    for b, j in _lanes_of(out) - {after for _, after in found}:
        if (a := straightest_in.get(b)) is not None:
            found.add(((a, min(j, len(into[a].lanes) - 1)), (b, j)))
    for (a, i), (b, j) in sorted(found):
        yield (into[a], i), (out[b], j)


def _lanes_of(gates: list[Gate]) -> set[tuple[int, int]]:
    """Return the number of the gate, and that in the gate, of all lanes."""
    return {(n, lane) for n, gate in enumerate(gates) for lane in range(len(gate.lanes))}


def turning(before: Gate, after: Gate) -> float:
    """Return the angle from one heading to another [rad], positive to the left."""
    return float(np.angle(np.exp(1j * (after.heading - before.heading))))


def _matching(before: Gate, after: Gate) -> list[tuple[int, int]]:
    """Return the lanes of two gates that a driver takes: straight on in line, turns in the outermost lane."""
    turn, many, places = turning(before, after), len(before.lanes), len(after.lanes)
    if abs(turn) < AHEAD:
        return [(many - 1 - n, places - 1 - n) for n in range(min(many, places))]
    return [(0, 0)] if turn > 0 else [(many - 1, places - 1)]


def way_through(
    built: LaneBuilder, before: tuple[Gate, int], after: tuple[Gate, int], room: tuple[float, BaseGeometry]
) -> np.ndarray:
    """Return the line (point, 2) from one lane to another through a junction.

    ``room`` is the radius of its kerbs [m], and where the middle of a way may lie.
    """
    (gate_in, i), (gate_out, j) = before, after
    one, other = gate_in.lanes[i], gate_out.lanes[j]
    turn = turning(gate_in, gate_out)
    side = int(turn > 0)
    radius = room[0] + min(gate_in.to_kerb[i][side], gate_out.to_kerb[j][side])
    ends = built.lines[one][-1], built.lines[other][0]
    return gentle_way(ends, (gate_in.heading, turn), radius, room[1])


def connect(built: LaneBuilder, one: int, line: np.ndarray, other: int) -> None:
    """Add the lane along a line from one lane to another."""
    way = built.add(line, min(built.widths[one], built.widths[other]), min(built.limits[one], built.limits[other]))
    built.next[one].append(way)
    built.next[way].append(other)


def gentle_way(
    ends: tuple[np.ndarray, np.ndarray], turn: tuple[float, float], radius: float, clear: BaseGeometry
) -> np.ndarray:
    """Return a line (point, 2) from one place to another: one that isn't tight and stays clear of kerbs, if it can.

    Args:
        ends: the places.
        turn: the heading at the first one, and the angle by which it turns, positive to the left [rad].
        radius: the largest radius of an arc [m].
        clear: where the line should stay.
    """
    lines = [smooth_way(ends, *turn, share) for share in SHARES]
    arc = arc_way(ends, *turn, radius) if abs(turn[1]) >= ASIDE else None
    lines = lines if arc is None else [arc, *lines]
    inside = [line for line in lines if clear.covers(shapely.LineString(line))] or lines[:1]
    return next((line for line in inside if smallest_radius(line) >= GENTLE), max(inside, key=smallest_radius))


def smooth_way(ends: tuple[np.ndarray, np.ndarray], heading: float, turn: float, share: float = 1.0) -> np.ndarray:
    """Return a line (point, 2) that bends over a share of the way, in its middle, and is straight before and after."""
    begin, end = ends
    ahead, after = (np.array([np.cos(angle), np.sin(angle)]) for angle in (heading, heading + turn))
    straight = (1 - share) / 2 * np.linalg.norm(end - begin)
    one, other = begin + straight * ahead, end - straight * after
    handle = 0.4 * np.linalg.norm(other - one)
    curve = _bezier(np.stack([one, one + handle * ahead, other - handle * after, other]))
    return without_repeats(np.concatenate([begin[None], curve, end[None]]), 1e-3)


def arc_way(ends: tuple[np.ndarray, np.ndarray], heading: float, turn: float, radius: float) -> np.ndarray | None:
    """Return an arc of at most a radius between straight pieces, (point, 2); None if their lines don't meet between."""
    begin, end = ends
    ahead, after = (np.array([np.cos(angle), np.sin(angle)]) for angle in (heading, heading + turn))
    legs = np.linalg.solve(np.stack([ahead, after], axis=1), end - begin)
    if legs.min() <= 0:
        return None
    bend = np.tan(abs(turn) / 2)
    radius = min(radius, legs.min() / bend)
    start = begin + (legs[0] - radius * bend) * ahead
    to_left = np.array([-ahead[1], ahead[0]])
    angle = np.linspace(0, turn, int(np.ceil(abs(turn) * radius / ARC_SPACING)) + 1)
    sideways = np.sign(turn) * (1 - np.cos(angle))
    arc = start + radius * (np.sin(np.abs(angle))[:, None] * ahead + sideways[:, None] * to_left)
    return without_repeats(np.concatenate([begin[None], arc, end[None]]), 1e-3)


def smallest_radius(line: np.ndarray) -> float:
    """Return the radius of the tightest bend of a line (point, 2) [m], huge if it is straight."""
    metres = along(line)
    at = np.linspace(0, metres[-1], max(int(metres[-1] / CHORD), 1) + 1)
    steps = np.diff(np.stack([np.interp(at, metres, line[:, k]) for k in (0, 1)], axis=1), axis=0)
    turns = np.abs(np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))))
    return float(at[1] / max(turns.max(initial=0.0), 1e-9))


def _bezier(points: np.ndarray) -> np.ndarray:
    """Return the cubic curve of four points (4, 2)."""
    share = np.linspace(0, 1, int(np.ceil(np.linalg.norm(points[3] - points[0]) / SPACING)) + 1)[:, None]
    a, b, c, d = points
    return (1 - share) ** 3 * a + 3 * (1 - share) ** 2 * share * b + 3 * (1 - share) * share**2 * c + share**3 * d


def make_routes(lanes: tuple[Lane, ...]) -> tuple[LaneRoute, ...]:
    """Return the shortest way from every lane that begins at the street's edge to every one that ends there.

    If there are more than `MOST_ROUTES`, every second, third, ... is left out.
    """
    followed = {after for lane in lanes for after in lane.successors}
    routes = []
    for first in (n for n in range(len(lanes)) if n not in followed):
        ways = _ways_from(lanes, first)
        routes += [_route(lanes, way) for last, way in sorted(ways.items()) if not lanes[last].successors]
    chosen = np.unique(np.linspace(0, len(routes) - 1, MOST_ROUTES).round().astype(int)) if routes else []
    return tuple(routes) if len(routes) <= MOST_ROUTES else tuple(routes[n] for n in chosen)


def _ways_from(lanes: tuple[Lane, ...], first: int) -> dict[int, tuple[int, ...]]:
    """Return the way with the fewest lanes from one lane to each that it leads to."""
    ways = {first: (first,)}
    waiting = [first]
    while waiting:
        here = waiting.pop(0)
        found = {after: (*ways[here], after) for after in lanes[here].successors if after not in ways}
        ways |= found
        waiting += found
    return ways


def _route(lanes: tuple[Lane, ...], way: tuple[int, ...]) -> LaneRoute:
    first, last = (float(along(lanes[n].line)[-1]) for n in (way[0], way[-1]))
    return LaneRoute(way, min(FROM_END, first / 2), last - min(FROM_END, last / 2))
