"""A part of the earth: a box of longitudes and latitudes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely

from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.source_map import Box

DEGREE = 111_320.0
"""Metres that a degree of latitude is long, and a degree of longitude at the equator."""
RADII = (30.0, 1500.0)
"""Smallest and largest radius of a region [m]."""
AROUND = 60.0
"""What lies so close around a region is read with it, so that roads don't end at its edge [m]."""
MOST_AREA = 12e6
"""Largest area of the bounding box of what is imported [m2]."""


class Region(NamedTuple):
    """Longitudes and latitudes [degrees]."""

    west: float
    south: float
    east: float
    north: float

    @classmethod
    def around(cls, latitude: float, longitude: float, radius: float) -> Region:
        """Return the square around a place, ``radius`` [m] to each side. Raise ImportRefusal if there is none."""
        if not (abs(latitude) <= 85 and abs(longitude) <= 180):
            raise ImportRefusal(f"--centre {latitude:g} {longitude:g}: no such place; write latitude and longitude, "
                                "such as --centre 60.1699 24.9384")  # fmt: skip
        if not RADII[0] <= radius <= RADII[1]:
            raise ImportRefusal(f"--radius {radius:g}: must lie in [{RADII[0]:g}, {RADII[1]:g}] m")
        return cls(longitude, latitude, longitude, latitude).widened(radius)

    @classmethod
    def of_box(cls, numbers: tuple[float, ...]) -> Region:
        """Return the box of west, south, east and north. Raise ImportRefusal if it is none."""
        if len(numbers) != 4 or not np.isfinite(numbers).all():
            raise ImportRefusal("--bbox: needs four numbers, west, south, east, north [degrees]")
        west, south, east, north = numbers
        if not (-180 <= west < east <= 180 and -85 <= south < north <= 85):
            given = " ".join(f"{x:g}" for x in numbers)
            raise ImportRefusal(f"--bbox {given}: is no box; write west, south, east, north [degrees]")
        return cls(west, south, east, north)

    def widened(self, metres: float) -> Region:
        """Return the box with some metres more on each side."""
        up = metres / DEGREE
        aside = up / max(float(np.cos(np.radians(max(abs(self.south), abs(self.north))))), 0.05)
        return Region(self.west - aside, self.south - up, self.east + aside, self.north + up)

    def meets(self, line: Sequence[tuple[float, float]]) -> bool:
        """Return whether a line of longitudes and latitudes comes into it."""
        return bool(shapely.LineString(line).intersects(shapely.box(self.west, self.south, self.east, self.north)))

    def corners(self) -> np.ndarray:
        """Return longitude and latitude of its corners (4, 2)."""
        return np.array([(self.west, self.south), (self.east, self.south), (self.east, self.north),
                         (self.west, self.north)])  # fmt: skip


def refuse_large(path: Path, extent: Box) -> None:
    """Raise ImportRefusal if the roads of a file cover too much ground."""
    width, height = extent[2] - extent[0], extent[3] - extent[1]
    if not width * height <= MOST_AREA:
        raise ImportRefusal(
            f"{path}: its roads cover {width / 1000:.1f} x {height / 1000:.1f} km, more than {MOST_AREA / 1e6:.0f} "
            "km2; name a part with --centre and --radius, or --bbox"
        )
