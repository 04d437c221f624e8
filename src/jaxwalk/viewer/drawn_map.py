"""What is drawn of a street, in pictures and on pages: outlines and lines in metres."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.crosswalk_sides import CrosswalkFrame
from jaxwalk.maps.network import Area, Network
from jaxwalk.viewer.lane_marks import lane_marks

STRIPE = 0.5
"""Width of a crosswalk's stripes and of the gaps between them [m]."""
EXACT = 0.01
"""Outlines are drawn this exactly [m]."""
SURFACES = ("building", "sidewalk", "roadway", "parking", "island", "raised")
"""Kinds of surfaces, each of which covers those before it; raised crosswalks are one."""

Outline = list[float]
"""x and y of a point, of the next one, and so on [m]."""


@dataclass(frozen=True)
class DrawnMap:
    """One street as it is drawn: plain numbers, which also go into pages."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    width: float
    """Extent to the east [m]."""
    height: float
    """Extent to the north [m]."""
    surfaces: dict[str, list[Outline]]
    """For each of `SURFACES` its outlines, those of holes in the opposite direction."""
    stripes: list[Outline]
    """Outlines of the crosswalks' stripes."""
    dotted: list[Outline]
    """Sides of crossings without stripes."""
    dashed: list[Outline]
    """Lines between lanes."""
    attribution: str = ""
    """Whose data the street was made from, which is written beside it."""

    @classmethod
    def of(cls, network: Network) -> DrawnMap:
        """Return the drawing of a street."""
        crosswalks = list(_crosswalks(network))
        shapes = {kind: network.surface(kind) for kind in SURFACES if kind != "raised"}
        shapes["raised"] = shapely.union_all([area.shape() for kind, area, _ in crosswalks if kind == "raised"])
        stripes = [x for kind, area, way in crosswalks if kind != "unmarked" for x in _stripes(area, way)]
        dotted = [x for kind, area, way in crosswalks if kind == "unmarked" for x in _along_sides(area, way)]
        return cls(
            width=float(network.size[0]),
            height=float(network.size[1]),
            surfaces={kind: list(_rings(shape)) for kind, shape in shapes.items()},
            stripes=[_flat(stripe) for stripe in stripes],
            dotted=[_flat(line) for line in dotted],
            dashed=[_flat(line) for line in lane_marks(network)],
            attribution=network.attribution,
        )


def _flat(points: np.ndarray) -> Outline:
    return np.round(points, 2).ravel().tolist()


def _rings(shape: BaseGeometry) -> Iterator[Outline]:
    """Yield the outlines of a surface, none of which repeats its first point."""
    whole = shapely.orient_polygons(shapely.simplify(shape, EXACT))
    for ring in shapely.get_rings(shapely.get_parts(whole)):
        yield _flat(shapely.get_coordinates(ring)[:-1])


def _crosswalks(network: Network) -> Iterator[tuple[str, Area, np.ndarray]]:
    """Yield kind, area and way (point, 2) [m] of each area that a crossing leads over."""
    for crossing in network.crossings:
        for number in crossing.areas:
            yield crossing.kind, network.areas[number], network.walk.nodes[list(crossing.nodes)]


def _stripes(area: Area, way: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the outlines of a crosswalk's stripes: along the road, side by side from kerb to kerb."""
    frame, shape = CrosswalkFrame.of(area, way), area.shape()
    right, left = frame.beside
    for begin in np.arange(frame.over[0] + STRIPE / 2, frame.over[1] - STRIPE / 2, 2 * STRIPE):
        end = begin + STRIPE
        corners = [(begin, right), (end, right), (end, left), (begin, left)]
        stripe = shapely.Polygon([frame.point(*corner) for corner in corners]).intersection(shape)
        yield from (shapely.get_coordinates(part)[:-1] for part in shapely.get_parts(stripe) if part.area > 0)


def _along_sides(area: Area, way: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the two sides of a crosswalk that lead over the roadway."""
    frame = CrosswalkFrame.of(area, way)
    yield from (frame.side(beside) for beside in frame.beside)
