"""Points of a network's routes, as evenly spaced as those of a map file."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from jaxwalk.maps.network import LaneRoute, Network, along
from jaxwalk.maps.routes import ROUTE_SPACING


class SampledRoute(NamedTuple):
    """A route at every `ROUTE_SPACING` metres, from its start."""

    points: np.ndarray
    """float64 (point, 2) [m]; straight on beyond the goal."""
    tangents: np.ndarray
    """Unit vectors of travel, float64 (point, 2)."""
    limits: np.ndarray
    """Speed limits, float64 (point,) [m/s]."""
    length: float
    """From start to goal [m]."""


def route_length(network: Network, route: LaneRoute) -> float:
    """Return the metres from a route's start to its goal."""
    before = sum(network.lanes[lane].length() for lane in route.lanes[:-1])
    return before + route.goal - route.start


def sampled_route(network: Network, route: LaneRoute, points: int | None = None) -> SampledRoute:
    """Return the first ``points`` points of a route, straight on past its goal (default: until its goal)."""
    line, length = network.route_line(route), route_length(network, route)
    metres, end = along(line), route.start + length
    count = int(length / ROUTE_SPACING) + 1 if points is None else points
    at = route.start + np.arange(count) * ROUTE_SPACING
    places, tangents = _at(line, metres, np.minimum(at, end))
    past = np.maximum(at - end, 0)[:, None]
    lengths = [network.lanes[lane].length() for lane in route.lanes]
    lane = np.searchsorted(np.cumsum(lengths[:-1]), at, side="right")
    limits = np.array([network.lanes[number].speed_limit for number in route.lanes])[lane]
    return SampledRoute(places + past * tangents, tangents, limits, length)


def _at(line: np.ndarray, metres: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points and unit tangents (point, 2) of a line at some metres along it.

    The tangent turns evenly from the middle of one piece to the middle of the next, as it does on an arc.
    """
    points = np.stack([np.interp(at, metres, line[:, k]) for k in (0, 1)], axis=1)
    steps = np.diff(line, axis=0)
    heading = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    lengths = np.hypot(*steps.T)
    # A long straight piece keeps its direction but for its ends, where a short one, of an arc, meets it.
    soft = np.minimum(lengths / 2, ROUTE_SPACING / 2)
    places = np.stack([metres[:-1] + soft, metres[1:] - soft], axis=1).reshape(-1)
    angle = np.interp(at, places, np.repeat(heading, 2))
    return points, np.stack([np.cos(angle), np.sin(angle)], axis=1)
