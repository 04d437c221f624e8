"""Pack maps into tables from which a step needs only a few look-ups."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from jaxwalk.maps import RoadMap
from jaxwalk.maps.routes import ROUTE_SPACING

SIDE_BITS, NODE_BITS = 12, 12
NO_SIDE = (1 << SIDE_BITS) - 1

POINT_SPACING = 2.5
"""Distance that separates possible points of the route ahead [m]."""
POINTS = (1, 2, 3, 4, 5, 6, 8, 10)
"""The points of the route ahead that are shown, as multiples of `POINT_SPACING`."""


class Tables(eqx.Module):
    """What a step needs to know about the maps, with one look-up for people at the end of a leg and one for the car."""

    hop: Int[Array, "map node goal"]
    """Bits: next node; whether that node, and whether the node itself, is a crosswalk's midpoint; the side of the
    crosswalk that a pedestrian decides about when it leaves the node (NO_SIDE: none)."""
    side: dict[str, Float[Array, "map side"]]
    """The columns `SIDE_COLUMNS` of each side of a crosswalk."""
    turn: Float[Array, "map side goal"]
    """If a jaywalk ends this close to a side's landing or closer [m], the shortest way to a goal leads past that
    landing, else past the zone's outer node."""
    course: Float[Array, "map route point column"]
    """At each point of a route: position [m], direction, then x and then y of the `POINTS` ahead [m]."""
    finish: Float[Array, "map route 3"]
    """Each route's x and y of the goal, in its lane, and its metres from start to goal."""


SIDE_COLUMNS = (
    "x", "y", "ux", "uy", "near", "far", "across_x", "across_y", "landing_to_kerb", "far_near", "far_far",
    "far_landing", "far_outer",
)  # fmt: skip
"""A side's landing [m], unit vector and zone along the kerb [m], vector to the opposite landing [m], distance from the
landing to the kerb [m], zone of the opposite side [m], and that side's landing and outer node."""


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


def pack_tables(maps: RoadMap) -> dict[str, Any]:
    """Return the fields of `Tables` for stacked maps, as NumPy arrays."""
    count = np.asarray(maps.roads).shape[0]
    each = [_pack_map(_entry(maps, i)) for i in range(count)]
    hop, side, turn = (np.stack(tables) for tables in zip(*each, strict=True))
    course, finish = _pack_routes(maps)
    sides = {name: side[..., i] for i, name in enumerate(SIDE_COLUMNS)}
    return {"hop": hop, "side": sides, "turn": turn, "course": course, "finish": finish}


def shortest_crossing(side: Mapping[str, np.ndarray]) -> float:
    """Return the shortest distance between the two landings of a crosswalk [m], from ``Tables.side``."""
    widths = np.hypot(side["across_x"], side["across_y"])
    return float(widths[side["landing_to_kerb"] > 0].min())


def _pack_routes(maps: RoadMap) -> tuple[np.ndarray, np.ndarray]:
    """Return the tables ``course`` and ``finish``. A point ahead beyond the route's last point is the last one."""
    x, y, cos, sin, length = (
        np.asarray(field) for field in (maps.route_x, maps.route_y, maps.route_cos, maps.route_sin, maps.route_length)
    )
    ahead = np.round(np.array(POINTS) * POINT_SPACING / ROUTE_SPACING).astype(int)
    seen = np.minimum(np.arange(x.shape[-1])[:, None] + ahead, x.shape[-1] - 1)
    course = np.concatenate([np.stack([x, y, cos, sin], -1), x[..., seen], y[..., seen]], -1)
    last = np.round(length / ROUTE_SPACING).astype(int)
    beyond = length - last * ROUTE_SPACING
    at = [np.take_along_axis(field, last[..., None], -1)[..., 0] for field in (x, y, cos, sin)]
    finish = np.stack([at[0] + at[2] * beyond, at[1] + at[3] * beyond, length], -1)
    return course.astype(np.float32), finish.astype(np.float32)


def _entry(maps: RoadMap, i: int):
    """Return map ``i`` of stacked maps, as NumPy arrays by name."""
    return {name: np.asarray(value)[i] for name, value in vars(maps).items()}


def _pack_map(m: dict) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return ``hop``, the columns of ``side`` and ``turn`` of one map."""
    nodes = np.arange(len(m["node_x"]))
    midpoint, following = m["node_is_midpoint"], np.clip(m["next_hop"], 0, None)
    goals = nodes[None, :]
    after = following[following, goals]
    here, ahead = m["node_side"][:, None], m["node_side"][following]
    side = np.where(midpoint[following], here, np.where(midpoint[after], ahead, -1))
    side = np.where(midpoint[:, None] | (side < 0), NO_SIDE, side)
    hop = following | midpoint[following] << NODE_BITS | midpoint[:, None] << (NODE_BITS + 1) | side << (NODE_BITS + 2)

    real = m["side_landing"] >= 0
    other = np.arange(len(real)) ^ 1
    landing, outer = np.clip(m["side_landing"], 0, None), np.clip(m["side_outer"], 0, None)
    x, y = m["node_x"][landing], m["node_y"][landing]
    to_kerb = np.where(real, _landing_to_kerb(m, landing, other), 0)
    columns = (x, y, m["side_ux"], m["side_uy"], m["zone_near"], m["zone_far"], x[other] - x, y[other] - y, to_kerb,
               m["zone_near"][other], m["zone_far"][other], landing[other], outer[other])  # fmt: skip
    edge = np.hypot(m["node_x"][outer] - x, m["node_y"][outer] - y)
    distance = np.where(np.isfinite(m["distance"]), m["distance"], 0)  # infinite only where there is padding
    turn = (edge[:, None] + distance[outer] - distance[landing]) / 2
    return hop.astype(np.int32), np.stack(columns, 1).astype(np.float32), turn.astype(np.float32)


def _landing_to_kerb(m: dict, landing: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the distance from each landing straight to the roadway that its crosswalk crosses half-way [m]."""
    x, y = m["node_x"][landing][:, None], m["node_y"][landing][:, None]
    middle_x, middle_y = (x + x[other]) / 2, (y + y[other]) / 2
    x0, y0, x1, y1 = m["roads"].T
    crossed = (x0 < middle_x) & (middle_x < x1) & (y0 < middle_y) & (middle_y < y1)
    away = np.hypot(np.maximum(np.maximum(x0 - x, x - x1), 0), np.maximum(np.maximum(y0 - y, y - y1), 0))
    return np.where(crossed, away, np.inf).min(axis=1)
