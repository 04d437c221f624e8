"""Paths of the road users of an episode, and the difference between two recordings of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from jaxwalk.formats.tracks import CAR, Tracks


@dataclass(frozen=True)
class Path:
    """The positions of one road user over time."""

    type: str
    """Kind of road user, such as ``car``."""
    t: Float[np.ndarray, "moment"]
    """Times [s]."""
    x: Float[np.ndarray, "moment"]
    """Centre [m]."""
    y: Float[np.ndarray, "moment"]
    heading: Float[np.ndarray, "moment"]
    """Heading, counter-clockwise from the x axis [rad]."""
    length: float
    """Size [m]."""
    width: float


def paths(tracks: Tracks) -> dict[int, Path]:
    """Return the path of every road user, by id."""
    found = {}
    for id in np.unique(tracks.id).tolist():
        rows = np.flatnonzero(tracks.id == id)
        rows = rows[np.argsort(tracks.t[rows], kind="stable")]
        t, x, y, heading = (getattr(tracks, name)[rows].astype(float) for name in ("t", "x", "y", "heading"))
        size = (float(values[rows[0]]) for values in (tracks.length, tracks.width))
        found[id] = Path(str(tracks.type[rows[0]]), t, x, y, heading, *size)
    return found


def standing(boxes: Float[np.ndarray, "vehicle column"]) -> list[Path]:
    """Return parked vehicles (`jaxwalk.maps.parking_slots.SLOT_COLUMNS`) as paths of one moment."""
    return [
        Path(CAR, np.zeros(1), np.array([x]), np.array([y]), np.arctan2([sin], [cos]), 2 * half_length, 2 * half_width)
        for x, y, cos, sin, half_length, half_width in np.asarray(boxes, float).tolist()
    ]


def largest_error(original: Mapping[int, Path], copy: Mapping[int, Path]) -> float:
    """Return the largest distance between a road user and its copy, at the original's times [m]; inf if one is missing.

    The copy is interpolated linearly between its moments.
    """
    if original.keys() != copy.keys():
        return float("inf")
    errors = [0.0]
    for id, path in original.items():
        other = copy[id]
        dx, dy = (
            np.interp(path.t, other.t, there, left=np.inf, right=np.inf) - here
            for here, there in ((path.x, other.x), (path.y, other.y))
        )
        errors.append(float(np.hypot(dx, dy).max()))
    return max(errors)
