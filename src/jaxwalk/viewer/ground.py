"""Drawing of the map, which is the same in every frame."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.patches import Rectangle

from jaxwalk.maps import RoadMap

BLOCK, ROAD, SIDEWALK, PAINT = "#f3f1ea", "#9a9ea5", "#b5d3a2", "#f7f7f4"
"""Colours of blocks between the roads, of roads, sidewalks and road markings."""
STRIPE = 0.5
"""Width of a crosswalk's stripes and of the gaps between them [m]."""
CLEAR = 2.5
"""Gap between a centre line and a junction or crosswalk [m]."""

Box = tuple[float, float, float, float]


def draw_ground(axes: Axes, road_map: RoadMap) -> None:
    """Draw sidewalks, roads, centre lines and crosswalks of one map (not of a stack), in metres."""
    roads, crosswalks = list(_boxes(road_map.roads)), list(_boxes(road_map.crosswalks))
    axes.set_facecolor(BLOCK)
    axes.set_xlim(0, float(road_map.width))
    axes.set_ylim(0, float(road_map.height))
    axes.set_aspect("equal")
    _fill(axes, list(_boxes(road_map.sidewalks)), SIDEWALK, 1)
    _fill(axes, roads, ROAD, 2)
    for road in roads:
        _centre_line(axes, road, roads + crosswalks)
    _fill(axes, [stripe for crosswalk in crosswalks for stripe in _stripes(crosswalk, roads)], PAINT, 3)


def _boxes(rectangles) -> Iterator[Box]:
    """Yield the rectangles that aren't padding."""
    for x0, y0, x1, y1 in np.asarray(rectangles).tolist():
        if x0 < x1 and y0 < y1:
            yield x0, y0, x1, y1


def _fill(axes: Axes, boxes: list[Box], colour: str, order: int) -> None:
    patches = [Rectangle((x0, y0), x1 - x0, y1 - y0) for x0, y0, x1, y1 in boxes]
    axes.add_collection(PatchCollection(patches, facecolor=colour, edgecolor="none", zorder=order))


def _centre_line(axes: Axes, road: Box, interrupting: list[Box]) -> None:
    """Draw a dashed line along the middle of a road, except on and close to other roads and crosswalks."""
    x0, y0, x1, y1 = road
    axis = int(y1 - y0 > x1 - x0)
    middle = (x0 + x1) / 2 if axis else (y0 + y1) / 2
    along = np.arange(road[axis], road[axis + 2], 0.1)
    shown = np.ones(len(along), bool)
    for box in interrupting:
        if box != road and box[1 - axis] <= middle <= box[3 - axis]:
            shown &= (along < box[axis] - CLEAR) | (along > box[axis + 2] + CLEAR)
    line = np.where(shown, along, np.nan)
    across = np.full(len(along), middle)
    x, y = (across, line) if axis else (line, across)
    axes.plot(x, y, color=PAINT, linewidth=0.8, dashes=(5, 5), zorder=3)


def _stripes(crosswalk: Box, roads: list[Box]) -> Iterator[Box]:
    """Yield a crosswalk's stripes: along the direction of traffic, side by side from kerb to kerb."""
    x0, y0, x1, y1 = crosswalk
    under = [r for r in roads if r[0] < x1 and r[2] > x0 and r[1] < y1 and r[3] > y0]
    vertical = any(r[3] - r[1] > r[2] - r[0] for r in under)  # the road runs south-north
    low, high = (x0, x1) if vertical else (y0, y1)
    for begin in np.arange(low + STRIPE / 2, high - STRIPE / 2, 2 * STRIPE).tolist():
        end = min(begin + STRIPE, high)
        yield (begin, y0, end, y1) if vertical else (x0, begin, x1, end)
