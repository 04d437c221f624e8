"""A line of straight pieces and arcs, measured from its beginning, with lines parallel to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

SPACING = 0.5
"""Largest distance between the points of a curve [m]."""


class Curve(NamedTuple):
    """Points of a line, with places measured along it [m]."""

    metres: np.ndarray
    """Places of the points [m], rising."""
    points: np.ndarray
    """float64 (point, 2) [m]."""
    headings: np.ndarray
    """Direction at each point [rad]."""

    @classmethod
    def of(
        cls, point: np.ndarray, heading: float, pieces: Sequence[tuple[float, float]], *, first: float = 0.0
    ) -> Curve:
        """Return the curve from a point (2,) on, whose place is ``first``, over pieces of (length, curvature)."""
        steps, bends = [], []
        for length, curvature in pieces:
            count = int(np.ceil(length / SPACING))
            steps += [np.full(count, length / count)]
            bends += [np.full(count, curvature)]
        step = np.concatenate(steps)
        turn = np.concatenate(bends) * step
        headings = heading + np.concatenate([[0.0], turn.cumsum()])
        between = headings[:-1] + turn / 2
        chord = step * np.sinc(turn / (2 * np.pi))  # the straight way between two points of an arc
        moves = chord[:, None] * np.stack([np.cos(between), np.sin(between)], axis=1)
        points = np.asarray(point, float) + np.concatenate([np.zeros((1, 2)), moves.cumsum(axis=0)])
        return cls(first + np.concatenate([[0.0], step.cumsum()]), points, headings)

    def heading(self, metres: float) -> float:
        """Return the direction at a place [rad]."""
        return float(np.interp(metres, self.metres, self.headings))

    def beside(self, metres: np.ndarray | float, left: np.ndarray | float = 0.0) -> np.ndarray:
        """Return the points (..., 2) that lie ``left`` metres to the left of places."""
        heading = np.interp(metres, self.metres, self.headings)
        x, y = (np.interp(metres, self.metres, self.points[:, k]) for k in (0, 1))
        return np.stack([x - left * np.sin(heading), y + left * np.cos(heading)], axis=-1)

    def parallel(self, left: float, begin: float, end: float) -> np.ndarray:
        """Return the line (point, 2) that lies ``left`` metres to the left, from one place to another."""
        between = self.metres[(self.metres > begin + 1e-6) & (self.metres < end - 1e-6)]
        return self.beside(np.concatenate([[begin], between, [end]]), left)

    def band(self, right: float, left: float, begin: float, end: float) -> np.ndarray:
        """Return the outline (point, 2) between two parallel lines; ``right`` and ``left`` are metres to the left."""
        return np.concatenate([self.parallel(right, begin, end), self.parallel(left, begin, end)[::-1]])
