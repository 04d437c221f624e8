"""The two kerbs of a jaywalk zone as lines with one common measure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from jaxwalk.maps.network import JaywalkZone, Network, along


class ZoneLines(NamedTuple):
    """Two lines of nodes that face each other. A place on them is a number of metres along the line between."""

    sides: np.ndarray
    """float64 (2, point, 2) [m]."""
    middle_metres: np.ndarray
    """The place of each point [m], along the line half-way between."""

    @classmethod
    def of(cls, network: Network, zone: JaywalkZone) -> ZoneLines:
        """Return the lines of a zone."""
        sides = network.walk.nodes[np.array(zone.sides)]
        return cls(sides, along(sides.mean(axis=0)))

    @property
    def length(self) -> float:
        """The place of the last points [m]."""
        return float(self.middle_metres[-1])

    def at(self, side: int, place: float) -> np.ndarray:
        """Return the point (2,) of a side at a place.

        All pieces count as equally long, so a piece is found by a division.
        """
        share = place / self.length * (len(self.middle_metres) - 1)
        where = np.arange(len(self.middle_metres))
        return np.array([np.interp(share, where, self.sides[side, :, k]) for k in (0, 1)])
