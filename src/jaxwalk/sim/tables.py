"""Looking things up in maps from inside a step, and the tables that make it few look-ups."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from jaxwalk.maps import RoadMap
from jaxwalk.maps.road_map import ROUTE_SPACING

SIDE_BITS, NODE_BITS = 12, 12
NO_SIDE = (1 << SIDE_BITS) - 1
IN_BOUNDS: Any = {"mode": "promise_in_bounds", "wrap_negative_indices": False}
"""Of an index that needs no checks: nobody may know what comes of one that is below 0 or beyond the last."""


POINT_SPACING = 2.5
"""The route ahead is shown at multiples of this distance [m] ..."""
POINTS = (1, 2, 3, 4, 5, 6, 8, 10)
"""... namely these."""


class Tables(eqx.Module):
    """What a step needs to know of the maps, packed so that it is one look-up each: for people at the end of a leg, and
    for the car on its route."""

    hop: Int[Array, "map node goal"]
    """Bits: next node; whether that node, and whether the node itself, is a crosswalk's midpoint; the crosswalk side
    about which a pedestrian decides when it leaves the node (NO_SIDE: none)."""
    side: dict[str, Float[Array, "map side"]]
    """By the names in `SIDE_COLUMNS`."""
    turn: Float[Array, "map side goal"]
    """After a jaywalk that ends this far or less from the landing of a side [m], the shortest way to a goal leads by
    that landing, else by the zone's outer node."""
    course: Float[Array, "map route point column"]
    """At each point of a route: position [m], direction, then x and then y of the `POINTS` ahead [m]."""
    finish: Float[Array, "map route 3"]
    """Of each route: x and y of the goal, in its lane, and metres from start to goal."""
    shortest_crossing: float = eqx.field(static=True)
    """Shortest distance between the two landings of a crosswalk [m]."""


SIDE_COLUMNS = (
    "x", "y", "ux", "uy", "near", "far", "across_x", "across_y", "kerb", "far_near", "far_far", "far_landing",
    "far_outer",
)  # fmt: skip
"""Of a side: its landing [m], unit vector and zone along the kerb [m], vector to the opposite landing [m], distance
from the landing to the kerb [m], zone of the opposite side [m], and that side's landing and outer node."""


class Hop(eqx.Module):
    """An unpacked entry of ``Tables.hop``."""

    node: Array
    to_midpoint: Array
    from_midpoint: Array
    side: Array
    """-1 where there is nothing to decide."""


def look_up(table: Array, *index: Array) -> Array:
    """``table[index]`` for index arrays that broadcast against each other; one flat gather, without bounds checks."""
    return look_up_each((table,), *index)[0]


def look_up_each(tables: Sequence[Array], *index: Array) -> list[Array]:
    """`look_up` in tables of one shape. A barrier has the places worked out once, not again in every gather; as a list,
    because that gathers faster than an array of them."""
    flat = jnp.zeros((), jnp.int32)
    for size, i in zip(tables[0].shape, index, strict=True):
        flat = flat * size + i
    places = jax.lax.optimization_barrier(flat.reshape(-1))
    return [table.reshape(-1).at[places].get(**IN_BOUNDS).reshape(flat.shape) for table in tables]


def look_up_row(table: Array, *index: Array) -> Array:
    """``table[index]`` for a table with one axis more than there are indices; that axis leads in the result."""
    flat = jnp.zeros((), jnp.int32)
    for size, i in zip(table.shape[:-1], index, strict=True):
        flat = flat * size + i
    rows = table.reshape(-1, table.shape[-1]).at[flat.reshape(-1)].get(**IN_BOUNDS)
    return jax.lax.optimization_barrier(rows.T).reshape(-1, *flat.shape)  # transposed once, not by every reader


def for_everybody(people: Any, body: Callable[[Any, Any], Any], begin: Any) -> Any:
    """``body(person, found)`` for one person after the other: neighbours and minima without an array of all pairs.

    ``people``: arrays ``(ped, ...)``, of which the body gets each person's ``(1, ...)``.

    Three turns at a time are written out, so that one pass over the environments does them; between passes the
    compiler keeps ``found``, where it would otherwise work out again what goes into it, for every reader.
    """

    def turn(index: Array, found: Any) -> Any:
        one = partial(jax.lax.dynamic_index_in_dim, index=index, allow_negative_indices=False)
        return body(jax.tree.map(one, people), found)

    (count,) = {len(of_all) for of_all in jax.tree.leaves(people)}
    return jax.lax.fori_loop(0, count, turn, begin, unroll=3)


def with_index(squared: Array, index: Array, people: int) -> Array:
    """Squared distances as integers in the same order, with an index 0 .. ``people`` in the last bits (`index_of`).

    So no two are the same, and the smallest one says whose it is. Distances nearer to each other than 1 part in 65,000
    (200 people; a million, for 12) may be taken for equal. They must be finite.
    """
    mask = (1 << people.bit_length()) - 1
    return (jax.lax.bitcast_convert_type(squared, jnp.int32) & ~mask) | index.astype(jnp.int32)


def index_of(key: Array, people: int) -> Array:
    """The index that `with_index` put into it."""
    return key & ((1 << people.bit_length()) - 1)


def of_map(table: Array, map_index: Array) -> Array:
    """Each episode's own entry of a small table: ``(map, ...)`` to ``(..., *batch)``."""
    if table.shape[0] == 1:
        return jnp.reshape(table[0], table.shape[1:] + (1,) * map_index.ndim)
    return jnp.moveaxis(table[map_index], tuple(range(map_index.ndim)), tuple(range(-map_index.ndim, 0)))


def inside(rectangles: Float[Array, "map rectangle 4"], map_index: Array, x: Array, y: Array) -> Array:
    """Whether points lie in any of the map's rectangles (kerbs belong to the sidewalk)."""
    boxes = of_map(rectangles, map_index)
    boxes = boxes.reshape(*boxes.shape[:2], *(1,) * (x.ndim + 2 - boxes.ndim), *boxes.shape[2:])
    x0, y0, x1, y1 = jnp.unstack(boxes, axis=1)
    return ((x > x0) & (x < x1) & (y > y0) & (y < y1)).any(axis=0)


def unpack_hop(entry: Array) -> Hop:
    """Undo the packing of `pack_tables`."""
    side = (entry >> (NODE_BITS + 2)) & NO_SIDE
    return Hop(
        node=entry & ((1 << NODE_BITS) - 1),
        to_midpoint=(entry >> NODE_BITS) & 1 == 1,
        from_midpoint=(entry >> (NODE_BITS + 1)) & 1 == 1,
        side=jnp.where(side == NO_SIDE, -1, side),
    )


def pack_tables(maps: RoadMap) -> Tables:
    """Make the tables of stacked maps, once, in NumPy."""
    count = np.asarray(maps.roads).shape[0]
    one = [_pack_map(_entry(maps, i)) for i in range(count)]
    widths = np.concatenate([np.hypot(side[:, 6], side[:, 7])[side[:, 8] > 0] for _, side, _ in one])
    hop, side, turn = (np.stack(tables) for tables in zip(*one, strict=True))
    course, finish = _pack_routes(maps)
    sides = {name: side[..., i] for i, name in enumerate(SIDE_COLUMNS)}
    arrays = jax.device_put({"hop": hop, "side": sides, "turn": turn, "course": course, "finish": finish})
    return Tables(**arrays, shortest_crossing=float(widths.min()))


def _pack_routes(maps: RoadMap) -> tuple[np.ndarray, np.ndarray]:
    """The tables ``course`` and ``finish``; beyond its last point a route stays there."""
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
    """Map ``i`` of stacked maps, as NumPy arrays by name."""
    return {name: np.asarray(value)[i] for name, value in vars(maps).items()}


def _pack_map(m: dict) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
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
    kerb = np.where(real, _kerb_distance(m, landing, other), 0)
    columns = (x, y, m["side_ux"], m["side_uy"], m["zone_near"], m["zone_far"], x[other] - x, y[other] - y, kerb,
               m["zone_near"][other], m["zone_far"][other], landing[other], outer[other])  # fmt: skip
    edge = np.hypot(m["node_x"][outer] - x, m["node_y"][outer] - y)
    distance = np.where(np.isfinite(m["distance"]), m["distance"], 0)  # infinite only where there is padding
    turn = (edge[:, None] + distance[outer] - distance[landing]) / 2
    return hop.astype(np.int32), np.stack(columns, 1).astype(np.float32), turn.astype(np.float32)


def _kerb_distance(m: dict, landing: np.ndarray, other: np.ndarray) -> np.ndarray:
    """From each landing straight to the roadway that its crosswalk crosses, the one half-way across [m]."""
    x, y = m["node_x"][landing][:, None], m["node_y"][landing][:, None]
    middle_x, middle_y = (x + x[other]) / 2, (y + y[other]) / 2
    x0, y0, x1, y1 = m["roads"].T
    crossed = (x0 < middle_x) & (middle_x < x1) & (y0 < middle_y) & (middle_y < y1)
    away = np.hypot(np.maximum(np.maximum(x0 - x, x - x1), 0), np.maximum(np.maximum(y0 - y, y - y1), 0))
    return np.where(crossed, away, np.inf).min(axis=1)
