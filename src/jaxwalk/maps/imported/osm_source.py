"""OpenStreetMap data as a source map: roads, crossings, sidewalks, parking strips and buildings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.imported.lane_net import no_room
from jaxwalk.maps.imported.osm_crossings import crossings_elsewhere, mapped_crossings
from jaxwalk.maps.imported.osm_ground import band, mouths, raw_roadway, sides, strip_width, way_side
from jaxwalk.maps.imported.osm_lanes import lane_net
from jaxwalk.maps.imported.osm_mirror import mirrored, refuse_other_side
from jaxwalk.maps.imported.osm_reading import ATTRIBUTION, OsmData, line_of, lines_of, read_osm
from jaxwalk.maps.imported.osm_tags import CLASSES, SIDES, WALKS, is_road, road_facts, sidewalk
from jaxwalk.maps.imported.region import Region
from jaxwalk.maps.imported.road_chains import RoadChain, road_chains
from jaxwalk.maps.imported.source_map import SourceMap, WalkEvidence
from jaxwalk.wording import counted

NEAR_KERB = 8.0
"""A mapped sidewalk may lie this far from the line of people at the kerb [m]."""
AT_KERB = 3.0
"""What a road's tags say of its sidewalk counts so far from its kerb [m]."""
FROM_MOUTH, SHORTEST_STRIP = 8.0, 6.0
"""Nobody parks this close to a junction's mouth; a shorter parking strip is left out [m]."""
AT_EDGE = 30.0
"""A road that ends this close to the map's edge goes on beyond it [m]."""
GO_ON = ("service", "track", "unclassified", "motorway_link", "motorway", "construction", "busway")
"""Values of ``highway`` with which a road goes on where it ends."""
BEYOND_END, BESIDE_END = 10.0, 4.0
"""How far the region at such an end reaches beyond it, and beyond the kerbs [m]."""
SMALLEST_BUILDING = 12.0
"""A smaller building is left out [m2]."""


def osm_map(path: Path, region: Region | None, *, left: bool = False) -> SourceMap:
    """Return what an OpenStreetMap file has; ``left``: traffic keeps left. Raise ImportRefusal if it can't be used."""
    data = read_osm(path, region)
    refuse_other_side(path, data, left=left)
    data = mirrored(data) if left else data
    chains = road_chains(data)
    roadway = raw_roadway(chains)
    ends = mouths(chains, roadway)
    net = lane_net(chains, roadway, ends)
    crossings = mapped_crossings(data, chains)
    return SourceMap(
        format="OpenStreetMap",
        attribution=ATTRIBUTION,
        extent=data.extent,
        lanes=net.lanes,
        in_junction=net.in_junction,
        roadway=net.roadway,
        junctions=net.junctions,
        open_ends=tuple(_open_ends(data, chains)),
        crossings=tuple(crossings),
        evidence=tuple(_evidence(data, chains)),
        parking=tuple(_parking(chains, ends)),
        buildings=tuple(_buildings(data)),
        elements=tuple(_elements(data)),
        left_out=tuple(_left_out(data, net.no_turns)),
        elsewhere=crossings_elsewhere(data),
        mirrored=left,
    )


def _open_ends(data: OsmData, chains: Sequence[RoadChain]) -> Iterator[BaseGeometry]:
    """Yield a region across each road that ends at the map's edge, or where a road begins that isn't imported."""
    ends = Counter(node for chain in chains for node in chain.ends)
    beyond = [way for way in data.ways if way.tags.get("highway") in GO_ON and not is_road(way.tags)]
    others = {node for way in beyond for node in way.nodes}
    west, south, east, north = data.extent
    dead = [(chain, end, node) for chain in chains for end, node in enumerate(chain.ends) if ends[node] == 1]
    for chain, end, node in dead:
        x, y = chain.curve.points[-end]
        at_edge = min(x - west, east - x, y - south, north - y) < AT_EDGE
        if at_edge or node in others:
            yield _across_end(chain, end)


def _across_end(chain: RoadChain, end: int) -> BaseGeometry:
    """Return the region from half a metre before one end of a chain on."""
    heading = float(chain.curve.headings[-end]) + (0.0 if end else np.pi)
    ahead = np.array([np.cos(heading), np.sin(heading)])
    place = chain.curve.points[-end]
    line = shapely.LineString([place - 0.5 * ahead, place + BEYOND_END * ahead])
    half = max(max(sides(chain, piece)) for piece in chain.pieces) + BESIDE_END
    return line.buffer(half, cap_style="flat")


def _evidence(data: OsmData, chains: Sequence[RoadChain]) -> Iterator[WalkEvidence]:
    """Yield what the map says of sidewalks: mapped ones, and tags of roads."""
    for way, line in lines_of(data, kinds=WALKS):
        if way.tags.get("footway") != "crossing" and way.tags.get("highway") != "steps":
            yield WalkEvidence(line, "mapped", NEAR_KERB)
    for chain, piece in ((x, piece) for x in chains for piece in x.pieces if piece.end > piece.begin):
        right, left = sides(chain, piece)
        said = [sidewalk(piece.way.tags, way_side(piece, side)) for side in SIDES]
        for offset in (x for x, answer in zip((left, -right), said, strict=True) if answer == "yes"):
            yield WalkEvidence(chain.curve.parallel(offset, piece.begin, piece.end), "inferred", AT_KERB)


def _parking(chains: Sequence[RoadChain], ends: Sequence[tuple[float, float]]) -> Iterator[shapely.Polygon]:
    """Yield parking strips, clear of junctions."""
    placed = ((chain, piece, own) for chain, own in zip(chains, ends, strict=True) for piece in chain.pieces)
    for chain, piece, (low, high) in placed:
        begin, end = max(piece.begin, low + FROM_MOUTH), min(piece.end, high - FROM_MOUTH)
        if end - begin < SHORTEST_STRIP:
            continue
        half, right, left = chain.profile.width / 2, strip_width(piece, "right"), strip_width(piece, "left")
        for strip in [(-half - right, -half)] * (right > 0) + [(half, half + left)] * (left > 0):
            shape = band(chain, begin, end, *strip)
            yield from (part for part in shapely.get_parts(shape).tolist() if part.geom_type == "Polygon")


def _buildings(data: OsmData) -> Iterator[shapely.Polygon]:
    """Yield the outlines of buildings that are closed ways."""
    for way in data.ways:
        if "building" not in way.tags or way.tags["building"] == "no" or way.nodes[0] != way.nodes[-1]:
            continue
        shape = shapely.Polygon(line_of(data, way)) if len(way.nodes) > 3 else shapely.Polygon()
        if shape.is_valid and shape.area >= SMALLEST_BUILDING:
            yield shape


def _elements(data: OsmData) -> Iterator[dict[str, Any]]:
    """Yield the facts of each road, with where they are from."""
    for way in data.ways:
        if is_road(way.tags):
            facts = road_facts(way.tags)
            yield {
                "element": f"way {way.id}", "name": way.tags.get("name", ""), "class": way.tags["highway"],
                "lanes": [facts.profile.forward, facts.profile.backward], "lanes_from": facts.lanes_from,
                "lane_width": round(facts.profile.lane_width, 2), "width_from": facts.width_from,
                "limit_km_h": round(facts.profile.limit * 3.6, 1), "limit_from": facts.limit_from,
                "metres": round(float(np.hypot(*np.diff(line_of(data, way), axis=0).T).sum()), 1),
            }  # fmt: skip


def _left_out(data: OsmData, no_turns: int) -> Iterator[str]:
    """Yield what isn't imported, and why."""
    others = Counter(
        way.tags["highway"] for way in data.ways
        if "highway" in way.tags and way.tags["highway"] not in WALKS and not is_road(way.tags)
    )  # fmt: skip
    for kind, count in sorted(others.items()):
        why = "private, closed, or an area" if kind in CLASSES else "not among the roads that are imported"
        yield f"{counted(count, 'way')} with highway={kind}: {why}"
    if no_turns:
        yield no_room(no_turns)
    if data.missing:
        yield f"{counted(data.missing, 'reference')} to nodes that the file doesn't have: parts of ways are missing"
