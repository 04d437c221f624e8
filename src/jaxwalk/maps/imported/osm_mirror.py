"""Left-hand traffic: the map is mirrored, so that traffic keeps right, and streets are turned back at the end."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from jaxwalk.maps.imported.osm_reading import OsmData, line_of
from jaxwalk.maps.imported.osm_tags import Tags, is_road, one_way
from jaxwalk.maps.imported.refusals import ImportRefusal

TWINS = (4.0, 40.0)
"""Two one-way roads of one name in opposite directions are a road's two sides if so far apart [m]."""
OPPOSITE = -0.94
"""Cosine of the smallest angle between the directions of such roads."""
MOST_PIECES = 2000
"""A road of more pieces is not asked."""
CLEAR = 0.8
"""To refuse, the votes for the other side, less those against it, must be at least this share of all."""


def mirrored(data: OsmData) -> OsmData:
    """Return the data with x to the west, and what tags say of left and right exchanged."""
    places = {node: (-x, y) for node, (x, y) in data.places.items()}
    ways = tuple(way._replace(tags=_exchanged(way.tags)) for way in data.ways)
    west, south, east, north = data.extent
    return data._replace(places=places, ways=ways, extent=(-east, south, -west, north))


def _exchanged(tags: Tags) -> Tags:
    swap = {"left": "right", "right": "left"}
    return {
        ":".join(swap.get(part, part) for part in key.split(":")): swap.get(value, value) for key, value in tags.items()
    }


def refuse_other_side(path: Path, data: OsmData, *, left: bool) -> None:
    """Raise ImportRefusal if the map says that traffic keeps to the other side than it was said to."""
    said = [way.tags["driving_side"] for way in data.ways if way.tags.get("driving_side") in ("left", "right")]
    votes = [1 if side == "left" else -1 for side in said] + list(_roundabouts(data)) + list(_twins(data))
    if len(votes) < 2 or abs(sum(votes)) < CLEAR * len(votes):
        return
    keeps_left = sum(votes) > 0
    if keeps_left != left:
        side, other = ("left", "right")[:: 1 if keeps_left else -1]
        why = "roundabouts, divided roads or driving_side tags"
        raise ImportRefusal(f"{path}: by its {why}, traffic keeps {side} there, not {other}; add --traffic {side}")


def _roundabouts(data: OsmData) -> Iterator[int]:
    """Yield for each roundabout 1 if traffic goes around clockwise, else -1."""
    for way in data.ways:
        if is_road(way.tags) and way.tags.get("junction") == "roundabout" and way.nodes[0] == way.nodes[-1]:
            x, y = line_of(data, way).T
            turning = float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum()) * one_way(way.tags)
            yield -1 if turning > 0 else 1


def _twins(data: OsmData) -> Iterator[int]:
    """Yield for pieces of divided roads 1 if the opposite direction lies to the right, else -1."""
    by_name: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for way in data.ways:
        if is_road(way.tags) and way.tags.get("name") and (direction := one_way(way.tags)):
            line = line_of(data, way)[::direction]
            steps = np.diff(line, axis=0)
            ahead = steps / np.maximum(np.hypot(*steps.T), 1e-9)[:, None]
            by_name.setdefault(way.tags["name"], []).append(((line[1:] + line[:-1]) / 2, ahead))
    for parts in by_name.values():
        middles, ahead = (np.concatenate(x) for x in zip(*parts, strict=True))
        if len(middles) > MOST_PIECES:
            continue
        offset = middles[None] - middles[:, None]
        aside = ahead[:, None, 0] * offset[..., 1] - ahead[:, None, 1] * offset[..., 0]
        along = np.abs((ahead[:, None] * offset).sum(axis=-1))
        twin = (ahead @ ahead.T < OPPOSITE) & (np.abs(aside) > TWINS[0]) & (np.abs(aside) < TWINS[1]) & (along < 15)
        yield from np.where(aside[twin] < 0, 1, -1).tolist()
