"""The ground of an imported street as areas of a network."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.imported.crossing_places import Placed
from jaxwalk.maps.imported.kerb_ground import KerbGround, polygons, surface
from jaxwalk.maps.imported.source_map import SourceMap
from jaxwalk.maps.network import Area, AreaKind

GRID = 0.001
"""Corners lie on multiples of this [m]."""
SMALLEST = {"parking": 8.0, "building": 12.0}
"""Smaller parts are left out [m2]."""
FROM_CROSSWALKS = 5.0
"""Nobody parks this close to a crosswalk [m]."""
FROM_PAVEMENT = 0.05
"""Buildings keep this far from pavement [m]."""
NEAR = 30.0
"""Buildings farther from the pavement are left out: nobody can hide behind them [m]."""


def street_areas(
    source: SourceMap, box: BaseGeometry, ground: KerbGround, placed: Sequence[Placed]
) -> tuple[list[Area], list[tuple[int, ...]]]:
    """Return the areas of a street, and for each crossing the numbers of its crosswalks."""
    islands = shapely.union_all([island for crossing in placed for island in crossing.islands])
    aprons = shapely.union_all([apron for crossing in placed for apron in crossing.aprons])
    pavement = surface(ground.pavement.union(aprons.intersection(box)).difference(ground.roadway))
    areas = [*_areas("roadway", ground.roadway), *_areas("sidewalk", pavement)]
    areas += _areas("island", islands.difference(ground.roadway))
    crosswalks: list[tuple[int, ...]] = []
    for crossing in placed:
        own = [area for shape in crossing.areas for area in _areas("crosswalk", shape)]
        crosswalks.append(tuple(range(len(areas), len(areas) + len(own))))
        areas += own
    no_parking = shapely.union_all([x for crossing in placed for x in crossing.areas]).buffer(FROM_CROSSWALKS)
    strips = shapely.union_all([x for x in source.parking if x.intersects(box)])
    areas += _areas("parking", strips.intersection(ground.roadway).difference(no_parking))
    return [*areas, *_buildings(source, box, ground._replace(pavement=pavement))], crosswalks


def _buildings(source: SourceMap, box: BaseGeometry, ground: KerbGround) -> Iterator[Area]:
    """Yield the buildings near the pavement, off it and the roadway."""
    taken = shapely.union_all([ground.roadway, ground.pavement, ground.medians]).buffer(FROM_PAVEMENT, quad_segs=2)
    near = ground.filled.buffer(NEAR, quad_segs=2)
    shapely.prepare([box, near, taken])
    for building in source.buildings:
        if near.intersects(building) and box.intersects(building):
            shape = building.intersection(box)
            yield from _areas("building", shape.difference(taken) if taken.intersects(shape) else shape)


def _areas(kind: AreaKind, shape: BaseGeometry) -> Iterator[Area]:
    """Yield the polygons of a shape as areas."""
    for part in polygons(shapely.set_precision(shape, GRID), SMALLEST.get(kind, 0.1)):
        rings = [shapely.get_coordinates(ring)[:-1] for ring in (part.exterior, *part.interiors)]
        yield Area(kind, rings[0], tuple(rings[1:]))
