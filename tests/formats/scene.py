"""Hand-made foreign trajectories: road users who move straight, seen for a while."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxwalk.formats.tracks import CAR, PEDESTRIAN, Tracks


@dataclass(frozen=True)
class Seen:
    """Somebody at (x, y) at time ``begin``, who keeps a velocity until ``end``."""

    type: str
    begin: float
    end: float
    x: float
    y: float
    vx: float = 0.0
    vy: float = 0.0
    heading: float = 0.0


def car(begin: float, end: float, x: float, y: float, vx: float = 0.0, **more) -> Seen:
    return Seen(CAR, begin, end, x, y, vx, **more)


def person(begin: float, end: float, x: float, y: float, vx: float = 0.0, vy: float = 0.0) -> Seen:
    return Seen(PEDESTRIAN, begin, end, x, y, vx, vy)


def recording(*everybody: Seen, rate: float = 25.0, ids: tuple[int, ...] = ()) -> Tracks:
    """What a camera with ``rate`` frames a second sees of them; ids are 0, 1, ... unless told otherwise."""
    rows: dict[str, list] = {name: [] for name in ("t", "id", "type", "x", "y", "vx", "vy", "heading")}
    for id, one in zip(ids or range(len(everybody)), everybody, strict=True):
        t = np.arange(round(one.begin * rate), round(one.end * rate) + 1) / rate
        passed = t - one.begin
        places = one.x + passed * one.vx, one.y + passed * one.vy
        same = (np.full(len(t), value) for value in (one.vx, one.vy, one.heading))
        for name, values in zip(rows, (t, np.full(len(t), id), np.full(len(t), one.type), *places, *same), strict=True):
            rows[name].append(values)
    columns = {name: np.concatenate(parts) for name, parts in rows.items()}
    unknown = np.full(len(columns["t"]), np.nan)
    return Tracks(episode=0, length=unknown, width=unknown, known={}, **columns)


STREET = {
    "type": "FeatureCollection",
    "features": [
        {"type": "Feature", "properties": {"kind": kind}, "geometry": {"type": "Polygon", "coordinates": [corners]}}
        for kind, corners in (
            ("roadway", [[0, -4], [200, -4], [200, 4], [0, 4], [0, -4]]),
            ("crosswalk", [[98, -4], [102, -4], [102, 4], [98, 4], [98, -4]]),
        )
    ],
}
"""A road along y = 0, 8 m wide, with a crosswalk at x = 100."""
