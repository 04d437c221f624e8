"""The two kerbs of a jaywalk zone as lines with one common measure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from jaxwalk.maps.network import JaywalkZone, Network


class ZoneLines(NamedTuple):
    """Two lines of nodes. A place on them is a number of metres from the landings along the line half-way between."""

    sides: np.ndarray
    """float64 (2, point, 2) [m]."""
    pieces: np.ndarray
    """Metres between two nodes half-way between the sides, float64 (piece,); of a straight zone, where nodes needn't
    face each other, of the shorter side."""
    piece: np.ndarray
    """By how many metres a place changes from one node to the next of each side, (2,)."""

    @classmethod
    def of(cls, network: Network, zone: JaywalkZone) -> ZoneLines:
        """Return the lines of a zone."""
        return cls.between(network.walk.nodes[np.array(zone.sides)])

    @classmethod
    def between(cls, sides: np.ndarray) -> ZoneLines:
        """Return the lines between two sides (2, point, 2) [m]."""
        steps = np.diff(sides, axis=1)
        if sides.shape[1] == 2:
            own = np.hypot(*steps[:, 0].T)
            return cls(sides, own.min(keepdims=True), own)
        pieces = np.hypot(*steps.mean(axis=0).T)
        return cls(sides, pieces, np.full(2, pieces.mean()))

    @property
    def length(self) -> float:
        """The last place that both sides have [m]."""
        return float(self.piece.min() * len(self.pieces))

    def at(self, side: int, place: float) -> np.ndarray:
        """Return the point (2,) of a side at a place. All pieces count as equally long."""
        where = np.arange(self.sides.shape[1])
        return np.array([np.interp(place / self.piece[side], where, self.sides[side, :, k]) for k in (0, 1)])
