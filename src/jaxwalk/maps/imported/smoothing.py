"""Smooth lines and kerbs: arcs at corners, and no needless gaps."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.generated.curve import Curve

CUT, RADII = 0.8, (8.0, 40.0)
"""A bend's arc passes its corner at this distance, unless its radius would leave these bounds [m]."""
NOISE = 0.15
"""Corners nearer than this to the line between their neighbours are left out [m]."""
SHORTEST = 0.5
"""A shorter line has no length [m]."""
KERB_RADIUS = 5.0
"""Radius of kerbs at corners [m]."""
FINEST = 0.01
"""Kerbs are simplified by at most this [m]."""


def rounded(line: np.ndarray) -> Curve | None:
    """Return a line (point, 2) [m] with arcs at its corners, or None if it has no length."""
    simple = shapely.get_coordinates(shapely.simplify(shapely.LineString(line), NOISE))
    steps = np.diff(simple, axis=0)
    lengths = np.hypot(*steps.T)
    if lengths.sum() < SHORTEST:
        return None
    keep = lengths > 1e-3
    steps, lengths = steps[keep], lengths[keep]
    headings = np.arctan2(steps[:, 1], steps[:, 0])
    turns = np.angle(np.exp(1j * np.diff(headings)))
    half = np.tan(np.minimum(np.abs(turns), 3.0) / 2)
    wanted = np.clip(CUT / np.maximum(1 / np.cos(np.minimum(np.abs(turns), 3.0) / 2) - 1, 1e-6), *RADII) * half
    cuts = np.minimum(wanted, 0.48 * np.minimum(lengths[:-1], lengths[1:]))
    before, after = np.concatenate([[0.0], cuts]), np.concatenate([cuts, [0.0]])
    pieces: list[tuple[float, float]] = []
    for number, straight in enumerate((lengths - before - after).tolist()):
        pieces.append((straight, 0.0))
        if number < len(turns) and abs(turns[number]) > 1e-6:
            radius = cuts[number] / half[number]
            pieces.append((radius * abs(turns[number]), float(np.sign(turns[number])) / radius))
    return Curve.of(simple[0], float(headings[0]), pieces)


def with_rounded_corners(roadway: BaseGeometry, around: BaseGeometry) -> BaseGeometry:
    """Return a roadway whose kerbs have arcs at corners in some places, ``around``."""
    rounded = roadway.buffer(KERB_RADIUS, join_style="mitre").buffer(-KERB_RADIUS, quad_segs=8)
    return without_gaps(roadway.union(rounded.intersection(around)))


def without_gaps(surface: BaseGeometry) -> BaseGeometry:
    """Return a surface without gaps of less than a metre and without needless corners."""
    closed = surface.buffer(0.5, join_style="mitre").buffer(-0.5, join_style="mitre")
    return closed.union(surface).simplify(FINEST)
