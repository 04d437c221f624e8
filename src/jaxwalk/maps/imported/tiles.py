"""A source map as streets: one, or tiles that overlap, so that every crossing lies well inside some tile."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

import numpy as np

from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.source_map import SourceMap
from jaxwalk.maps.imported.street_maker import Box, ImportedStreet, StreetMaker

SIZES = (150.0, 300.0)
"""Smallest and largest side of a tile [m]."""
OVERLAP = 50.0
"""Neighbouring tiles overlap by this [m]."""
LARGEST_STREET = 400.0
"""Longest side of a single street [m]."""
AROUND = 10.0
"""What is imported reaches this far beyond the roads' lines [m]."""
FROM_EDGE = 30.0
"""A crossing this close to the edge of all its tiles gets a tile of its own, about it [m]."""


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
    missed: set[str] = set()
    placed: set[str] = set()
    for number, box in enumerate(boxes):
        told(number, len(boxes))
        street = maker.make(f"{name}-{number + 1:03d}", box)
        placed |= {x.name for x in street.report.crossings if x.placed and street.report.usable}
        missed |= {x.name for x in street.report.crossings if not x.placed and x.at_edge}
        yield street
    number = len(boxes)
    for crossing in source.crossings:
        if crossing.name in missed - placed:
            x, y = crossing.point.tolist()
            own = maker.make(f"{name}-{number + 1:03d}", (x - size / 2, y - size / 2, x + size / 2, y + size / 2))
            number += 1
            placed |= {found.name for found in own.report.crossings if found.placed and own.report.usable}
            missed.discard(crossing.name)
            yield own


def _boxes(source: SourceMap, size: float) -> Iterator[Box]:
    """Yield boxes that cover the source map, each overlapping its neighbours."""
    west, south, east, north = source.extent
    columns, rows = (_begins(low, high, size) for low, high in ((west, east), (south, north)))
    yield from ((x, y, x + size, y + size) for y, x in product(rows, columns))


def _begins(low: float, high: float, size: float) -> list[float]:
    """Return where boxes of a size begin that cover a stretch."""
    if high - low <= size:
        return [(low + high - size) / 2]
    count = int(np.ceil((high - low - size) / (size - OVERLAP))) + 1
    return np.linspace(low, high - size, count).tolist()


def _crossings_in(source: SourceMap, box: Box) -> int:
    """Return the number of mapped crossings in a box."""
    west, south, east, north = box
    return sum(west < x.point[0] < east and south < x.point[1] < north for x in source.crossings)
