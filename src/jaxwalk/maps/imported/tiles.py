"""A source map as streets: one, or tiles that overlap, so that every crossing lies well inside some tile."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

import numpy as np

from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.source_map import Box, SourceMap
from jaxwalk.maps.imported.street_maker import ImportedStreet, StreetMaker

SIZES = (150.0, 300.0)
"""Smallest and largest side of a tile [m]."""
OVERLAP = 50.0
"""Neighbouring tiles overlap by this [m]."""
LARGEST_STREET = 400.0
"""Longest side of a single street [m]."""
AROUND = 10.0
"""What is imported reaches this far beyond the roads' lines [m]."""
BEYOND = 20.0
"""The outermost metres of a map need no tile of their own [m]."""


def single_street(source: SourceMap, name: str, *, strict: bool) -> ImportedStreet:
    """Return all of a source map as one street. Raise ImportRefusal if it is too large for that."""
    west, south, east, north = source.extent
    if max(east - west, north - south) > LARGEST_STREET:
        raise ImportRefusal(
            f"{name}: {east - west:.0f} x {north - south:.0f} m are too large for one street of at most "
            f"{LARGEST_STREET:g} m; name a part with --centre and --radius, or a folder (--out FOLDER) for tiles"
        )
    box = (west - AROUND, south - AROUND, east + AROUND, north + AROUND)
    return StreetMaker(source, strict=strict).make(name, box)


def tiles(
    source: SourceMap, name: str, size: float, *, strict: bool, told: Callable[[int, int], None] = lambda *_: None
) -> Iterator[ImportedStreet]:
    """Yield the streets of all tiles that have a mapped crossing.

    Args:
        source: the map.
        name: how the streets' names begin.
        size: side of a tile [m].
        strict: whether nothing may be invented.
        told: is called with the number of tiles made so far, and of all.
    """
    maker = StreetMaker(source, strict=strict)
    boxes = [box for box in _boxes(source, size) if _crossings_in(source, box)]
    settled: set[str] = set()
    for number, box in enumerate(boxes):
        told(number, len(boxes))
        street = maker.make(f"{name}-{number + 1:03d}", box)
        settled |= _settled(street)
        if street.report.crossings:
            yield street
    number = len(boxes)
    for crossing in source.crossings:
        if crossing.name not in settled and inside(crossing.point, source.extent):
            x, y = crossing.point.tolist()
            box = (x - size / 2, y - size / 2, x + size / 2, y + size / 2)
            number += 1
            street = maker.make(f"{name}-{number:03d}", box, crossing.point)
            settled |= _settled(street) | {crossing.name}
            yield street


def _settled(street: ImportedStreet) -> set[str]:
    """Return the crossings that no other street needs to have: placed ones, and those that can't be anywhere."""
    report = street.report
    return {x.name for x in report.crossings if not x.at_edge and (report.usable or not x.placed)}


def inside(point: np.ndarray, extent: Box) -> bool:
    """Return whether a point (2,) lies in a box."""
    west, south, east, north = extent
    return bool(west <= point[0] <= east and south <= point[1] <= north)


def _boxes(source: SourceMap, size: float) -> Iterator[Box]:
    """Yield boxes that cover the source map, each overlapping its neighbours."""
    west, south, east, north = source.extent
    columns, rows = (_begins(low, high, size) for low, high in ((west, east), (south, north)))
    yield from ((x, y, x + size, y + size) for y, x in product(rows, columns))


def _begins(low: float, high: float, size: float) -> list[float]:
    """Return where boxes of a size begin that cover a stretch."""
    over = high - low - size
    if over <= BEYOND:
        return [(low + high - size) / 2]
    return np.linspace(low, high - size, int(np.ceil(over / (size - OVERLAP))) + 1).tolist()


def _crossings_in(source: SourceMap, box: Box) -> int:
    """Return the number of mapped crossings in a box."""
    west, south, east, north = box
    return sum(bool(west < x.point[0] < east and south < x.point[1] < north) for x in source.crossings)
