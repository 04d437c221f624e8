"""Where parked vehicles stand in the way of jaywalks: who would begin beside one begins in the nearest gap instead.

A jaywalk that begins at a side with parked vehicles leads straight across, so which slots are in its way depends on
where it begins alone, and is a table. Only vehicles on the side where it begins count: nobody steps out through one,
but whoever arrives at the other kerb squeezes through between bumpers.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from jaxtyping import Float

from jaxwalk.maps import RoadMap
from jaxwalk.maps.parking_slots import BOX, SLOT
from jaxwalk.maps.tables import rounded_up
from jaxwalk.sim.occluders import blocked

COLUMNS = 5
"""The columns of an entry: a parking slot, `NO_SLOT` for padding; from which place of the zone's line to which one a
vehicle in it is in the way; and the places before and behind it where a jaywalk begins instead."""
NO_SLOT = -1.0
APART = 0.05
"""Distance between the places that are tried [m]."""


def pack_parked_gaps(maps: RoadMap, tables: dict[str, Any], body: float) -> Float[np.ndarray, "map side vehicle 5"]:
    """Return the slots in the way of jaywalks from each side, with the columns `COLUMNS`, for stacked NumPy arrays.

    Args:
        maps: the maps.
        tables: the same, packed (`jaxwalk.sim.map_tables.pack_tables`).
        body: radius of a pedestrian's body [m].
    """
    number, sides = tables["side"]["near"].shape
    found = {
        (m, side): list(_in_the_way(maps, tables, (m, side), body)) for m in range(number) for side in range(sides)
    }
    most = rounded_up(max(1, *map(len, found.values())))
    packed = np.full((number, sides, most, COLUMNS), NO_SLOT, np.float32)
    for at, entries in found.items():
        packed[at][: len(entries)] = np.reshape(entries, (-1, COLUMNS))
    return packed


def _in_the_way(maps: RoadMap, tables: dict[str, Any], at: tuple[int, int], body: float) -> Iterator[list[float]]:
    """Yield the entries of a side, ``at`` = (map, side).

    A slot is left out if it fills the zone, so that there is no gap.
    """
    number = at[0]
    near, far, piece = (float(tables["side"][name][at]) for name in ("near", "far", "piece"))
    slots = np.asarray(maps.slots[number])[: int(maps.slot_count[number])]
    if far <= near or not len(slots):
        return
    places = np.linspace(near, far, 2 + int((far - near) * piece / APART))
    begin, end = _straight_across(tables, at, places)
    wide = slots + np.array([0, 0, 0, 0, body, body])
    beside = np.linalg.norm(slots[:, :2] - begin.mean(axis=0), axis=1) < np.ptp(begin, axis=0).sum() + SLOT
    for slot in np.flatnonzero(beside):
        met = np.flatnonzero(blocked(wide[slot], begin, (begin + end) / 2))
        if not len(met):
            continue
        low, high = float(places[met[0]]), float(places[met[-1]])
        aside = ((SLOT - BOX[0]) / 2 - body) / piece
        before, behind = low - aside, high + aside
        if before < near and behind > far:
            continue
        before, behind = (behind if before < near else before), (before if behind > far else behind)
        step = float(places[1] - places[0])
        yield [float(slot), low - step, high + step, before, behind]


def _straight_across(
    tables: dict[str, Any], at: tuple[int, int], places: Float[np.ndarray, " place"]
) -> tuple[Float[np.ndarray, "place 2"], Float[np.ndarray, "place 2"]]:
    """Return where jaywalks that aren't slanted begin and end [m] (`jaxwalk.sim.jaywalk.jaywalk_from`)."""
    number, side = at
    other = (number, side ^ 1)
    near, far = (float(tables["side"][name][other]) for name in ("near", "far"))
    there = np.clip(places * float(tables["side"]["piece"][at] / tables["side"]["piece"][other]), near, far)
    return _points(tables, at, places), _points(tables, other, there)


def _points(
    tables: dict[str, Any], at: tuple[int, int], places: Float[np.ndarray, " place"]
) -> Float[np.ndarray, "place 2"]:
    """Return the points at places of a side's line [m]."""
    x, y, dx, dy = (np.asarray(tables["zone"][name][at]) for name in ("x", "y", "dx", "dy"))
    piece = np.clip(np.floor(places).astype(int), 0, len(x) - 1)
    share = places - piece
    return np.stack([x[piece] + share * dx[piece], y[piece] + share * dy[piece]], axis=-1)
