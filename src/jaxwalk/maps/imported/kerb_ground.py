"""The ground beside a roadway: medians, pavement along the kerbs, and the lines on which people walk there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

PAVEMENT = 2.5
"""Width of the sidewalks [m]."""
WIDEST_MEDIAN = 6.0
"""A narrower gap between roadways is a median: nobody walks along it [m]."""
FINEST = 0.05
"""The lines of people are simplified by at most this [m]."""
NOOK = 0.3
"""A gap with more than this share of its edge along the pavement is a nook of it, and no median."""
INSIDE = 1.0
"""People walk up to this distance from a street's edge [m]."""
SHORTEST = 5.0
"""A shorter line of people is left out [m]."""


class KerbGround(NamedTuple):
    """Shapes [m]."""

    roadway: BaseGeometry
    filled: BaseGeometry
    """The roadway with its medians."""
    medians: BaseGeometry
    pavement: BaseGeometry
    walks: tuple[shapely.LineString, ...]
    """The lines of people: the middle of the pavement."""

    @classmethod
    def along(cls, roadway: BaseGeometry) -> KerbGround:
        """Return the ground along a roadway."""
        half = WIDEST_MEDIAN / 2
        filled = roadway.buffer(half, join_style="mitre").buffer(-half, join_style="mitre").union(roadway)
        edge = filled.boundary.buffer(0.05)
        gaps = [part for part in shapely.get_parts(filled.difference(roadway)).tolist() if part.area > 0.05]
        nooks = [gap for gap in gaps if gap.boundary.intersection(edge).length > NOOK * gap.boundary.length]
        medians = [gap for gap in gaps if not any(gap is nook for nook in nooks)]
        pavement = shapely.union_all([filled.buffer(PAVEMENT).difference(filled), *nooks])
        middle = filled.buffer(PAVEMENT / 2).simplify(FINEST)
        rings = shapely.get_parts(shapely.get_rings(shapely.get_parts(middle)))
        walks = tuple(shapely.LineString(ring.coords) for ring in rings.tolist())
        return cls(roadway, filled, shapely.union_all(medians), pavement.difference(roadway), walks)

    def within(self, region: BaseGeometry) -> KerbGround:
        """Return the part of the ground in a region."""
        inner = region.buffer(-INSIDE, join_style="mitre")
        shapely.prepare(inner)
        lines: list[shapely.LineString] = []
        for walk in self.walks:
            if inner.intersects(walk):
                lines += [walk] if inner.covers(walk) else line_parts(walk.intersection(inner), SHORTEST)
        roadway, filled, medians, pavement = (surface(shape.intersection(region)) for shape in self[:4])
        return KerbGround(roadway, filled, medians, pavement, tuple(lines))

    def beside(self, road: BaseGeometry) -> KerbGround:
        """Return the part of the ground that belongs to a road, given as a roadway with its medians."""
        at, along = road.buffer(0.05), road.buffer(PAVEMENT + 0.05)
        shapely.prepare(along)
        walks = tuple(walk for walk in self.walks if along.covers(walk))
        roadway, filled, medians = (surface(shape.intersection(at)) for shape in self[:3])
        return KerbGround(roadway, filled, medians, surface(self.pavement.intersection(along)), walks)

    def with_walks(self, walks: list[shapely.LineString]) -> KerbGround:
        """Return the ground with other lines of people, and pavement only along them."""
        along = shapely.union_all([walk.buffer(PAVEMENT / 2 + 0.3, cap_style="flat") for walk in walks])
        return self._replace(walks=tuple(walks), pavement=surface(self.pavement.intersection(along)))


def line_parts(shape: BaseGeometry, shortest: float = 0.0) -> list[shapely.LineString]:
    """Return the lines of a shape, those that touch as one, without those that are too short [m]."""
    lines = [part for part in shapely.get_parts(shape).tolist() if part.geom_type == "LineString" and part.length > 0]
    merged = shapely.get_parts(shapely.line_merge(shapely.MultiLineString(lines))).tolist() if lines else []
    return [part for part in merged if part.length >= shortest]


def surface(shape: BaseGeometry) -> BaseGeometry:
    """Return only the polygons of a shape: an intersection may have lines and points too."""
    return shapely.union_all(polygons(shape))


def polygons(shape: BaseGeometry, smallest: float = 0.05) -> list[shapely.Polygon]:
    """Return the polygons of a shape that aren't smaller than an area [m2]."""
    sound = shapely.make_valid(
        shape, method="structure", keep_collapsed=False
    )  # results of overlays may touch themselves
    parts = shapely.get_parts(sound).tolist()
    nested = [inner for part in parts for inner in shapely.get_parts(part).tolist()]
    return [part for part in nested if part.geom_type == "Polygon" and part.area >= smallest]


def unit(vector: np.ndarray) -> np.ndarray:
    """Return a vector (2,) with a length of 1."""
    return vector / max(float(np.hypot(*vector)), 1e-9)
