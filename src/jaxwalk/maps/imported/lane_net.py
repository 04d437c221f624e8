"""The lanes of all roads of a source, and what a way through a junction must keep to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.generated.lane_paths import smallest_radius
from jaxwalk.maps.imported.smoothing import rounded
from jaxwalk.maps.network import Lane
from jaxwalk.wording import counted

SWATH = 1.6
"""Half the width of the roadway that a way through a junction needs [m]."""
MOST_OFF = 6.0
"""A way through a junction that is off the mapped roadway for longer than this isn't made [m]."""
TIGHTEST = 4.7
"""Smallest radius of a way through a junction [m]: the car turns within 4.54 m."""
SHARPEST_JOINT = 0.09
"""The direction of a way differs from that of its lanes by at most this [rad]; networks allow 0.1."""
STRAIGHT = 3.0
"""A way that follows the roads inside a junction leaves and meets its lanes straight, for this long [m]."""


class LaneNet(NamedTuple):
    """The lanes of all roads, and the ground that they need."""

    lanes: tuple[Lane, ...]
    in_junction: np.ndarray
    """bool (lane,)"""
    roadway: BaseGeometry
    junctions: tuple[BaseGeometry, ...]
    """Regions that no street's edge may cut."""
    no_turns: int
    """Turns for which there is no room."""


def no_room(turns: int) -> str:
    """Return the sentence about a number of turns that aren't made."""
    return (
        f"{counted(turns, 'turn')} at junctions: too tight (a radius below {TIGHTEST} m), too sharp, or off the roadway"
    )


def heading(piece: np.ndarray) -> float:
    """Return the direction of a straight piece (2, 2) [rad]."""
    return float(np.arctan2(*(piece[1] - piece[0])[::-1]))


def fits(line: np.ndarray, headings: tuple[float, float], roadway: BaseGeometry) -> bool:
    """Return whether a way through a junction leads on from its lanes, isn't too tight, and not long off the roadway.

    ``headings`` are those of the lanes at its begin and its end [rad].
    """
    steps = line[[1, -1]] - line[[0, -2]]
    turns = np.angle(np.exp(1j * (np.arctan2(steps[:, 1], steps[:, 0]) - np.array(headings))))
    if np.abs(turns).max() > SHARPEST_JOINT or smallest_radius(line) < TIGHTEST:
        return False
    whole = shapely.LineString(line)
    if roadway.covers(whole):  # which is quick if the roadway is prepared
        return True
    return whole.difference(shapely.clip_by_rect(roadway, *whole.buffer(1.0).bounds)).length <= MOST_OFF


def along(line: np.ndarray, headings: tuple[float, float], inner: np.ndarray, straight: float = STRAIGHT) -> np.ndarray:
    """Return the way (point, 2) between the ends of a line that follows another line inside a junction, ``inner``.

    It leaves and meets its lanes straight, for ``straight`` metres.
    """
    begin, end = line[0], line[-1]
    ahead, after = (np.array([np.cos(angle), np.sin(angle)]) for angle in headings)
    first, last = begin + straight * ahead, end - straight * after
    between = inner[((inner - first) @ ahead > 1) & ((last - inner) @ after > 1)]
    curve = rounded(np.concatenate([[begin, first], between, [last, end]]))
    assert curve is not None, "its first straight piece alone is long enough"
    return np.concatenate([curve.points[:-1], [end]])
