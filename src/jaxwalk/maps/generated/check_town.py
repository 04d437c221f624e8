"""What a generated street must fulfil beyond every network's checks, so that it is never handed out otherwise."""

from __future__ import annotations

import re

import numpy as np
import shapely

from jaxwalk.maps.check import SMALLEST_TURN
from jaxwalk.maps.check_network import network_faults
from jaxwalk.maps.generated.lane_paths import smallest_radius
from jaxwalk.maps.generated.refusal import Refusal
from jaxwalk.maps.network import Lane, Network, along

LARGEST_SIZE = 200.0
"""Longest side of a street [m]."""
CAR = (4.5, 1.8)
"""Length and width of the car [m]."""
MARGIN = 0.1
"""The car's rectangle stays at least this far from the roadway's edge when its centre follows a lane [m]."""
TIGHTEST = SMALLEST_TURN / float(np.cos(np.arctan(0.5 * np.tan(0.52))))
"""Smallest radius that the car's centre can drive [m]: the bicycle steers at most 0.52 rad and slips by
atan(0.5 tan 0.52)."""
STEP = 1.0
"""Distance between the places where the car's rectangle is laid [m]."""
DISTANCES = {"goal_spacing": 20.0, "start_clearance": 10.0}
"""The simulator's shortest walk to a goal, and its smallest distance between the car's start and people's [m]."""


def refuse_faults(network: Network) -> None:
    """Raise Refusal if a street isn't fit to be driven and walked."""
    if max(network.size) > LARGEST_SIZE:
        raise Refusal(f"larger than {LARGEST_SIZE:g} m")
    if loose_begins(network):
        raise Refusal("a lane begins nowhere")
    if any(smallest_radius(lane.line) < TIGHTEST for lane in network.lanes):
        raise Refusal("a lane bends more tightly than the car can turn")
    if not swept_on_road(network):
        raise Refusal("the car's body leaves the roadway in its lane")
    if faults := network_faults(network, **DISTANCES):
        raise Refusal(without_numbers(faults[0]))


def without_numbers(fault: str) -> str:
    """Return a fault without what differs between streets: places and lengths, and the advice."""
    what = re.sub(r"\[\d+\]|\([^a-z]*\)", "", fault.partition(";")[0])
    return re.sub(r" (at|from) *$", "", re.sub(r"-?\d+(\.\d+)?", "#", what))


def loose_begins(network: Network) -> list[int]:
    """Return the lanes that no lane leads to, although they begin away from the roadway's edge."""
    followed = {after for lane in network.lanes for after in lane.successors}
    edge = network.surface("roadway").boundary
    return [
        number
        for number, lane in enumerate(network.lanes)
        if number not in followed and edge.distance(shapely.Point(lane.line[0])) > 0.05
    ]


def swept_on_road(network: Network) -> bool:
    """Return whether the car's rectangle, following each lane along its heading, stays on the roadway."""
    roadway = network.surface("roadway").buffer(-MARGIN, join_style="mitre")
    shapely.prepare(roadway)
    followed = {after for lane in network.lanes for after in lane.successors}
    rectangles = [
        _rectangles(lane, at_begin=number in followed, at_end=bool(lane.successors))
        for number, lane in enumerate(network.lanes)
    ]
    return bool(shapely.covers(roadway, shapely.polygons(np.concatenate(rectangles))).all())


def _rectangles(lane: Lane, *, at_begin: bool, at_end: bool) -> np.ndarray:
    """Return the car's corners (place, 4, 2) along a lane, but not where it would reach over the street's edge."""
    metres = along(lane.line)
    over = CAR[0] / 2 + 2 * MARGIN
    first, last = 0.0 if at_begin else over, metres[-1] - (0.0 if at_end else over)
    if last <= first:
        return np.zeros((0, 4, 2))
    at = np.linspace(first, last, int(np.ceil((last - first) / STEP)) + 1)
    x, y = (np.interp(at, metres, lane.line[:, k]) for k in (0, 1))
    piece = np.clip(np.searchsorted(metres, at) - 1, 0, len(metres) - 2)
    ahead = np.diff(lane.line, axis=0)[piece]
    ahead /= np.hypot(*ahead.T)[:, None]
    left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
    corners = [(1, 1), (1, -1), (-1, -1), (-1, 1)]
    middle = np.stack([x, y], axis=1)
    return np.stack([middle + a * CAR[0] / 2 * ahead + b * CAR[1] / 2 * left for a, b in corners], axis=1)
