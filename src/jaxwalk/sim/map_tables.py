"""Pack maps into tables from which a step needs only a few look-ups."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from jaxwalk.maps import RoadMap
from jaxwalk.maps.routes import ROUTE_SPACING
from jaxwalk.sim.sim_config import SimConfig

SIDE_BITS, NODE_BITS = 12, 12
NO_SIDE = (1 << SIDE_BITS) - 1

POINT_SPACING = 2.5
"""Distance that separates possible points of the route ahead [m]."""
POINTS = (1, 2, 3, 4, 5, 6, 8, 10)
"""The points of the route ahead that are shown, as multiples of `POINT_SPACING`."""

LIMIT = 4
"""The column of `Tables.course` with the speed limit."""


class Tables(eqx.Module):
    """What a step needs to know about the maps, with one look-up for people at the end of a leg and one for the car."""

    hop: Int[Array, "map node goal"]
    """Bits: next node; whether that node, and whether the node itself, lies between the landings of a crossing; the
    side of the crossing that a pedestrian decides about when it leaves the node (NO_SIDE: none)."""
    side: dict[str, Float[Array, "map side"]]
    """The columns `SIDE_COLUMNS` of each side of a crossing."""
    zone: dict[str, Float[Array, "map side piece"]]
    """The columns `ZONE_COLUMNS` of each piece of the line along which a side's jaywalk zone lies. A place in a zone is
    a number of pieces from the landing."""
    place: Float[Array, "map side node"]
    """The place of each node on a side's line; -1 off it."""
    walk: Float[Array, "map side node"]
    """From each of these nodes along the line to the landing [m]; 0 off it."""
    turn: Float[Array, "map side piece goal"]
    """If a jaywalk ends at this place of a piece or before, the shortest way to a goal leads past the piece's first
    node, else past its second one."""
    course: Float[Array, "map route point column"]
    """At each point of a route: position [m], direction, speed limit [m/s], then x and then y of the `POINTS` ahead
    [m]."""
    finish: Float[Array, "map route 3"]
    """Each route's x and y of the goal, in its lane, and its metres from start to goal."""


SIDE_COLUMNS = ("near", "far", "piece", "clear")
"""A side's zone, as places (without a zone, far is below near); the length of a piece, half-way between the two sides
[m]; the distance from the landing along the crossing to the roadway [m]."""
ZONE_COLUMNS = ("x", "y", "dx", "dy", "kerb")
"""The first point of a piece [m], the vector to its last point [m], the distance from the piece to the roadway [m]."""


class Hop(eqx.Module):
    """An unpacked entry of ``Tables.hop``."""

    node: Array
    to_midpoint: Array
    from_midpoint: Array
    side: Array
    """-1 where there is nothing to decide."""


def unpack_hop(entry: Array) -> Hop:
    """Unpack entries of ``Tables.hop``."""
    side = (entry >> (NODE_BITS + 2)) & NO_SIDE
    return Hop(
        node=entry & ((1 << NODE_BITS) - 1),
        to_midpoint=(entry >> NODE_BITS) & 1 == 1,
        from_midpoint=(entry >> (NODE_BITS + 1)) & 1 == 1,
        side=jnp.where(side == NO_SIDE, -1, side),
    )


def pack_tables(maps: RoadMap, config: SimConfig) -> dict[str, Any]:
    """Return the fields of `Tables` for stacked maps, as NumPy arrays."""
    each = [_pack_map(_entry(maps, i)) for i in range(len(maps.width))]
    course, finish = _pack_routes(maps, config)
    return jax.tree.map(lambda *tables: np.stack(tables), *each) | {"course": course, "finish": finish}


def shortest_crossing(maps: RoadMap) -> float:
    """Return the shortest way from a landing or a zone's node straight to the opposite one [m]."""
    shortest = np.inf
    for i in range(len(maps.width)):
        m = _entry(maps, i)
        one, other = (m["zone_node"][side::2] for side in (0, 1))
        if one.shape[1] == 2:  # straight zones are as wide as their crossings; their last nodes needn't face each other
            one, other = one[:, :1], other[:, :1]
        widths = np.hypot(m["node_x"][one] - m["node_x"][other], m["node_y"][one] - m["node_y"][other])
        shortest = min(shortest, widths[one >= 0].min())
    return float(shortest)


def _pack_routes(maps: RoadMap, config: SimConfig) -> tuple[np.ndarray, np.ndarray]:
    """Return the tables ``course`` and ``finish``. A point ahead beyond the route's last point is the last one."""
    x, y, cos, sin, length = (
        np.asarray(field) for field in (maps.route_x, maps.route_y, maps.route_cos, maps.route_sin, maps.route_length)
    )
    ahead = np.round(np.array(POINTS) * POINT_SPACING / ROUTE_SPACING).astype(int)
    seen = np.minimum(np.arange(x.shape[-1])[:, None] + ahead, x.shape[-1] - 1)
    limits = speed_limits(cos, sin, np.asarray(maps.route_limit), config)
    course = np.concatenate([np.stack([x, y, cos, sin, limits], -1), x[..., seen], y[..., seen]], -1)
    last = np.round(length / ROUTE_SPACING).astype(int)
    beyond = length - last * ROUTE_SPACING
    at = [np.take_along_axis(field, last[..., None], -1)[..., 0] for field in (x, y, cos, sin)]
    finish = np.stack([at[0] + at[2] * beyond, at[1] + at[3] * beyond, length], -1)
    return course.astype(np.float32), finish.astype(np.float32)


def speed_limits(
    cos: Float[np.ndarray, "*route point"],
    sin: Float[np.ndarray, "*route point"],
    of_lanes: Float[np.ndarray, "*route point"],
    config: SimConfig,
) -> Float[np.ndarray, "*route point"]:
    """Return the speed limits at the points of routes [m/s]: the lanes', and what ``max_lateral`` allows in bends.

    Before a lower limit they fall as slowly as a car that brakes by as much as ``max_acceleration``, so that a car at
    full throttle keeps to them.
    """
    before, after = (np.pad(x, [(0, 0)] * (cos.ndim - 1) + [(1, 1)], mode="edge") for x in (cos, sin))
    turned = np.abs(np.arctan2(
        before[..., :-2] * after[..., 2:] - after[..., :-2] * before[..., 2:],
        before[..., :-2] * before[..., 2:] + after[..., :-2] * after[..., 2:],
    ))  # fmt: skip
    bend = np.sqrt(config.max_lateral * 2 * ROUTE_SPACING / np.maximum(turned, 1e-9))
    squared = np.minimum(bend, of_lanes) ** 2
    gained = 2 * config.max_acceleration * ROUTE_SPACING
    for point in reversed(range(squared.shape[-1] - 1)):
        squared[..., point] = np.minimum(squared[..., point], squared[..., point + 1] + gained)
    return np.sqrt(squared)


def _entry(maps: RoadMap, i: int):
    """Return map ``i`` of stacked maps, as NumPy arrays by name."""
    return {name: np.asarray(value)[i] for name, value in vars(maps).items()}


def _pack_map(m: dict) -> dict[str, Any]:
    """Return the fields of `Tables` of one map, but for its routes."""
    lines = np.clip(m["zone_node"], 0, None)
    x, y = m["node_x"][lines], m["node_y"][lines]
    zone = {"x": x[:, :-1], "y": y[:, :-1], "dx": np.diff(x), "dy": np.diff(y), "kerb": m["zone_kerb"]}
    side = {
        "near": m["zone_near"] / m["zone_piece"],
        "far": m["zone_far"] / m["zone_piece"],
        "piece": m["zone_piece"],
        "clear": m["node_clear"][np.clip(m["side_landing"], 0, None)],
    }
    lengths = np.hypot(zone["dx"], zone["dy"])
    places, walk = _on_lines(m, lengths)
    single = {"place": places, "walk": walk, "turn": _turns(m, lines, lengths)}
    rows = jax.tree.map(lambda table: np.asarray(table, np.float32), {"side": side, "zone": zone} | single)
    return {"hop": _hops(m).astype(np.int32)} | rows


def _hops(m: dict) -> np.ndarray:
    """Return the table ``hop``.

    A crossing is decided about where the last edge before its landing begins; and, on the line along which people may
    jaywalk beside it, wherever the way follows that line to the landing.
    """
    nodes = np.arange(len(m["node_x"]))
    midpoint, following = m["node_is_midpoint"], np.clip(m["next_hop"], 0, None)
    after = following[following, nodes[None, :]]
    here, ahead = m["node_side"][:, None], m["node_side"][following]
    side = np.where(midpoint[following], here, np.where(midpoint[after], ahead, -1))
    for number, line in enumerate(m["zone_node"]):
        leads = midpoint[following[line[0]]] & (line[0] >= 0)
        for before, node in pairwise(dict.fromkeys(line.tolist())):
            leads = leads & (following[node] == before)
            side[node] = np.where(leads, number, side[node])
    side = np.where(midpoint[:, None] | (side < 0), NO_SIDE, side)
    return following | midpoint[following] << NODE_BITS | midpoint[:, None] << (NODE_BITS + 1) | side << (NODE_BITS + 2)


def _on_lines(m: dict, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the tables ``place`` and ``walk`` from the lengths of all pieces (side, piece) [m]."""
    places = np.full((len(m["zone_node"]), len(m["node_x"])), -1.0)
    walk = np.zeros(places.shape)
    for side, line in enumerate(m["zone_node"]):
        metres = np.concatenate([[0], lengths[side].cumsum()])
        on = np.array([*dict.fromkeys(line[line >= 0].tolist())], int)
        places[side, on], walk[side, on] = np.arange(len(on)), metres[: len(on)]
    return places, walk


def _turns(m: dict, lines: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return the table ``turn`` from the nodes of the lines (side, point) and their lengths (side, piece) [m]."""
    distance = np.where(np.isfinite(m["distance"]), m["distance"], 0)  # infinite only where there is padding
    further = distance[lines[:, 1:]] - distance[lines[:, :-1]]
    share = (1 + further / np.maximum(lengths, 1e-6)[..., None]) / 2
    return np.arange(lengths.shape[1])[:, None] + share
