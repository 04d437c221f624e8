"""The crossings that OpenStreetMap has: nodes on roads, and footways that lead over roads."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely

from jaxwalk.maps.imported.osm_reading import OsmData, OsmWay
from jaxwalk.maps.imported.osm_tags import WALKS, Tags, crossing_kind, is_road, metres
from jaxwalk.maps.imported.road_chains import RoadChain
from jaxwalk.maps.imported.source_map import SourceCrossing

SAME = 6.0
"""A footway that crosses a road this close to a crossing's node is the way of that crossing [m]."""
WIDTHS = (2.0, 8.0)
"""Narrowest and widest crossing [m]."""
USUAL_WIDTH = 4.0


class _Footway(NamedTuple):
    """The piece of a footway that crosses a road."""

    way: OsmWay
    point: np.ndarray
    """Where it meets the road (2,) [m]."""
    along: np.ndarray
    """Unit vector of it there."""


def is_crossing(tags: Tags) -> bool:
    """Return whether a node is one where people cross."""
    return tags.get("highway") == "crossing" or ("crossing" in tags and tags.get("highway") != "give_way"
                                                 and "railway" not in tags)  # fmt: skip


def mapped_crossings(data: OsmData, chains: Sequence[RoadChain]) -> Iterator[SourceCrossing]:
    """Yield the crossings of imported roads, nodes first."""
    footways = _footways(data, chains)
    nodes: dict[int, np.ndarray] = {}
    for chain in chains:
        nodes |= {
            node: chain.curve.beside(at)
            for node, at in chain.nodes.items()
            if is_crossing(data.node_tags.get(node, {}))
        }
    taken: set[int] = set()
    for node, place in nodes.items():
        near = [n for n, x in enumerate(footways) if n not in taken and np.hypot(*(x.point - place)) < SAME]
        nearest = min(near, key=lambda n: float(np.hypot(*(footways[n].point - place))), default=None)
        taken |= set() if nearest is None else {nearest}
        footway = None if nearest is None else footways[nearest]
        found = _crossing(f"node {node}", place, data.node_tags[node], footway)
        if found is not None:
            yield found
    left = [x for n, x in enumerate(footways) if n not in taken and x.way.tags.get("footway") == "crossing"]
    seen: Counter[int] = Counter()
    for footway in left:
        seen[footway.way.id] += 1
        name = f"way {footway.way.id}" + (f" ({seen[footway.way.id]})" if seen[footway.way.id] > 1 else "")
        found = _crossing(name, footway.point, {}, footway)
        if found is not None:
            yield found


def _crossing(name: str, place: np.ndarray, tags: Tags, footway: _Footway | None) -> SourceCrossing | None:
    way_tags = footway.way.tags if footway is not None else {}
    kind = crossing_kind(tags, way_tags)
    if kind is None:
        return None
    width = metres(way_tags.get("width")) or USUAL_WIDTH
    island = "yes" in (tags.get("crossing:island"), way_tags.get("crossing:island"))
    across = footway.along if footway is not None else None
    low, high = WIDTHS
    return SourceCrossing(name, kind[0], place, across, kind[1], min(max(width, low), high), island)


def _footways(data: OsmData, chains: Sequence[RoadChain]) -> list[_Footway]:
    """Return where footways cross roads: pieces between two nodes that meet a road's line."""
    lines = [shapely.LineString(chain.curve.points) for chain in chains]
    tree = shapely.STRtree(lines)
    found: list[_Footway] = []
    for way in data.ways:
        crosses = way.tags.get("highway") in (*WALKS, "cycleway") and way.tags.get("footway") not in (
            "sidewalk",
            "link",
        )
        if crosses and way.tags.get("highway") != "steps":
            found += _meetings(data, way, lines, tree)
    return found


def _meetings(
    data: OsmData, way: OsmWay, lines: Sequence[shapely.LineString], tree: shapely.STRtree
) -> Iterator[_Footway]:
    """Yield where a footway meets roads, away from its ends or at a node on it."""
    points = np.array([data.places[node] for node in way.nodes])
    whole = shapely.LineString(points)
    met: list[np.ndarray] = []
    meetings = [shapely.get_coordinates(whole.intersection(lines[n])) for n in tree.query(whole).tolist()]
    for point in (point for found in meetings for point in found):
        if not any(np.hypot(*(point - other)) < 1.0 for other in met):
            met.append(point)
    for point in met:
        at = whole.project(shapely.Point(point))
        before, after = (np.array(whole.interpolate(min(max(at + d, 0), whole.length)).coords[0]) for d in (-4, 4))
        length = float(np.hypot(*(after - before)))
        if 2 < at < whole.length - 2 and length > 3:  # it leads over the road, and doesn't only reach it
            yield _Footway(way, point, (after - before) / length)


def crossings_elsewhere(data: OsmData) -> dict[str, int]:
    """Return the number of crossings that lie on ways which aren't imported, by what they cross."""
    ways_at: dict[int, list[Tags]] = defaultdict(list)
    for way in data.ways:
        for node in way.nodes:
            ways_at[node].append(way.tags)
    found: Counter[str] = Counter()
    for node, tags in data.node_tags.items():
        own = ways_at.get(node, [])
        if own and is_crossing(tags) and not any(is_road(x) for x in own):
            found[_what(own)] += 1
    return dict(sorted(found.items()))


def _what(ways: Sequence[Tags]) -> str:
    """Return what a crossing crosses, by the tags of the ways at its node."""
    if any(tags.get("railway") in ("tram", "light_rail", "rail", "subway") for tags in ways):
        return "tracks"
    kinds = [tags.get("highway") for tags in ways]
    if "cycleway" in kinds:
        return "cycleways"
    if "service" in kinds:
        return "service roads"
    return "paths" if any(kind in WALKS for kind in kinds) else "other ways"
