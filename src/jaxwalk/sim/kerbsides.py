"""What a car may know of the street beside its route: where people could step out, and where the next crosswalk is."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from jaxwalk.maps import RoadMap
from jaxwalk.maps.road_field import BEYOND, CELL, UNIT
from jaxwalk.maps.routes import ROUTE_SPACING

COLUMNS = ("right_x", "right_y", "left_x", "left_y", "to_crosswalk")
"""At each point of a route: the places just beyond the right and the left kerb [m], and the metres to a crosswalk."""
REACH = 15.0
"""A kerb farther from the route than this counts as this far away [m]."""
STEP = 0.5
"""Distance between the places that are tried on the way to a kerb [m]."""
ASIDE = 0.5
"""People who are about to step out stand this far behind the kerb [m]."""
FARTHEST = 40.0
"""A crosswalk farther ahead than this counts as this far away [m]."""


def pack_kerbsides(maps: RoadMap) -> Float[np.ndarray, "map route point 5"]:
    """Return the columns `COLUMNS` for stacked maps."""
    names = ("route_x", "route_y", "route_cos", "route_sin", "field")
    packed = []
    for number in range(len(maps.width)):
        x, y, cos, sin, field = (np.asarray(getattr(maps, name))[number] for name in names)
        sides = []
        for out_x, out_y in ((sin, -cos), (-sin, cos)):
            away = _to_kerb(field, (x, y), (out_x, out_y)) + ASIDE
            sides += [x + away * out_x, y + away * out_y]
        packed.append(np.stack([*sides, _to_crosswalk(maps, number, x, y)], axis=-1))
    return np.stack(packed).astype(np.float32)


def _to_kerb(
    field: np.ndarray, at: tuple[np.ndarray, np.ndarray], out: tuple[np.ndarray, np.ndarray]
) -> Float[np.ndarray, "route point"]:
    """Return how far each point of the routes is from the kerb in the direction ``out``, a unit vector [m]."""
    away = np.arange(0, REACH + STEP, STEP)
    inside = _inside(field, *(one[..., None] + away * to[..., None] for one, to in zip(at, out, strict=True)))
    off = inside <= 0
    first = np.where(off.any(axis=-1), off.argmax(axis=-1), len(away) - 1)[..., None]
    before = np.maximum(first - 1, 0)
    one, other = (np.take_along_axis(inside, index, axis=-1)[..., 0] for index in (before, first))
    share = np.clip(one / np.maximum(one - other, 1e-6), 0, 1)
    return np.minimum(away[before[..., 0]] + share * STEP, REACH)


def _inside(field: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the distance to the roadway's edge [m], negative off the roadway, between the corners of the field."""
    corners = field.astype("<i4").view(np.int8).reshape(*field.shape, 4)[..., 0] * UNIT
    east, north = (
        np.clip((place + BEYOND) / CELL, 0, count - 1.01) for place, count in ((x, field.shape[1]), (y, field.shape[0]))
    )
    column, row = east.astype(int), north.astype(int)
    u, v = east - column, north - row
    south = (1 - u) * corners[row, column] + u * corners[row, column + 1]
    north_side = (1 - u) * corners[row + 1, column] + u * corners[row + 1, column + 1]
    return (1 - v) * south + v * north_side


def _to_crosswalk(maps: RoadMap, number: int, x: np.ndarray, y: np.ndarray) -> Float[np.ndarray, "route point"]:
    """Return how far along its route each point is from the next crosswalk's middle line [m]."""
    landing = np.asarray(maps.side_landing)[number].reshape(-1, 2)
    landing = landing[(landing >= 0).all(axis=1)]
    node = np.stack([np.asarray(maps.node_x)[number], np.asarray(maps.node_y)[number]], axis=-1)
    one, other = node[landing[:, 0]], node[landing[:, 1]]
    route = np.stack([x, y], axis=-1)[..., None, :]
    begin, end = route[:, :-1], route[:, 1:]
    passes = (_turn(one, other, begin) != _turn(one, other, end)) & (_turn(begin, end, one) != _turn(begin, end, other))
    met = np.pad(passes.any(axis=-1), ((0, 0), (0, 1)))
    at = np.where(met, np.arange(met.shape[1]), np.inf)[:, ::-1]
    following = np.minimum.accumulate(at, axis=1)[:, ::-1] - np.arange(met.shape[1])
    return np.minimum(following * ROUTE_SPACING, FARTHEST)


def _turn(begin: np.ndarray, end: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return whether a point lies to the left of the line from ``begin`` to ``end``."""
    along, to = end - begin, point - begin
    return along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0] > 0
