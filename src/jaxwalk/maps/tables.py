"""Arrays of a RoadMap from a map file without faults, and a stack of several RoadMaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from jaxwalk.maps.file import MapFile
from jaxwalk.maps.navigation import Graph, build_graph, goal_choices, shortest_ways, start_choices
from jaxwalk.maps.road_map import RoadMap
from jaxwalk.maps.routes import ROUTE_SPACING, centre_lines, lane_route, sample
from jaxwalk.maps.zones import zone_from_landing

BEYOND_GOAL = 30.0
"""Length by which every route continues past its goal, at least [m]."""

_EMPTY = np.array([np.inf, np.inf, -np.inf, -np.inf], np.float32)
_PADDING: dict[str, Any] = {
    "roads": _EMPTY, "sidewalks": _EMPTY, "crosswalks": _EMPTY, "edges": -1, "distance": np.inf,
    "side_landing": -1, "side_outer": -1, "node_side": -1, "route_places": -1, "route_cos": 1.0,
}  # fmt: skip
"""Padding values of the fields that aren't padded with 0."""


def build(file: MapFile, *, goal_spacing: float, start_clearance: float) -> RoadMap:
    """Return the arrays (numpy, float32, int32 and bool) of a map file that has passed the checks."""
    graph = build_graph(file)
    arrays: dict[str, Any] = {
        "width": file.size[0],
        "height": file.size[1],
        "roads": list(file.roads.values()),
        "sidewalks": list(file.sidewalks.values()),
        "crosswalks": [crosswalk.area for crosswalk in file.crosswalks.values()],
        **_walking(graph, goal_spacing),
        **_crossing(file, graph),
        **_driving(file, graph, start_clearance),
    }
    compact: dict[str, Any] = {name: _compact(value) for name, value in arrays.items()}
    return RoadMap(**compact)


def stack_maps(maps: Sequence[RoadMap]) -> RoadMap:
    """Pad maps (one or more) to a common size and stack them along a new leading axis. Raises ValueError if empty."""
    if not maps:
        raise ValueError("stack_maps needs at least one map")
    arrays: dict[str, Any] = {}
    for field in fields(RoadMap):
        each = [np.asarray(getattr(road_map, field.name)) for road_map in maps]
        shape = tuple(max(sizes) for sizes in zip(*(array.shape for array in each), strict=True))
        arrays[field.name] = np.stack([_pad(field.name, array, shape) for array in each])
    return RoadMap(**arrays)


def _walking(graph: Graph, goal_spacing: float) -> dict[str, Any]:
    """Return nodes, edges, shortest ways and goals."""
    distance, next_hop = shortest_ways(graph)
    choices, count = _table(goal_choices(graph, distance, goal_spacing))
    return {
        "node_x": graph.points[:, 0],
        "node_y": graph.points[:, 1],
        "node_is_midpoint": np.arange(len(graph.points)) >= graph.waypoints,
        "edges": graph.edges,
        "next_hop": next_hop,
        "distance": distance,
        "goal_choices": choices,
        "goal_count": count,
    }


def _crossing(file: MapFile, graph: Graph) -> dict[str, Any]:
    """Return the two sides of each crosswalk, with their jaywalk zones."""
    index = {name: number for number, name in enumerate(file.waypoints)}
    sides = [(crosswalk, side) for crosswalk in file.crosswalks.values() for side in crosswalk.sides]
    landings = [index[side.landing] for _, side in sides]
    zones = [zone_from_landing(crosswalk, side, file.waypoints) for crosswalk, side in sides]
    node_side = np.full(len(graph.points), -1)
    node_side[landings] = np.arange(len(sides))
    return {
        "side_landing": landings,
        "side_outer": [index[side.outer] for _, side in sides],
        "side_ux": [unit[0] for unit, _, _ in zones],
        "side_uy": [unit[1] for unit, _, _ in zones],
        "zone_near": [near for _, near, _ in zones],
        "zone_far": [far for _, _, far in zones],
        "node_side": node_side,
    }


def _driving(file: MapFile, graph: Graph, start_clearance: float) -> dict[str, Any]:
    """Return the car's routes, and the waypoints where pedestrians may start on each."""
    radii = (file.car.right_turn_radius, file.car.left_turn_radius)
    lines = centre_lines(file)
    pairs = file.car.pairs()
    routes = [lane_route(lines, start, goal, radii) for start, goal in pairs]
    lengths = [length for _, length in routes]
    points = int(np.ceil((max(lengths) + BEYOND_GOAL) / ROUTE_SPACING)) + 1
    along = np.arange(points) * ROUTE_SPACING
    sampled = [sample(pieces, along) for pieces, _ in routes]
    places, tangents = (np.stack(each) for each in zip(*sampled, strict=True))
    choices, count = _table([start_choices(graph, tuple(place[0]), start_clearance) for place in places])
    return {
        "route_count": len(pairs),
        "route_places": pairs,
        "route_x": places[..., 0],
        "route_y": places[..., 1],
        "route_cos": tangents[..., 0],
        "route_sin": tangents[..., 1],
        "route_length": lengths,
        "start_choices": choices,
        "start_count": count,
    }


def _table(rows: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return rows of different lengths as one int table, padded with 0, and their lengths."""
    count = np.array([len(row) for row in rows], int)
    table = np.zeros((len(rows), count.max(initial=0)), int)
    for line, row in zip(table, rows, strict=True):
        line[: len(row)] = row
    return table, count


def _compact(value: Any) -> np.ndarray:
    """Return a value as an array of bool, int32 or float32."""
    array = np.asarray(value)
    if array.dtype == bool:
        return array
    return array.astype(np.int32 if np.issubdtype(array.dtype, np.integer) else np.float32)


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
    if name in ("route_cos", "route_sin"):
        padded[: len(array), array.shape[1] :] = array[:, -1:]
    padded[tuple(slice(0, size) for size in array.shape)] = array
    return padded
