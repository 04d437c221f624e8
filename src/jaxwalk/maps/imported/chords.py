"""Where a crossing leads over a roadway: from the line of people at one kerb straight to that at the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.imported.kerb_ground import KerbGround, polygons

REACH = 40.0
"""A kerb is looked for so far from a crossing's point [m]."""
LONGEST = 50.0
"""The longest way over a roadway, its islands included [m]."""
SHIFTS = (0.0, 1.0, -1.0, 2.0, -2.0)
"""A crossing may be moved by this along its road [m]."""
ANGLES = (0.0, 0.26, -0.26, 0.52, -0.52)
"""It may be turned by this from straight over [rad]."""
OBLIQUE = 0.8
"""Largest cosine of the angle between a way over a road and the road."""
NARROWEST_ISLAND, NARROWEST_ROADWAY = 1.0, 2.0
"""Least width of an island, and of a roadway, on the way [m]."""
AS_MAPPED = 1.3
"""The mapped direction is kept if the way is at most this many times as long as the shortest one."""
LEAST_HALF = 1.0
"""Half the width of the narrowest crosswalk [m]."""


class Chord(NamedTuple):
    """A straight way over a roadway."""

    ends: np.ndarray
    """The landings (2, 2) [m]."""
    walks: tuple[int, int]
    """The lines of people on which they lie."""
    places: tuple[float, float]
    """Where on them [m]."""
    over: np.ndarray
    """Where it enters and leaves each roadway, (roadway, 2) [m] from the first landing."""
    moved: float
    """How far it was moved [m]."""

    @property
    def length(self) -> float:
        """Its length [m]."""
        return float(np.hypot(*(self.ends[1] - self.ends[0])))

    @property
    def ahead(self) -> np.ndarray:
        """Unit vector from the first landing to the other."""
        return (self.ends[1] - self.ends[0]) / self.length

    def at(self, metres: float) -> np.ndarray:
        """Return the point (2,) at a distance from the first landing."""
        return self.ends[0] + metres * self.ahead

    def strip(self, begin: float, end: float, half: float) -> shapely.Polygon:
        """Return the rectangle along a part of it, ``half`` to each side [m]."""
        return shapely.LineString([self.at(begin), self.at(end)]).buffer(half, cap_style="flat")

    def areas(self, roadway: BaseGeometry, half: float) -> list[shapely.Polygon]:
        """Return the crosswalk on each roadway."""
        return [_part(self.strip(a - 1.5, b + 1.5, half).intersection(roadway), self.at((a + b) / 2))
                for a, b in self.over.tolist()]  # fmt: skip

    def islands(self, roadway: BaseGeometry, half: float) -> list[shapely.Polygon]:
        """Return the island between each two roadways."""
        return [_part(self.strip(a - 0.5, b + 0.5, half).difference(roadway), self.at((a + b) / 2))
                for (_, a), (b, _) in pairwise(self.over.tolist())]  # fmt: skip

    def aprons(self, roadway: BaseGeometry, half: float) -> list[shapely.Polygon]:
        """Return the ground between each landing and the roadway: pavement, also where a kerb bends away."""
        parts = [(0.0, self.over[0, 0], -0.3, 0.5), (self.over[-1, 1], self.length, -0.5, 0.3)]
        return [_part(self.strip(a + low, b + high, half).difference(roadway), self.at((a + b) / 2))
                for a, b, low, high in parts]  # fmt: skip

    def nodes(self) -> list[np.ndarray]:
        """Return the points between the landings: the middle of each roadway and of each island."""
        cuts = self.over.ravel()
        return [self.at(metres) for metres in (cuts[:-1] + cuts[1:]) / 2]


def _part(shape: BaseGeometry, point: np.ndarray) -> shapely.Polygon:
    """Return the polygon of a shape that is nearest to a point (2,)."""
    parts = polygons(shape, 0.0)
    return min(parts, key=lambda part: part.distance(shapely.Point(point)), default=shapely.Polygon())


class Chords:
    """The ways over the roadway of a street."""

    def __init__(self, ground: KerbGround) -> None:
        self.ground = ground
        self.tree = shapely.STRtree(list(ground.walks))
        shapely.prepare([ground.roadway, ground.filled])

    def best(
        self, point: np.ndarray, road: np.ndarray, mapped: np.ndarray | None = None, shifts: Sequence[float] = SHIFTS
    ) -> Chord | str:
        """Return the best way over the roadway at a point, or why there is none.

        Args:
            point: on the roadway (2,) [m].
            road: unit vector along the road (2,).
            mapped: unit vector of the mapped way (2,), if there is one.
            shifts: by how much it may be moved along the road [m].
        """
        straight = np.array([-road[1], road[0]])
        found = [x for x in self._tried(point, road, straight, shifts) if isinstance(x, Chord)]
        shortest = min(found, key=lambda x: x.length + abs(x.moved), default=None)
        if mapped is not None and abs(float(mapped @ road)) < OBLIQUE:
            own = self.at(point, mapped)
            if isinstance(own, Chord) and (shortest is None or own.length <= AS_MAPPED * shortest.length):
                return own
        return self.at(point, straight) if shortest is None else shortest

    def _tried(
        self, point: np.ndarray, road: np.ndarray, straight: np.ndarray, shifts: Sequence[float]
    ) -> Iterator[Chord | str]:
        for shift in shifts:
            for angle in ANGLES:
                turned = np.cos(angle) * straight + np.sin(angle) * road
                found = self.at(point + shift * road, turned)
                yield found._replace(moved=abs(shift)) if isinstance(found, Chord) else found

    def at(self, point: np.ndarray, across: np.ndarray) -> Chord | str:
        """Return the way over the roadway through a point in a direction (2,), or why there is none."""
        if not self.ground.filled.intersects(shapely.Point(point)):
            return "it lies on no roadway of the street"
        line = shapely.LineString([point - REACH * across, point + REACH * across])
        hits = [
            (float((place - point) @ across), walk)
            for walk in self.tree.query(line).tolist()
            for place in shapely.get_coordinates(line.intersection(self.ground.walks[walk]))
        ]
        before = max((hit for hit in hits if hit[0] < 0), default=None)
        after = min((hit for hit in hits if hit[0] > 0), default=None)
        if before is None or after is None:
            return "no pavement at one of its kerbs"
        ends = np.stack([point + before[0] * across, point + after[0] * across])
        if after[0] - before[0] > LONGEST:
            return f"the way to the other kerb is longer than {LONGEST:g} m"
        over = self._over(ends)
        if isinstance(over, str):
            return over
        walks = (before[1], after[1])
        one, other = (self.ground.walks[w].project(shapely.Point(end)) for w, end in zip(walks, ends, strict=True))
        return Chord(ends, walks, (float(one), float(other)), over, 0.0)

    def _over(self, ends: np.ndarray) -> np.ndarray | str:
        """Return where a line (2, 2) enters and leaves roadways (roadway, 2) [m], or why people can't cross there."""
        line = shapely.LineString(ends)
        parts = shapely.get_parts(line.intersection(self.ground.roadway)).tolist()
        lines = [shapely.get_coordinates(part) for part in parts if part.geom_type == "LineString" and part.length > 0]
        along = [sorted(float(np.hypot(*(point - ends[0]))) for point in (own[0], own[-1])) for own in lines]
        over = np.array(sorted(along)).reshape(-1, 2)
        if not len(over):
            return "it lies on no roadway of the street"
        if (over[:, 1] - over[:, 0]).min() < NARROWEST_ROADWAY:
            return "it only grazes a roadway"
        if len(over) > 1 and (over[1:, 0] - over[:-1, 1]).min() < NARROWEST_ISLAND:
            return f"an island of less than {NARROWEST_ISLAND:g} m"
        if over[0, 0] < 0.1 or over[-1, 1] > line.length - 0.1:
            return "no pavement at one of its kerbs"
        return over
