"""How far it is to the roadway's edge, as a grid of packed numbers: one look-up gives a distance and its gradient."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

CELL = 0.5
"""Side of a cell [m]. Corners of cells lie at multiples of it, so kerbs there are exact."""
UNIT = 0.025
"""Distances are multiples of this [m]."""
MOST_UNITS = 127
"""The largest distance of a corner: farther ones are cut to 3.175 m, and only their sign counts."""
BEYOND = 4.0
"""The grid reaches this far beyond the map on every side [m]."""


def road_field(roadway: BaseGeometry, size: tuple[float, float]) -> np.ndarray:
    """Return the field int32 (row, column) of a map: row 0 is the southernmost, column 0 the westernmost.

    A cell holds, in a byte each from the lowest on, the distance from its south-west, south-east, north-west and
    north-east corner to the edge of the roadway, in `UNIT`, negative off the roadway.
    """
    corners = signed_distances(roadway, size)
    units = np.clip(np.round(corners / UNIT), -MOST_UNITS, MOST_UNITS).astype(np.int8)
    south_west, south_east, north_west, north_east = units[:-1, :-1], units[:-1, 1:], units[1:, :-1], units[1:, 1:]
    return np.ascontiguousarray(np.stack([south_west, south_east, north_west, north_east], axis=-1)).view("<i4")[..., 0]


def signed_distances(roadway: BaseGeometry, size: tuple[float, float]) -> np.ndarray:
    """Return the distance from each corner of a cell to the edge of the roadway [m], cut off; negative outside."""
    columns, rows = (int(np.ceil((extent + 2 * BEYOND) / CELL)) + 1 for extent in size)
    pieces = _edge_pieces(roadway)
    distance = np.full((rows, columns), MOST_UNITS * UNIT)
    for piece in pieces:
        _bring_near(distance, piece)
    return np.where(_inside(pieces, rows, columns), distance, -distance)


def _edge_pieces(roadway: BaseGeometry) -> np.ndarray:
    """Return the straight pieces of the roadway's edge, (piece, 2, 2) [m] from the grid's corner."""
    whole = shapely.get_rings(shapely.get_parts(roadway.normalize()))
    rings = [np.asarray(ring.coords) + BEYOND for ring in whole.tolist()]
    return np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])


def _bring_near(distance: np.ndarray, piece: np.ndarray) -> None:
    """Lower the distances around one straight piece of edge to the distance from it."""
    reach = MOST_UNITS * UNIT
    low = np.maximum(np.ceil((piece.min(axis=0) - reach) / CELL).astype(int), 0)
    high = np.floor((piece.max(axis=0) + reach) / CELL).astype(int) + 1
    part = distance[low[1] : high[1], low[0] : high[0]]
    x = (low[0] + np.arange(part.shape[1])) * CELL - piece[0, 0]
    y = ((low[1] + np.arange(part.shape[0])) * CELL - piece[0, 1])[:, None]
    (dx, dy), squared = piece[1] - piece[0], ((piece[1] - piece[0]) ** 2).sum()
    share = np.clip((x * dx + y * dy) / max(squared, 1e-12), 0, 1)
    np.minimum(part, np.hypot(x - share * dx, y - share * dy), out=part)


def _inside(pieces: np.ndarray, rows: int, columns: int) -> np.ndarray:
    """Return which corners are inside: an odd number of edges lies to the west of them."""
    west = np.zeros((rows, columns + 1), np.int64)
    for (x0, y0), (x1, y1) in pieces:
        if y0 == y1:
            continue
        # A row belongs to a piece that begins on it or below it and ends above it, so that no vertex counts twice.
        row = np.arange(int(np.ceil(min(y0, y1) / CELL)), int(np.ceil(max(y0, y1) / CELL)))
        x = x0 + (row * CELL - y0) * (x1 - x0) / (y1 - y0)
        np.add.at(west, (row, np.clip(np.ceil(x / CELL).astype(int), 0, columns)), 1)
    return west.cumsum(axis=1)[:, :-1] % 2 == 1
