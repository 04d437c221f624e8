"""A crosswalk in the frame of its crossing: across the roadway, and beside that."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from jaxwalk.maps.network import Area


class CrosswalkFrame(NamedTuple):
    """The smallest rectangle along a crossing's way around a crosswalk's area."""

    origin: np.ndarray
    """Where the crossing begins (2,) [m]."""
    across: np.ndarray
    """Unit vector of the way over the roadway."""
    left: np.ndarray
    """Unit vector to the left of it."""
    over: tuple[float, float]
    """Where the area begins and ends on the way [m]."""
    beside: tuple[float, float]
    """Where its right and its left side lie [m]."""

    @classmethod
    def of(cls, area: Area, way: np.ndarray) -> CrosswalkFrame:
        """Return the frame of an area on a crossing's way (point, 2)."""
        across = (way[-1] - way[0]) / np.linalg.norm(way[-1] - way[0])
        left = np.array([-across[1], across[0]])
        over, beside = (area.outline - way[0]) @ across, (area.outline - way[0]) @ left
        return cls(way[0], across, left, (over.min(), over.max()), (beside.min(), beside.max()))

    def point(self, over: float, beside: float) -> np.ndarray:
        """Return a point of the frame (2,) [m]."""
        return self.origin + over * self.across + beside * self.left

    def side(self, beside: float) -> np.ndarray:
        """Return a line over the roadway (2, 2) [m]."""
        return np.array([self.point(over, beside) for over in self.over])
