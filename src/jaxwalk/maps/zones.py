"""Where people may step onto the roadway beside a crosswalk."""

from __future__ import annotations

import numpy as np

from jaxwalk.maps.file import Crosswalk, Point, Side


def zone_from_landing(crosswalk: Crosswalk, side: Side, waypoints: dict[str, Point]) -> tuple[np.ndarray, float, float]:
    """Return the unit vector (2,) from a side's landing to its outer neighbour, and the zone's distances along it [m].

    A file measures distances from the crosswalk's edge. A RoadMap measures them from the landing, which is half a
    crosswalk's width farther in.
    """
    away = np.subtract(waypoints[side.outer], waypoints[side.landing])
    unit = away / np.linalg.norm(away)
    x0, y0, x1, y1 = crosswalk.area
    half = float(np.abs(unit) @ (x1 - x0, y1 - y0)) / 2
    return unit, half + side.zone[0], half + side.zone[1]
