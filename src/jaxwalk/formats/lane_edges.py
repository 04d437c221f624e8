"""The edges of lanes: those of lanes that follow each other meet."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from jaxwalk.maps.junctions import LanePlaces
from jaxwalk.maps.network import Lane, along, without_repeats


class LaneEdges(NamedTuple):
    """The two edges of a lane, in the direction of travel, float64 (point, 2) [m]."""

    left: np.ndarray
    right: np.ndarray
    headings: tuple[float, float]
    """Directions at its begin and end, which lanes that meet share [rad]."""
    widths: tuple[float, float]
    """Widths at its begin and end [m]."""


class LaneJoints:
    """Direction and width of lanes where they meet."""

    def __init__(self, lanes: tuple[Lane, ...], places: LanePlaces) -> None:
        """Find the mean direction, and the largest width, of all lanes that begin or end at a place.

        The longer a straight piece is, the more it counts: the first piece of an arc is a chord.
        """
        self.lanes, self.places = lanes, places
        directions = np.zeros((2 * len(lanes), 2))
        self.widths = np.zeros(2 * len(lanes))
        for place, (one, other) in ((places.begin, (0, 1)), (places.end, (-2, -1))):
            np.add.at(directions, place, [lane.line[other] - lane.line[one] for lane in lanes])
            np.maximum.at(self.widths, place, [lane.width for lane in lanes])
        self.headings = np.arctan2(directions[:, 1], directions[:, 0])

    def edges(self, chain: tuple[int, ...]) -> LaneEdges:
        """Return the edges of lanes that follow each other, as of one; its width changes evenly."""
        line = without_repeats(np.concatenate([self.lanes[lane].line for lane in chain]), 1e-3)
        ends = [self.places.begin[chain[0]], self.places.end[chain[-1]]]
        first, last = self.headings[ends].tolist()
        ahead = np.gradient(line, along(line), axis=0)
        ahead[[0, -1]] = [(np.cos(angle), np.sin(angle)) for angle in (first, last)]
        ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
        begin, end = self.widths[ends].tolist()
        width = np.interp(along(line), [0, along(line)[-1]], [begin, end])
        aside = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) * width[:, None] / 2
        return LaneEdges(line + aside, line - aside, (first, last), (begin, end))
