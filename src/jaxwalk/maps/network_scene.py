"""The surfaces of a network as shapes, which the checks and the tables use."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.network import Network

SLACK = 0.02
"""Surfaces may miss or overlap each other by this much [m], because curves are polygons and files are rounded."""
SLIVER = 0.01
"""Surfaces whose insides share less than this don't overlap [m2]."""


class NetworkScene(NamedTuple):
    """Unions of the areas [m]."""

    roadway: BaseGeometry
    wide_roadway: BaseGeometry
    """Widened by `SLACK`."""
    pavement: BaseGeometry
    """Sidewalks and islands, widened by `SLACK`."""
    ground: BaseGeometry
    """Both together."""
    islands: BaseGeometry
    crosswalks: list[tuple[int, shapely.Polygon]]
    """Number and shape of each crosswalk area."""
    others: list[tuple[str, shapely.Polygon]]
    """What mustn't overlap the roadway: name and shape of sidewalks, islands and buildings."""
    strips: list[tuple[str, shapely.Polygon]]
    """Parking strips."""

    @classmethod
    def of(cls, network: Network) -> NetworkScene:
        """Return the scene of a network whose outlines are sound."""
        shapes = [(area.kind, f"areas[{n}] ({area.kind})", area.shape()) for n, area in enumerate(network.areas)]
        roadway = network.surface("roadway")
        wide, pavement = (
            shape.buffer(SLACK, join_style="mitre") for shape in (roadway, network.surface("sidewalk", "island"))
        )
        ground = pavement.union(wide)
        shapely.prepare([roadway, wide, pavement, ground])
        return cls(
            roadway=roadway,
            wide_roadway=wide,
            pavement=pavement,
            ground=ground,
            islands=network.surface("island"),
            crosswalks=[(n, area.shape()) for n, area in enumerate(network.areas) if area.kind == "crosswalk"],
            others=[(name, shape) for kind, name, shape in shapes if kind in ("sidewalk", "island", "building")],
            strips=[(name, shape) for kind, name, shape in shapes if kind == "parking"],
        )

    def overlap_faults(self) -> Iterator[str]:
        """Yield the areas that overlap others, or don't lie on the roadway where they should."""
        inner = self.roadway.buffer(-SLACK)
        shapely.prepare(inner)
        for name, shape in self.others:
            if inner.intersects(shape) and inner.intersection(shape).area > SLIVER:
                yield f"{name}: overlaps the roadway; end it at the kerb"
        on_roadway = [(f"areas[{n}] (crosswalk)", shape) for n, shape in self.crosswalks] + self.strips
        for name, shape in on_roadway:
            if shape.difference(self.wide_roadway).area > SLIVER:
                yield f"{name}: isn't wholly on the roadway; end it at the kerbs"

    def room_on_road(self, points: np.ndarray) -> np.ndarray:
        """Return the distance from each of float64 (point, 2) to the roadway's edge [m]; negative off the roadway."""
        return signed_distance(self.roadway, points)


def signed_distance(surface: BaseGeometry, points: np.ndarray) -> np.ndarray:
    """Return the distance from points (..., 2) to the edge of a surface [m]; negative outside it."""
    shapes = shapely.points(points)
    distance = shapely.distance(surface.boundary, shapes)
    return np.where(shapely.covers(surface, shapes), distance, -distance)
