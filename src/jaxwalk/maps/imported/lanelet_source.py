"""Lanelet2 maps (.osm) as source maps: lanelets for cars, crosswalks and walkways as they are mapped."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely

from jaxwalk.maps.imported.kerb_ground import polygons
from jaxwalk.maps.imported.lane_net import no_room
from jaxwalk.maps.imported.lanelet_ground import LaneletGround, lanelet_ground, open_ends_of
from jaxwalk.maps.imported.lanelet_lanes import lanelet_graph
from jaxwalk.maps.imported.lanelet_reading import LaneletFile, LaneletLine, read_lanelets
from jaxwalk.maps.imported.lanelet_rules import crossing_of, crosswalk_rules, limit_of
from jaxwalk.maps.imported.lanelet_shapes import (
    PARTICIPANT,
    USES,
    AreaShape,
    LaneletShape,
    area_shapes,
    is_two_way,
    keeps_left,
    lanelet_shapes,
)
from jaxwalk.maps.imported.mapped_lanes import mapped_lane_net
from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.region import AROUND, Region, refuse_large
from jaxwalk.maps.imported.source_map import Box, SourceMap, WalkEvidence
from jaxwalk.wording import counted

AT_KERB, BEHIND_CURB = 4.0, 3.0
"""A walkway, and a curbstone, speaks of kerbs whose line of people is nearer than this [m]."""


class LaneletParts(NamedTuple):
    """The parts of a map; ``x`` counts to the west if traffic keeps left."""

    file: LaneletFile
    driven: list[LaneletShape]
    others: list[LaneletShape]
    areas: list[AreaShape]
    without_bounds: int
    without_outline: int
    """Number of areas whose outline isn't whole."""
    left: bool


def lanelet_map(path: Path, region: Region | None, *, left: bool = False) -> SourceMap:
    """Return what a Lanelet2 map has; ``left``: traffic keeps left. Raise ImportRefusal if it can't be used."""
    parts = _parts(path, read_lanelets(path, region), left=left)
    driven = parts.driven
    extent = parts.file.region or _extent(driven)
    refuse_large(path, extent)
    ground = lanelet_ground(parts.file, driven, parts.others, parts.areas)
    limits = [limit_of(parts.file, x) for x in driven]
    graph = lanelet_graph(driven, [limit / 3.6 for limit, _ in limits], ground)
    net = mapped_lane_net(graph.lanes, graph.turns, ground.roadway, [*ground.junctions, *graph.joints])
    rules = crosswalk_rules(parts.file, driven, -1.0 if parts.left else 1.0)
    placed = [(x, crossing_of(rules, x, net.roadway)) for x in parts.others if x.use == "crosswalk"]
    return SourceMap(
        format="Lanelet2 map",
        attribution=f"Lanelet2 map {path.name}, which names no author",
        extent=extent,
        lanes=net.lanes,
        in_junction=net.in_junction,
        roadway=net.roadway,
        junctions=net.junctions,
        open_ends=tuple(open_ends_of(driven, ground)),
        crossings=tuple(found for _, found in placed if found is not None),
        evidence=tuple(_evidence(parts, {x.number for x, found in placed if found is not None})),
        parking=tuple(y for x in parts.areas if x.subtype == "parking" and x.number in ground.parts
                      for y in polygons(x.shape)),
        buildings=tuple(y for x in parts.areas if x.subtype == "building" for y in polygons(x.shape)),
        elements=tuple(_elements(parts)),
        left_out=tuple(_left_out(parts, ground, net.no_turns)),
        elsewhere=_elsewhere(parts, [x for x, found in placed if found is None]),
        mirrored=parts.left,
    )  # fmt: skip


def _parts(path: Path, file: LaneletFile, *, left: bool) -> LaneletParts:
    """Return the parts of a map, on the side on which traffic keeps right. Raise ImportRefusal if it has no roads."""
    shapes, without = lanelet_shapes(file)
    said = keeps_left([x for x in shapes if x.use == "driven" and not is_two_way(x.tags)])
    if left and said is False:
        raise ImportRefusal(f"{path}: its lanes keep right; leave --traffic left out")
    left = left if said is None else said
    areas, broken = area_shapes(file)
    if left:
        flip = np.array([-1.0, 1.0])
        shapes = [x.mirrored() for x in shapes]
        areas = [x._replace(shape=shapely.transform(x.shape, lambda points: points * flip)) for x in areas]
        lines = {n: LaneletLine(x.points * flip, x.tags) for n, x in file.lines.items()}
        west, south, east, north = file.region or (0.0, 0.0, 0.0, 0.0)
        file = file._replace(lines=lines, region=file.region and (-east, south, -west, north))
    if file.region is not None:
        west, south, east, north = file.region
        box = shapely.box(west - AROUND, south - AROUND, east + AROUND, north + AROUND)
        shapes = [x for x in shapes if x.shape.intersects(box)]
    driven = [x for x in shapes if x.use == "driven"]
    if not driven:
        where = "" if file.region is None else " in this region"
        raise ImportRefusal(f"{path}: has no roads{where} (lanelets for vehicles); name another file or part")
    both = [x.turned() for x in driven if is_two_way(x.tags)]
    others = [x for x in shapes if x.use != "driven"]
    return LaneletParts(file, driven + both, others, areas, without, broken, left)


def _extent(driven: Sequence[LaneletShape]) -> Box:
    west, south, east, north = shapely.total_bounds([x.shape for x in driven]).tolist()
    return west, south, east, north


def _evidence(parts: LaneletParts, crossed: set[int]) -> Iterator[WalkEvidence]:
    """Yield the outlines of walkways, and of crosswalks but those that lead over a roadway, ``crossed``.

    And curbstones: behind them, the format has ground on which people can walk.
    """
    shapes = [x.shape for x in parts.others if x.use == "walk" or (x.use == "crosswalk" and x.number not in crossed)]
    shapes += [x.shape for x in parts.areas if USES.get(x.subtype) == "walk"]
    for outline in (part.exterior for shape in shapes for part in polygons(shape)):
        yield WalkEvidence(shapely.get_coordinates(outline), "mapped", AT_KERB)
    for line in parts.file.lines.values():
        if line.tags.get("type") == "curbstone":
            yield WalkEvidence(line.points, "inferred", BEHIND_CURB)


def _elements(parts: LaneletParts) -> Iterator[dict[str, Any]]:
    """Yield the facts of each lanelet for cars."""
    seen: set[int] = set()
    for lanelet in (x for x in parts.driven if x.number not in seen):
        seen.add(lanelet.number)
        limit, origin = limit_of(parts.file, lanelet)
        both = int(is_two_way(lanelet.tags))
        yield {
            "element": lanelet.name, "name": lanelet.tags.get("road_name", ""),
            "class": lanelet.tags.get("subtype", "road"), "lanes": [1, both], "lanes_from": "mapped",
            "lane_width": round(lanelet.width, 2), "width_from": "mapped",
            "limit_km_h": round(limit, 1), "limit_from": origin,
            "metres": round(shapely.LineString(lanelet.middle).length, 1),
        }  # fmt: skip


def _left_out(parts: LaneletParts, ground: LaneletGround, no_turns: int) -> Iterator[str]:
    """Yield what isn't imported, and why."""
    others = Counter(
        (x.tags.get("subtype", ""), any(key.startswith(PARTICIPANT) for key in x.tags)) for x in parts.others
        if x.use == "other" or (x.use == "beside" and x.number not in ground.parts)
    )  # fmt: skip
    for (kind, participants), count in sorted(others.items()):
        told = f"subtype={kind}" + (f" and tags {PARTICIPANT}..." if participants else "")
        yield f"{counted(count, 'lanelet')} with {told}: not along a road, or not among what is imported"
    if parts.without_bounds:
        yield f"{counted(parts.without_bounds, 'lanelet')} without a left or right bound in the file"
    if parts.without_outline:
        yield f"{counted(parts.without_outline, 'area')} without a whole outline in the file"
    if no_turns:
        yield no_room(no_turns)
    if parts.file.missing:
        yield f"{counted(parts.file.missing, 'node')} that ways name and the file doesn't have; these ways aren't read"


def _elsewhere(parts: LaneletParts, crosswalks: Sequence[LaneletShape]) -> dict[str, int]:
    """Return the number of crosswalks that lead over no roadway, by what they cross."""
    kinds = {"rail": "tracks", "bicycle_lane": "cycleways"}
    ways = [(kinds[kind], x.shape) for x in parts.others if (kind := x.tags.get("subtype", "")) in kinds]
    found = Counter(
        next((what for what, shape in ways if shape.intersects(x.shape)), "pavement or islands") for x in crosswalks
    )
    return dict(sorted(found.items()))
