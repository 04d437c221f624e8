"""Where the pavement along each line of people is from: mapped, inferred from tags, joined, or invented."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np
import shapely
import shapely.ops

from jaxwalk.maps.imported.source_map import Origin, WalkEvidence

STEP = 2.0
"""A line of people is looked at in pieces of about this length [m]."""
PARALLEL = 0.87
"""Cosine of the largest angle between a line of people and what speaks of it: 30 degrees."""
JOINED = 15.0
"""A gap in what the source says, up to this length, is closed: corners of junctions, driveways [m]."""
SHORTEST = 1.0
"""A shorter part of a line of people is left out [m]."""
RANK: tuple[Origin, ...] = ("mapped", "inferred", "invented")


class Stretch(NamedTuple):
    """A part of a line of people."""

    walk: int
    begin: float
    """[m] along the line."""
    end: float
    origin: Origin
    joined: bool = False
    """Whether it closes a gap between parts that aren't invented."""

    @property
    def metres(self) -> float:
        """Its length [m]."""
        return self.end - self.begin


class KerbEvidence:
    """All that the source says of sidewalks, ready to be asked."""

    def __init__(self, evidence: Sequence[WalkEvidence]) -> None:
        pairs = [(x.line[:-1], x.line[1:], RANK.index(x.origin), x.reach) for x in evidence if len(x.line) > 1]
        begins = np.concatenate([x[0] for x in pairs]) if pairs else np.zeros((0, 2))
        ends = np.concatenate([x[1] for x in pairs]) if pairs else np.zeros((0, 2))
        steps = ends - begins
        self.ahead = steps / np.maximum(np.hypot(*steps.T), 1e-9)[:, None]
        self.rank = np.concatenate([np.full(len(x[0]), x[2]) for x in pairs]) if pairs else np.zeros(0, int)
        self.reach = np.concatenate([np.full(len(x[0]), x[3]) for x in pairs]) if pairs else np.zeros(0)
        self.tree = shapely.STRtree([shapely.LineString(piece) for piece in np.stack([begins, ends], axis=1)])
        self.farthest = float(self.reach.max(initial=0.0))

    def stretches(self, walks: Sequence[shapely.LineString]) -> list[Stretch]:
        """Return all lines in stretches of one origin."""
        return [stretch for number, walk in enumerate(walks) for stretch in self._of(number, walk)]

    def _of(self, number: int, walk: shapely.LineString) -> list[Stretch]:
        count = max(round(walk.length / STEP), 1)
        cuts = np.linspace(0, walk.length, count + 1)
        points = shapely.get_coordinates(shapely.line_interpolate_point(walk, cuts))
        ranks = self._ranks(points[:-1], points[1:])
        found, first = [], 0
        for rank, group in groupby(ranks.tolist()):
            last = first + len(list(group))
            found.append(Stretch(number, float(cuts[first]), float(cuts[last]), RANK[rank]))
            first = last
        return _closed(found, ring=walk.is_ring)

    def _ranks(self, begins: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """Return the best rank of what speaks of each piece, int (piece,)."""
        ranks = np.full(len(begins), len(RANK) - 1)
        if not len(self.rank):
            return ranks
        middles = np.array([shapely.Point(place) for place in (begins + ends) / 2])
        piece, said = self.tree.query(middles, "dwithin", distance=self.farthest)
        ahead = (ends - begins) / np.maximum(np.hypot(*(ends - begins).T), 1e-9)[:, None]
        near = shapely.distance(middles[piece], self.tree.geometries[said]) <= self.reach[said]
        near &= np.abs((ahead[piece] * self.ahead[said]).sum(axis=1)) >= PARALLEL
        np.minimum.at(ranks, piece[near], self.rank[said[near]])
        return ranks


def _closed(stretches: list[Stretch], *, ring: bool) -> list[Stretch]:
    """Return the stretches of a line with short gaps between parts that aren't invented closed.

    A gap of a closed line may lie across the line's begin and end.
    """
    last = len(stretches) - 1
    across = ring and last > 0 and stretches[0].origin == stretches[last].origin == "invented"

    def known(number: int) -> bool:
        inside = 0 <= number <= last or (ring and last > 0)
        return inside and stretches[number % len(stretches)].origin != "invented"

    def is_gap(number: int) -> bool:
        metres, before, after = stretches[number].metres, number - 1, number + 1
        if across and number in (0, last):
            metres, before, after = stretches[0].metres + stretches[last].metres, last - 1, 1
        return metres <= JOINED and known(before) and known(after)

    return [
        stretch._replace(origin="inferred", joined=True) if stretch.origin == "invented" and is_gap(n) else stretch
        for n, stretch in enumerate(stretches)
    ]


def touching(stretches: Sequence[Stretch], walks: Sequence[shapely.LineString]) -> Iterator[tuple[int, int]]:
    """Yield the numbers of each two stretches that follow each other, also where a closed line begins and ends."""
    for walk, group in groupby(range(len(stretches)), lambda n: stretches[n].walk):
        own = list(group)
        yield from pairwise(own)
        if len(own) > 1 and walks[walk].is_ring:
            yield own[-1], own[0]


def known_lines(walks: Sequence[shapely.LineString], stretches: Sequence[Stretch]) -> Iterator[shapely.LineString]:
    """Yield the parts of lines of people that aren't invented, those that touch as one."""
    for number, group in groupby(stretches, lambda stretch: stretch.walk):
        yield from (line for line in _known(walks[number], list(group)) if line.length > SHORTEST)


def _known(walk: shapely.LineString, stretches: Sequence[Stretch]) -> list[shapely.LineString]:
    """Return the parts of a line of people that aren't invented; a closed one may go on where it begins."""
    runs = [list(run) for known, run in groupby(stretches, lambda x: x.origin != "invented") if known]
    if len(runs) == 1 and len(runs[0]) == len(stretches):
        return [walk]
    parts = [shapely.get_coordinates(shapely.ops.substring(walk, run[0].begin, run[-1].end)) for run in runs]
    if len(parts) > 1 and walk.is_ring and "invented" not in (stretches[0].origin, stretches[-1].origin):
        parts[0] = np.concatenate([parts.pop(), parts[0][1:]])
    return [shapely.LineString(part) for part in parts]
