"""Dashed lines between lanes: along the left edge of each lane, away from junctions and crosswalks."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.junctions import LanePlaces, in_junction
from jaxwalk.maps.network import Network

CLEAR = 2.5
"""Gap between a line and a junction or crosswalk [m]."""
ONE = 0.3
"""Edges of two lanes that are this close are one line [m]."""
KERB = 0.6
"""A line keeps this far from kerbs and parking strips [m]."""
SHORTEST = 1.0
"""Shortest line that is drawn [m]."""


def lane_marks(network: Network) -> list[np.ndarray]:
    """Return the lines, each float64 (point, 2) [m]."""
    inside = in_junction(network.lanes, LanePlaces.of(network.lanes))
    middles = [shapely.LineString(lane.line) for lane in network.lanes]
    edges = [shapely.offset_curve(middles[n], network.lanes[n].width / 2) for n in np.flatnonzero(~inside)]
    through = [shapely.buffer(middles[n], 1.0, cap_style="flat") for n in np.flatnonzero(inside)]
    clear = shapely.union_all([
        shapely.union_all([network.surface("crosswalk"), *through]).buffer(CLEAR),
        shapely.union_all([network.surface("roadway").boundary, network.surface("parking")]).buffer(KERB),
    ])  # fmt: skip
    shapely.prepare(clear)
    drawn: BaseGeometry = shapely.MultiLineString()
    for edge in edges:
        drawn = drawn.union(edge.difference(clear).difference(drawn.buffer(ONE)))
    parts = shapely.get_parts(shapely.line_merge(drawn))
    return [shapely.get_coordinates(part) for part in parts if part.length >= SHORTEST]
