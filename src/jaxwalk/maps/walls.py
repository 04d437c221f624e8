"""What buildings hide behind: a box for each rectangular building, and the walls of the others."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import shapely

from jaxwalk.maps.network import Network
from jaxwalk.maps.parking_slots import SLOT_COLUMNS

WITHIN = 0.05
"""Outlines of buildings are kept to this precision [m]."""


def walls(network: Network) -> np.ndarray:
    """Return boxes that block exactly the lines that buildings block, float64 (wall, column), as `parking_slots` does.

    A line from outside a building that meets it also meets its outline. So a building that isn't a rectangle is a box
    without width for each of its walls, simplified by at most `WITHIN`.
    """
    buildings = [area.shape() for area in network.areas if area.kind == "building"]
    return np.array([box for building in buildings for box in _boxes(building)]).reshape(-1, len(SLOT_COLUMNS))


def _boxes(building: shapely.Polygon) -> Iterator[np.ndarray]:
    rectangle = building.minimum_rotated_rectangle
    if isinstance(rectangle, shapely.Polygon) and shapely.hausdorff_distance(rectangle, building) < WITHIN:
        corners = np.array(rectangle.exterior.coords)[:4]
        yield _wall(corners[0], corners[1], across=corners[2] - corners[1])
        return
    outline = shapely.get_coordinates(building.simplify(WITHIN))
    for begin, end in pairwise(outline):
        yield _wall(begin, end, across=np.zeros(2))


def _wall(begin: np.ndarray, end: np.ndarray, across: np.ndarray) -> np.ndarray:
    """Return the box from one corner to the next, and on by ``across``."""
    length = float(np.hypot(*(end - begin)))
    return np.array([*(begin + end + across) / 2, *(end - begin) / length, length / 2, np.hypot(*across) / 2])
