"""The rasteriser: arrays of a RoadMap from a network without faults."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import shapely

from jaxwalk.maps.check_walking import graph_of
from jaxwalk.maps.navigation import Graph, goal_choices, shortest_ways, start_choices
from jaxwalk.maps.network import Crossing, Network
from jaxwalk.maps.network_routes import SampledRoute, route_length, sampled_route
from jaxwalk.maps.network_zones import ZoneLines
from jaxwalk.maps.parking_slots import parking_slots
from jaxwalk.maps.road_field import road_field
from jaxwalk.maps.road_map import RoadMap
from jaxwalk.maps.routes import ROUTE_SPACING
from jaxwalk.maps.walls import walls

BEYOND_GOAL = 30.0
"""Length by which every route continues past its goal, at least [m]."""


def lay_out(
    network: Network, routes: list[SampledRoute] | None = None, *, goal_spacing: float, start_clearance: float
) -> RoadMap:
    """Return the arrays (numpy, float32, int32 and bool) of a network that has passed the checks.

    ``routes``, if given, stand for the network's own; they have equally many points.
    """
    graph, roadway = graph_of(network.walk), network.surface("roadway")
    shapely.prepare(roadway)
    arrays: dict[str, Any] = {
        "width": network.size[0],
        "height": network.size[1],
        "field": road_field(roadway, network.size),
        "half_width": min(lane.width for lane in network.lanes) / 2,
        **_hiding(network),
        **_walking(graph, goal_spacing),
        **_crossings(network, roadway),
        **_driving(_routes(network) if routes is None else routes, graph, start_clearance),
    }
    compacted: dict[str, Any] = {name: compact(value) for name, value in arrays.items()}
    return RoadMap(**compacted)


def _hiding(network: Network) -> dict[str, Any]:
    """Return what people can hide behind."""
    slots, standing = parking_slots(network), walls(network)
    return {"slots": slots, "slot_count": len(slots), "walls": standing, "wall_count": len(standing)}


def _walking(graph: Graph, goal_spacing: float) -> dict[str, Any]:
    """Return nodes, edges, shortest ways and goals."""
    distance, next_hop = shortest_ways(graph)
    choices, count = _table(goal_choices(graph, distance, goal_spacing))
    return {
        "node_x": graph.points[:, 0],
        "node_y": graph.points[:, 1],
        "edges": graph.edges,
        "next_hop": next_hop,
        "distance": distance,
        "goal_choices": choices,
        "goal_count": count,
    }


def _crossings(network: Network, roadway: shapely.geometry.base.BaseGeometry) -> dict[str, Any]:
    """Return the nodes of crossings, and the two sides of each one, with their jaywalk zones."""
    nodes = network.walk.nodes
    inner, clear = np.zeros(len(nodes), bool), np.zeros(len(nodes))
    for crossing in network.crossings:
        inner[list(crossing.nodes[1:-1])] = True
    for a, b in [pair for crossing in network.crossings for pair in pairwise(crossing.nodes)]:
        on_roadway = shapely.LineString(nodes[[a, b]]).intersection(roadway)
        clear[[a, b]] = shapely.distance(shapely.points(nodes[[a, b]]), on_roadway)
    landings = [landing for x in network.crossings for landing in (x.nodes[0], x.nodes[-1])]
    node_side = np.full(len(nodes), -1)
    node_side[landings] = np.arange(len(landings))
    pieces = max([len(x.zone.sides[0]) - 1 for x in network.crossings if x.zone is not None], default=1)
    zones = [zone for x in network.crossings for zone in _zones(x, network, roadway, pieces)]
    return {
        "node_is_midpoint": inner,
        "node_clear": clear,
        "node_side": node_side,
        "side_landing": landings,
        **{name: np.stack([zone[name] for zone in zones]) for name in zones[0]},
    }


def _zones(
    crossing: Crossing, network: Network, roadway: shapely.geometry.base.BaseGeometry, pieces: int
) -> list[dict[str, Any]]:
    """Return the zone of each side of a crossing, on lines of as many pieces; further pieces have no length."""
    if crossing.zone is None:
        ends = [(landing, landing) for landing in (crossing.nodes[0], crossing.nodes[-1])]
        empty = {"zone_near": 0.0, "zone_far": -1.0, "zone_piece": 1.0, "zone_kerb": np.zeros(pieces)}
        return [empty | {"zone_node": np.resize(end, pieces + 1)} for end in ends]
    lines = ZoneLines.of(network, crossing.zone)
    own = len(lines.pieces)
    found = []
    for side, chain in enumerate(crossing.zone.sides):
        middles = shapely.points((lines.sides[side, :-1] + lines.sides[side, 1:]) / 2)
        found.append({
            "zone_near": crossing.zone.begin,
            "zone_far": crossing.zone.end,
            "zone_piece": lines.piece[side],
            "zone_kerb": np.pad(shapely.distance(middles, roadway), (0, pieces - own), mode="edge"),
            "zone_node": np.pad(np.array(chain), (0, pieces - own), mode="edge"),
        })  # fmt: skip
    return found


def _routes(network: Network) -> list[SampledRoute]:
    """Return all routes, with equally many points."""
    points = points_for([route_length(network, route) for route in network.routes])
    return [sampled_route(network, route, points) for route in network.routes]


def points_for(lengths: list[float]) -> int:
    """Return how many points reach far enough beyond the goal of the longest route."""
    return int(np.ceil((max(lengths) + BEYOND_GOAL) / ROUTE_SPACING)) + 1


def _driving(routes: list[SampledRoute], graph: Graph, start_clearance: float) -> dict[str, Any]:
    """Return the car's routes, and the waypoints where pedestrians may start on each."""
    places, tangents = np.stack([x.points for x in routes]), np.stack([x.tangents for x in routes])
    choices, count = _table([start_choices(graph, tuple(place[0]), start_clearance) for place in places])
    return {
        "route_count": len(routes),
        "route_places": np.full((len(routes), 2), -1),
        "route_x": places[..., 0],
        "route_y": places[..., 1],
        "route_cos": tangents[..., 0],
        "route_sin": tangents[..., 1],
        "route_limit": np.stack([x.limits for x in routes]),
        "route_length": [route.length for route in routes],
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


def compact(value: Any) -> np.ndarray:
    """Return a value as an array of bool, int32 or float32."""
    array = np.asarray(value)
    if array.dtype == bool:
        return array
    return array.astype(np.int32 if np.issubdtype(array.dtype, np.integer) else np.float32)
