"""Arrays of a RoadMap from a map file without faults, and a stack of several RoadMaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from jaxwalk.maps.file import MapFile
from jaxwalk.maps.layout import compact, lay_out, points_for
from jaxwalk.maps.map_network import network_of
from jaxwalk.maps.network_routes import SampledRoute
from jaxwalk.maps.road_field import MOST_UNITS
from jaxwalk.maps.road_map import RoadMap
from jaxwalk.maps.routes import ROUTE_SPACING, centre_lines, lane_route, make_road, sample

_PADDING: dict[str, Any] = {
    "edges": -1, "distance": np.inf,
    "side_landing": -1, "zone_node": -1, "zone_piece": 1.0, "node_side": -1, "route_places": -1,
    "route_cos": 1.0, "route_limit": np.inf,
    "field": np.full(4, -MOST_UNITS, np.int8).view("<i4"),
}  # fmt: skip
"""Padding values of the fields that aren't padded with 0."""


def build(file: MapFile, *, goal_spacing: float, start_clearance: float) -> RoadMap:
    """Return the arrays (numpy, float32, int32 and bool) of a map file that has passed the checks.

    They are those of its network, but for its routes, whose arcs are exact.
    """
    routes = _routes(file)
    laid_out = lay_out(network_of(file), routes, goal_spacing=goal_spacing, start_clearance=start_clearance)
    own = {
        "half_width": min(make_road(name, area).width for name, area in file.roads.items()) / 2,
        "route_places": file.car.pairs(),
    }
    compacted: dict[str, Any] = {name: compact(value) for name, value in own.items()}
    return replace(laid_out, **compacted)


def _routes(file: MapFile) -> list[SampledRoute]:
    """Return all routes, with equally many points."""
    radii, lines = (file.car.right_turn_radius, file.car.left_turn_radius), centre_lines(file)
    routes = [lane_route(lines, start, goal, radii) for start, goal in file.car.pairs()]
    along = np.arange(points_for([length for _, length in routes])) * ROUTE_SPACING
    unlimited = np.full(len(along), np.inf)
    return [SampledRoute(*sample(pieces, along), unlimited, length) for pieces, length in routes]


def stack_maps(maps: Sequence[RoadMap], *, rounded: bool = False) -> RoadMap:
    """Pad maps (one or more) to a common size and stack them along a new leading axis. Raises ValueError if empty.

    ``rounded``: all sizes are rounded up to few different ones, so that other maps often have the same shapes; the
    first map is repeated to round up their number.
    """
    if not maps:
        raise ValueError("stack_maps needs at least one map")
    arrays: dict[str, Any] = {}
    size = rounded_up if rounded else int
    for field in fields(RoadMap):
        each = [np.asarray(getattr(road_map, field.name)) for road_map in maps]
        each += each[:1] * (size(len(maps)) - len(maps))
        shape = tuple(size(max(sizes)) for sizes in zip(*(array.shape for array in each), strict=True))
        arrays[field.name] = np.stack([_pad(field.name, array, shape) for array in each])
    return RoadMap(**arrays)


def rounded_up(size: int) -> int:
    """Return the next number of the row 1, 2, 3, 4, 6, 8, 12, 16, 24, 32 ...; 0 remains."""
    power = 1 << max(size - 1, 0).bit_length()
    return size if size < 2 else power * 3 // 4 if size <= power * 3 // 4 else power


def _pad(name: str, array: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Pad one field of a map at the end of each axis up to ``shape``."""
    padded = np.empty(shape, array.dtype)
    padded[...] = _PADDING.get(name, 0)
    if name == "next_hop":  # a node without a way is its own next hop
        padded[...] = np.arange(shape[0])[:, None]
    if name in ("route_x", "route_y"):  # straight on, as beyond the goal, along the line through the last two points
        points = array.shape[1]
        further = np.arange(1, shape[1] - points + 1, dtype=array.dtype)
        padded[: len(array), points:] = array[:, -1:] + further * (array[:, -1:] - array[:, -2:-1])
    if name in ("route_cos", "route_sin", "route_limit"):
        padded[: len(array), array.shape[1] :] = array[:, -1:]
    padded[tuple(slice(0, size) for size in array.shape)] = array
    return padded
