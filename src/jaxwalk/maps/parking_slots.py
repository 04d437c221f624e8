"""Where vehicles may park: slots along the parking strips of a network, each with the box of a vehicle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely

from jaxwalk.maps.network import Network
from jaxwalk.maps.network_scene import SLACK

SLOT = 6.0
"""Length of a slot [m]."""
BOX = (4.4, 1.8)
"""Length and width of a parked vehicle [m]; narrower where its strip is."""
NARROWEST = 1.4
"""Nobody parks where a strip is narrower [m]."""
FROM_CROSSWALKS = 5.0
"""Nobody parks this close to a crosswalk [m]."""
SLOT_COLUMNS = ("x", "y", "cos", "sin", "half_length", "half_width")
"""A box: its centre [m], its direction, and half its length and width [m]."""
ASIDE = 40.0
"""A strip lies nearer than this to the lane beside it [m]."""


def parking_slots(network: Network) -> np.ndarray:
    """Return the boxes of vehicles that may park, float64 (slot, column), with the columns `SLOT_COLUMNS`.

    Slots stand one after the other along the nearest lane, in the middle of their strip, and point as traffic there.
    Where a box would leave its strip, overlap another one, or come near a crosswalk, nobody parks.
    """
    crosswalks = network.surface("crosswalk")
    strips = [area.shape() for area in network.areas if area.kind == "parking"]
    found: list[np.ndarray] = []
    taken: list[shapely.Polygon] = []
    for strip, box in ((one, box) for one in strips for box in _along(one, network)):
        shape = shapely.Polygon(box_corners(box))
        clear = crosswalks.is_empty or shapely.distance(shape, crosswalks) >= FROM_CROSSWALKS - SLACK
        if clear and strip.buffer(SLACK).covers(shape) and not shapely.intersects(taken, shape).any():
            taken.append(shape)
            found.append(box)
    return np.array(found).reshape(-1, len(SLOT_COLUMNS))


def box_corners(box: np.ndarray) -> np.ndarray:
    """Return the corners of boxes (..., column) as outlines (..., 4, 2) [m]."""
    x, y, cos, sin, half_length, half_width = np.moveaxis(np.asarray(box, float)[..., None], -2, 0)
    along = np.array([1, 1, -1, -1]) * half_length
    left = np.array([-1, 1, 1, -1]) * half_width
    return np.stack([x + along * cos - left * sin, y + along * sin + left * cos], axis=-1)


def _along(strip: shapely.Polygon, network: Network) -> Iterator[np.ndarray]:
    """Yield the boxes of a strip, one after the other along its lane."""
    lanes = [shapely.LineString(lane.line) for lane in network.lanes]
    line = lanes[int(np.argmin(shapely.distance(lanes, strip.centroid)))]
    ends = shapely.line_locate_point(line, shapely.points(strip.exterior.coords))
    begin, end = ends.min(), ends.max()
    count = int((end - begin) // SLOT)
    first = (begin + end - count * SLOT) / 2 + SLOT / 2
    for at in first + SLOT * np.arange(count):
        rear, front = (np.array(line.interpolate(at + step).coords[0]) for step in (-BOX[0] / 2, BOX[0] / 2))
        ahead = (front - rear) / max(float(np.hypot(*(front - rear))), 1e-9)
        left = np.array([-ahead[1], ahead[0]])
        middle = (front + rear) / 2
        across = shapely.LineString([middle - ASIDE * left, middle + ASIDE * left]).intersection(strip)
        if across.length >= NARROWEST:
            centre = across.centroid
            yield np.array([centre.x, centre.y, *ahead, BOX[0] / 2, min(BOX[1], across.length) / 2])
