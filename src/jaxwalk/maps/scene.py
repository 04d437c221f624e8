"""The surfaces of a map as shapes, which the checks use."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.file import MapFile, Rectangle
from jaxwalk.maps.navigation import NEARLY


class Scene(NamedTuple):
    """Shapes by name, and their unions [m]."""

    roads: dict[str, BaseGeometry]
    sidewalks: dict[str, BaseGeometry]
    crosswalks: dict[str, BaseGeometry]
    roadway: BaseGeometry
    """All roads."""
    pavement: BaseGeometry
    """All sidewalks, widened by NEARLY."""

    @classmethod
    def of(cls, file: MapFile) -> Scene:
        """Return the scene of a map file."""
        roads = _boxes(file.roads)
        sidewalks = _boxes(file.sidewalks)
        crosswalks = _boxes({name: crosswalk.area for name, crosswalk in file.crosswalks.items()})
        roadway = shapely.union_all(list(roads.values()))
        # Widened a little, so that points on the edge count as inside in spite of rounding.
        pavement = shapely.union_all(list(sidewalks.values())).buffer(NEARLY, join_style="mitre")
        shapely.prepare([roadway, pavement])
        return cls(roads, sidewalks, crosswalks, roadway, pavement)

    def on_foot(self, shape: BaseGeometry, *, crosswalks: bool) -> bool:
        """Return whether a shape lies wholly on sidewalks, or on sidewalks and crosswalks."""
        ground = self.pavement
        if crosswalks:
            ground = shapely.union_all([ground, *self.crosswalks.values()])
        return bool(ground.covers(shape))

    def room_on_road(self, points: np.ndarray) -> np.ndarray:
        """Return the distance from each of float64 (point, 2) to the roads' outer edge [m]; negative off the road."""
        shapes = shapely.points(points)
        distance = shapely.distance(self.roadway.boundary, shapes)
        return np.where(shapely.covers(self.roadway, shapes), distance, -distance)


def _boxes(rectangles: dict[str, Rectangle]) -> dict[str, BaseGeometry]:
    """Return rectangles as shapes."""
    return {name: shapely.box(*area) for name, area in rectangles.items()}
