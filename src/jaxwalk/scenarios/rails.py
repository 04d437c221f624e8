"""A car on rails, its centre on its route at constant speed: where it meets somebody decides how a test is timed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely
from jaxtyping import Float

from jaxwalk.maps import ROUTE_SPACING, RoadMap

FINELY = 0.01
"""Distance between the points of a person's way that are tried [m]."""


class Rails(NamedTuple):
    """A route, at points `ROUTE_SPACING` apart."""

    x: np.ndarray
    """Position [m]."""
    y: np.ndarray
    heading: np.ndarray
    """Direction of travel [rad], without jumps."""
    length: float
    """From start to goal [m]."""

    @classmethod
    def of(cls, maps: RoadMap, number: int, route: int) -> Rails:
        """Return a route of one of several stacked maps."""
        x, y, cos, sin = (
            np.asarray(column)[number, route].astype(float)
            for column in (maps.route_x, maps.route_y, maps.route_cos, maps.route_sin)
        )
        return cls(x, y, np.unwrap(np.arctan2(sin, cos)), float(np.asarray(maps.route_length)[number, route]))

    def at(self, along: float) -> tuple[float, float, float]:
        """Return position [m] and direction [rad] at a place of the route [m]."""
        metres = np.arange(len(self.x)) * ROUTE_SPACING
        x, y, heading = (float(np.interp(along, metres, column)) for column in (self.x, self.y, self.heading))
        return x, y, heading

    def crossing(self, axis: str, value: float) -> float | None:
        """Return where the route first crosses a line of the map, x or y = ``value`` [m along it]; None if nowhere."""
        beyond = (self.x if axis == "x" else self.y) - value
        changes = np.flatnonzero(beyond[:-1] * beyond[1:] <= 0)
        if not len(changes):
            return None
        first = changes[0]
        step = beyond[first] - beyond[first + 1]
        return float((first + (beyond[first] / step if step else 0)) * ROUTE_SPACING)

    def car_heading(self, wheelbase: float) -> Float[np.ndarray, " point"]:
        """Return the car's direction at each point [rad]: it looks outward by its slip, as a bicycle does in a bend."""
        curvature = np.gradient(self.heading, ROUTE_SPACING)
        return self.heading - np.arcsin(np.clip(curvature * wheelbase / 2, -1, 1))


class Meeting(NamedTuple):
    """Where the front of a car on rails meets a point of somebody's way."""

    along: np.ndarray
    """How far along its route the car's centre is then [m]; NaN where it never does."""
    left: np.ndarray
    """How far the point is to the left of the car's middle then [m]."""


def meetings(rails: Rails, places: Float[np.ndarray, "place 2"], *, half_length: float, wheelbase: float) -> Meeting:
    """Return where the front meets places; arrays ``(place,)``."""
    heading = rails.car_heading(wheelbase)
    cos, sin = np.cos(heading), np.sin(heading)
    dx, dy = places[:, :1] - rails.x, places[:, 1:] - rails.y
    missing = dx * cos + dy * sin - half_length
    left = dy * cos - dx * sin
    passes = (missing[:, :-1] > 0) & (missing[:, 1:] <= 0)
    first = passes.argmax(axis=1)
    rows = np.arange(len(places))
    share = missing[rows, first] / np.where(passes.any(axis=1), missing[rows, first] - missing[rows, first + 1], 1)
    along = np.where(passes.any(axis=1), (first + share) * ROUTE_SPACING, np.nan)
    return Meeting(along, left[rows, first] + share * (left[rows, first + 1] - left[rows, first]))


class Footpath(NamedTuple):
    """A polyline of a person, in the map [m]."""

    points: np.ndarray
    """float64 (point, 2)."""

    @property
    def along(self) -> np.ndarray:
        """Return how far along the way each point is [m]."""
        return np.concatenate([[0.0], np.hypot(*np.diff(self.points, axis=0).T).cumsum()])

    def at(self, metres: np.ndarray | float) -> np.ndarray:
        """Return the places at some metres of the way, (..., 2)."""
        return np.stack([np.interp(metres, self.along, self.points[:, k]) for k in (0, 1)], axis=-1)

    def from_place(self, metres: float) -> Footpath:
        """Return the way from a place on [m]."""
        after = self.points[self.along > metres + FINELY / 10]
        return Footpath(np.concatenate([self.at(metres)[None], after]))

    def turned(self, angle: float, about: np.ndarray) -> Footpath:
        """Return the way turned to the left by an angle [rad] about a place (2,) [m]."""
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return Footpath(about + (self.points - about) @ turn.T)

    def enters(self, surface: shapely.geometry.base.BaseGeometry) -> float:
        """Return where the way enters a surface [m]; inf if it doesn't, or begins on it."""
        tried = np.arange(0, self.along[-1] + FINELY, FINELY)
        inside = np.asarray(shapely.covers(surface, shapely.points(self.at(tried))))
        return float(tried[inside.argmax()]) if inside.any() and not inside[0] else np.inf


def time_to_walk(way: float, pace: float, run_up: float) -> float:
    """Return how long somebody needs for a way [m] at a pace [m/s], which is gathered evenly on the run-up [m]."""
    gathering = 2 * run_up / pace
    return gathering * (way / run_up) ** 0.5 if way < run_up else gathering + (way - run_up) / pace
