"""Lanes of sources that map each lane by its line: they are rounded, and joined by ways that a car can drive."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely
import shapely.ops
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.generated.lane_paths import FROM_KERB, LaneBuilder, connect, gentle_way
from jaxwalk.maps.imported.kerb_ground import surface
from jaxwalk.maps.imported.lane_net import SWATH, LaneNet, along, fits, heading
from jaxwalk.maps.imported.osm_ground import without_gaps
from jaxwalk.maps.imported.road_chains import rounded

SHORTEST = 2.0
"""A lane that is shorter is a part of the ways over it [m]."""
NARROW, PULLED = 3.0, 3.0
"""Lanes whose ends are nearer to each other than ``NARROW`` are cut by ``PULLED``, so that bends have room [m]."""
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
    lines = [_smooth(lane.line) for lane in lanes]
    short = {n for n, line in enumerate(lines) if line is None or shapely.LineString(line).length < SHORTEST}
    joined = _over_short(turns, short, lanes)
    pulled = _pulled(lines, joined)
    built = LaneBuilder()
    numbers = {}
    for n, line in enumerate(pulled):
        if line is not None and n not in short:
            numbers[n] = built.add(line, lanes[n].width, lanes[n].limit)
    count = len(built.lines)
    clear = roadway.buffer(-FROM_KERB)
    shapely.prepare([clear, roadway])
    ways = [_way(built, turn, numbers, (clear, roadway)) for turn in joined]
    for turn, way in zip(joined, ways, strict=True):
        if way is not None:
            connect(built, numbers[turn.before], way, numbers[turn.after])
    swaths = [shapely.LineString(way).buffer(SWATH, quad_segs=4) for way in ways if way is not None]
    whole = surface(without_gaps(shapely.union_all([roadway, *swaths])))
    return LaneNet(
        built.lanes(), np.arange(len(built.lines)) >= count, whole, tuple(junctions), sum(way is None for way in ways)
    )


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


def _pulled(lines: Sequence[np.ndarray | None], turns: Sequence[MappedTurn]) -> list[np.ndarray | None]:
    """Return the lines, shorter where a way from one to another has no length."""
    begins, ends = set(), set()
    for turn in turns:
        one, other = lines[turn.before], lines[turn.after]
        if one is not None and other is not None and np.hypot(*(other[0] - one[-1])) < NARROW:
            ends.add(turn.before)
            begins.add(turn.after)
    return [_cut(line, n in begins, n in ends) for n, line in enumerate(lines)]


def _cut(line: np.ndarray | None, at_begin: bool, at_end: bool) -> np.ndarray | None:
    if line is None or not (at_begin or at_end):
        return line
    whole = shapely.LineString(line)
    most = min(PULLED, whole.length / 3)
    return shapely.get_coordinates(shapely.ops.substring(whole, at_begin * most, whole.length - at_end * most))


def _way(
    built: LaneBuilder, turn: MappedTurn, numbers: dict[int, int], room: tuple[BaseGeometry, BaseGeometry]
) -> np.ndarray | None:
    """Return the line (point, 2) of a way from one lane to another: as mapped if it can be; None without room."""
    clear, roadway = room
    one, other = (built.lines[numbers[n]] for n in (turn.before, turn.after))
    headings = (heading(one[-2:]), heading(other[:2]))
    straight = np.stack([one[-1], other[0]])
    return next((x for x in _tries(straight, headings, turn.line, clear) if fits(x, headings, roadway)), None)


def _tries(
    straight: np.ndarray, headings: tuple[float, float], mapped: np.ndarray, clear: BaseGeometry
) -> Iterator[np.ndarray]:
    """Yield lines (point, 2) between two ends (2, 2), the mapped one first."""
    if len(mapped) > 2 and (line := along(straight, headings, mapped)) is not None:
        yield line
    turning = float(np.angle(np.exp(1j * (headings[1] - headings[0]))))
    yield gentle_way((straight[0], straight[1]), (headings[0], turning), RADIUS, clear)
