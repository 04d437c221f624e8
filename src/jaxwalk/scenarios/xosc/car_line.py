"""The way of the tested car of an OpenSCENARIO document, and where on it the car is near something."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely

from jaxwalk.scenarios.xosc.plain_roads import Pose

TRIED = 0.5
"""Distance of the places at which a distance is measured, before the place is halved in [m]."""
HALVED = 40
"""How often it is halved."""


class MeasuredBody(NamedTuple):
    """What is at a place: somebody or something with a size, or a point."""

    reference: Pose
    """Where its reference point is."""
    centre: Pose
    length: float = 0.0
    """Its length [m]; 0 for a point."""
    width: float = 0.0

    def half_along(self, heading: float) -> float:
        """Return how far it reaches from its centre in a direction [rad], in metres."""
        turn = self.centre.heading - heading
        return float(abs(np.cos(turn)) * self.length + abs(np.sin(turn)) * self.width) / 2

    @property
    def outline(self) -> shapely.Geometry:
        """Return its outline [m]."""
        if self.length == 0:
            return shapely.Point(self.centre[:2])
        return boxes(np.array([self.centre]), self.length, self.width)[0]


def boxes(poses: np.ndarray, length: float, width: float) -> np.ndarray:
    """Return rectangles about centres (pose, 3): x, y [m] and heading [rad]."""
    ahead, left = np.array([1, 1, -1, -1]) * length / 2, np.array([1, -1, -1, 1]) * width / 2
    cos, sin = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    corners = np.stack([poses[:, :1] + ahead * cos - left * sin, poses[:, 1:2] + ahead * sin + left * cos], axis=-1)
    return np.asarray(shapely.polygons(corners))


class CarLine(NamedTuple):
    """The way of the tested car, and what its front is."""

    points: np.ndarray
    """float64 (point, 2) [m]."""
    along: np.ndarray
    """How far along the way each point is [m]."""
    start: float
    """Where its centre begins [m along the way]."""
    half_length: float
    half_width: float
    reference: float
    """How far its reference point is behind its centre [m]."""
    speed: float
    """Its speed at the start, or the highest one if it begins at rest [m/s]."""

    def project(self, x: float, y: float) -> tuple[float, float]:
        """Return how far along the way the nearest place is, and how far to its left the point lies [m]."""
        begin, step = self.points[:-1], np.diff(self.points, axis=0)
        away = np.array([x, y]) - begin
        lengths = np.maximum(np.hypot(*step.T), 1e-9)
        share = np.clip((away * step).sum(axis=1) / lengths**2, 0, 1)
        missed = away - share[:, None] * step
        nearest = int(np.argmin((missed**2).sum(axis=1)))
        left = (step[nearest, 0] * away[nearest, 1] - step[nearest, 1] * away[nearest, 0]) / lengths[nearest]
        return float(self.along[nearest] + share[nearest] * lengths[nearest]), float(left)

    def poses(self, along: np.ndarray) -> np.ndarray:
        """Return the centre at places of the way [m], float64 (place, 3): x, y [m] and heading [rad]."""
        number = np.clip(np.searchsorted(self.along, along, "right") - 1, 0, len(self.along) - 2)
        step = np.diff(self.points, axis=0)[number]
        x, y = (np.interp(along, self.along, self.points[:, k]) for k in (0, 1))
        return np.stack([x, y, np.arctan2(step[:, 1], step[:, 0])], axis=1)

    def distances(self, along: np.ndarray, body: MeasuredBody, freespace: bool) -> np.ndarray:
        """Return the straight distances to a body from places of the way [m]: between outlines, or reference points."""
        if freespace:
            return shapely.distance(boxes(self.poses(along), 2 * self.half_length, 2 * self.half_width), body.outline)
        x, y, heading = self.poses(along).T
        rear = x - self.reference * np.cos(heading), y - self.reference * np.sin(heading)
        return np.hypot(rear[0] - body.reference.x, rear[1] - body.reference.y)

    def first_within(self, metres: float, body: MeasuredBody, freespace: bool) -> float | None:
        """Return where the car first is within a straight distance of a body [m]; None if nowhere."""
        tried = np.append(np.arange(self.start, self.along[-1], TRIED), self.along[-1])
        near = self.distances(tried, body, freespace) < metres
        if not near.any():
            return None
        first = int(near.argmax())
        before, after = tried[max(first - 1, 0)], tried[first]
        for _ in range(HALVED):
            middle = (before + after) / 2
            is_near = self.distances(np.array([middle]), body, freespace)[0] < metres
            before, after = (before, middle) if is_near else (middle, after)
        return float(after)

    def nearest(self, body: MeasuredBody, freespace: bool) -> float:
        """Return the smallest straight distance to a body [m]."""
        tried = np.append(np.arange(self.start, self.along[-1], TRIED), self.along[-1])
        return float(self.distances(tried, body, freespace).min())
