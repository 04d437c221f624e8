"""Lanes of sources that map each lane by its line: they are rounded, and joined by ways that a car can drive."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely
import shapely.ops
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.generated.lane_paths import FROM_KERB, LaneBuilder, connect, gentle_way
from jaxwalk.maps.imported.kerb_ground import surface, unit
from jaxwalk.maps.imported.lane_net import STRAIGHT, SWATH, LaneNet, along, fits, heading
from jaxwalk.maps.imported.smoothing import rounded, without_gaps

SHORTEST = 2.0
"""A lane that is shorter is a part of the ways over it [m]."""
NARROW, PULLED = 3.0, 3.0
"""Lanes whose ends are nearer to each other than ``NARROW`` are cut by ``PULLED``, so that bends have room [m]."""
ROUNDS = 3
"""Lanes are cut again, so often, for ways that have no room."""
COARSE, LEAST_STRAIGHT = 0.6, 1.0
"""A mapped way with needless bends is simplified by this, and leaves its lanes straight for at least this long [m]."""
RADIUS = 12.0
"""Largest radius of an arc through a junction whose way isn't mapped [m]."""
MOST_OVER = 4
"""A way leads over at most this number of short lanes."""
BEYOND_END, BESIDE_END = 10.0, 4.0
"""How far the region across the end of a road reaches beyond it, and beside its lanes [m]."""


class MappedLane(NamedTuple):
    """A lane between two junctions."""

    line: np.ndarray
    """Its middle (point, 2), in the direction of travel [m]."""
    width: float
    """[m]"""
    limit: float
    """Speed limit [m/s]."""


class MappedTurn(NamedTuple):
    """That cars drive from one lane to another."""

    before: int
    after: int
    line: np.ndarray
    """The way as it is mapped (point, 2) [m]; without points if it isn't."""


def mapped_lane_net(
    lanes: Sequence[MappedLane], turns: Sequence[MappedTurn], roadway: BaseGeometry, junctions: Sequence[BaseGeometry]
) -> LaneNet:
    """Return the lanes with the ways between them, on a roadway that is wide enough for them.

    ``junctions`` are regions that no street's edge may cut.
    """
    lanes = _with_ends(lanes, turns)
    lines = [_smooth(lane.line) for lane in lanes]
    short = {n for n, line in enumerate(lines) if line is None or shapely.LineString(line).length < SHORTEST}
    whole = {n: line for n, line in enumerate(lines) if line is not None and n not in short}
    joined = _over_short(turns, short, lanes)
    clear = roadway.buffer(-FROM_KERB)
    shapely.prepare([clear, roadway])
    cut, ways = _ways(whole, joined, (clear, roadway))
    driven = [(turn, way) for turn, way in zip(joined, ways, strict=True) if way is not None]
    built = LaneBuilder()
    numbers: dict[int, int] = {}
    for chain, line in _chains(cut, driven, lanes):
        number = built.add(line, lanes[chain[0]].width, lanes[chain[0]].limit)
        numbers |= dict.fromkeys(chain, number)
    count = len(built.lines)
    for turn, way in driven:
        if numbers[turn.before] != numbers[turn.after]:
            connect(built, numbers[turn.before], way, numbers[turn.after])
    swaths = [shapely.LineString(way).buffer(SWATH, quad_segs=4) for way in ways if way is not None]
    ground = surface(without_gaps(shapely.union_all([roadway, *swaths])))
    inside = np.arange(len(built.lines)) >= count
    return LaneNet(built.lanes(), inside, ground, tuple(junctions), sum(way is None for way in ways))


def _chains(
    cut: dict[int, np.ndarray], driven: Sequence[tuple[MappedTurn, np.ndarray]], lanes: Sequence[MappedLane]
) -> Iterator[tuple[list[int], np.ndarray]]:
    """Yield lanes that follow each other without fork, merge or crossing as one, with its line, and the others."""
    into, out = Counter(turn.after for turn, _ in driven), Counter(turn.before for turn, _ in driven)
    lines = [shapely.LineString(way) for _, way in driven]
    met = Counter(shapely.STRtree(lines).query(lines, "intersects")[0].tolist()) if lines else Counter()
    onward = {
        turn.before: (turn.after, way) for number, (turn, way) in enumerate(driven)
        if out[turn.before] == into[turn.after] == met[number] == 1
        and lanes[turn.before][1:] == lanes[turn.after][1:]
    }  # fmt: skip
    later = {after for after, _ in onward.values()}
    used: set[int] = set()
    for first in sorted(cut, key=lambda n: n in later):  # those that follow nothing first; then closed roads
        chain, line = [first], [cut[first]]
        while first not in used and chain[-1] in onward and onward[chain[-1]][0] not in (*used, *chain):
            after, way = onward[chain[-1]]
            chain.append(after)
            line += [way, cut[after]]
        if first not in used:
            used |= set(chain)
            yield chain, np.concatenate(line)


def _ways(
    whole: dict[int, np.ndarray], turns: Sequence[MappedTurn], room: tuple[BaseGeometry, BaseGeometry]
) -> tuple[dict[int, np.ndarray], list[np.ndarray | None]]:
    """Return the lanes, cut where ways need room, and the way of each turn; None for one that has no room."""
    at_end = {x.before for x in turns if np.hypot(*(whole[x.after][0] - whole[x.before][-1])) < NARROW}
    at_begin = {x.after for x in turns if np.hypot(*(whole[x.after][0] - whole[x.before][-1])) < NARROW}
    cuts = {n: np.array([n in at_begin, n in at_end]) * PULLED for n in whole}
    cut: dict[int, np.ndarray] = {}
    ways: list[np.ndarray | None] = []
    for _ in range(ROUNDS):
        cut = {n: _cut(line, cuts[n]) for n, line in whole.items()}
        ways = [_way((cut[x.before], cut[x.after]), x.line, room) for x in turns]
        tight = [turn for turn, way in zip(turns, ways, strict=True) if way is None]
        for n in {turn.before for turn in tight}:
            cuts[n] = cuts[n] + (0.0, PULLED)
        for n in {turn.after for turn in tight}:
            cuts[n] = cuts[n] + (PULLED, 0.0)
        if not tight:
            break
    return cut, ways


def band(line: np.ndarray, width: float) -> BaseGeometry:
    """Return the ground of a lane along its line (point, 2); empty if that has no length."""
    smooth = _smooth(line) if len(line) > 1 else None
    return shapely.Polygon() if smooth is None else shapely.LineString(smooth).buffer(width / 2, cap_style="flat")


def beyond_end(line: np.ndarray, width: float) -> BaseGeometry:
    """Return the region from half a metre before the end of a lane on, some metres wider than the lane."""
    ahead = line[-1] - line[-2]
    ahead = ahead / np.hypot(*ahead)
    across = shapely.LineString([line[-1] - 0.5 * ahead, line[-1] + BEYOND_END * ahead])
    return across.buffer(width / 2 + BESIDE_END, cap_style="flat")


def _smooth(line: np.ndarray) -> np.ndarray | None:
    """Return a line (point, 2) with arcs at its corners, which ends where it did; None if it has no length."""
    curve = rounded(line)
    return None if curve is None else np.concatenate([curve.points[:-1], line[-1:]])


def _with_ends(lanes: Sequence[MappedLane], turns: Sequence[MappedTurn]) -> list[MappedLane]:
    """Return the lanes, with the last metres of a road where these are lanes of their own that lead nowhere."""
    onward: dict[int, list[MappedTurn]] = defaultdict(list)
    for turn in turns:
        onward[turn.before].append(turn)
    found = list(lanes)
    for before, own in onward.items():
        if all(x.after not in onward and shapely.LineString(lanes[x.after].line).length < SHORTEST for x in own):
            line = lanes[before].line
            ahead = line[-1] - line[-2]
            ends = [np.concatenate([x.line, lanes[x.after].line]) for x in own]
            straight = max(ends, key=lambda end: float(unit(end[-1] - line[-1]) @ ahead))
            found[before] = lanes[before]._replace(line=np.concatenate([line, straight]))
    return found


def _over_short(turns: Sequence[MappedTurn], short: set[int], lanes: Sequence[MappedLane]) -> list[MappedTurn]:
    """Return the turns between lanes that aren't short, some of them over short ones."""
    onward: dict[int, list[MappedTurn]] = defaultdict(list)
    for turn in turns:
        onward[turn.before].append(turn)
    found: dict[tuple[int, int], MappedTurn] = {}
    waiting = [(turn, 0) for turn in turns if turn.before not in short]
    while waiting:
        turn, over = waiting.pop(0)
        if turn.after not in short:
            found.setdefault((turn.before, turn.after), turn)
        elif over < MOST_OVER:
            line = np.concatenate([turn.line, lanes[turn.after].line])
            waiting += [
                (MappedTurn(turn.before, x.after, np.concatenate([line, x.line])), over + 1) for x in onward[turn.after]
            ]
    return [turn for turn in found.values() if turn.before != turn.after]


def _cut(line: np.ndarray, metres: np.ndarray) -> np.ndarray:
    """Return a line (point, 2) without some metres (2,) at its begin and its end, at most a third of it at each."""
    whole = shapely.LineString(line)
    begin, end = np.minimum(metres, whole.length / 3).tolist()
    return shapely.get_coordinates(shapely.ops.substring(whole, begin, whole.length - end)) if begin or end else line


def _way(
    lanes: tuple[np.ndarray, np.ndarray], mapped: np.ndarray, room: tuple[BaseGeometry, BaseGeometry]
) -> np.ndarray | None:
    """Return the line (point, 2) of a way from one lane to another: as mapped if it can be; None without room."""
    clear, roadway = room
    one, other = lanes
    headings = (heading(one[-2:]), heading(other[:2]))
    straight = np.stack([one[-1], other[0]])
    return next((x for x in _tries(straight, headings, mapped, clear) if fits(x, headings, roadway)), None)


def _tries(
    straight: np.ndarray, headings: tuple[float, float], mapped: np.ndarray, clear: BaseGeometry
) -> Iterator[np.ndarray]:
    """Yield lines (point, 2) between two ends (2, 2): first as mapped, then with fewer bends, then by our own rule."""
    for coarse, leg in ((0.0, STRAIGHT), (COARSE, STRAIGHT), (COARSE, LEAST_STRAIGHT)) if len(mapped) > 2 else ():
        inner = shapely.get_coordinates(shapely.simplify(shapely.LineString(mapped), coarse))
        yield along(straight, headings, inner, leg)
    turning = float(np.angle(np.exp(1j * (headings[1] - headings[0]))))
    yield gentle_way((straight[0], straight[1]), (headings[0], turning), RADIUS, clear)
