"""SUMO networks as source maps: lanes, sidewalks, crossings and walking areas as they are mapped."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from jaxwalk.maps.imported.lane_net import no_room
from jaxwalk.maps.imported.mapped_lanes import MappedLane, MappedTurn, mapped_lane_net
from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.region import AROUND, Region, refuse_large
from jaxwalk.maps.imported.source_map import Box, Origin, SourceCrossing, SourceMap, WalkEvidence
from jaxwalk.maps.imported.sumo_ground import (
    BACK,
    TRACKS,
    ending_at_junctions,
    is_for,
    is_road,
    is_walk,
    junction_regions,
    leads_on,
    open_ends,
    roadway,
)
from jaxwalk.maps.imported.sumo_reading import CARS, PEOPLE, SumoNet, read_net
from jaxwalk.maps.network import CrossingType
from jaxwalk.wording import counted

AT_KERB = 4.0
"""A sidewalk or walking area speaks of kerbs whose line of people is nearer than this [m]."""
LEFT_OUT = ("highway.motorway", "highway.motorway_link")
"""Types of roads that aren't imported."""
SPEEDS = (5 / 3.6, 130 / 3.6)
"""Lowest and highest speed limit [m/s]."""
LANE_WIDTHS = (2.0, 8.0)
"""Narrowest and widest lane [m]."""
CROSSING_WIDTHS = (2.0, 8.0)
USUAL_WIDTH = 3.2
"""The width of lanes that have none in the file, by the format's definition [m]."""
MOST_VIA = 4
"""A way through a junction has at most this number of lanes."""


def sumo_map(path: Path, region: Region | None, *, left: bool = False) -> SourceMap:
    """Return what a SUMO network has; ``left``: traffic keeps left. Raise ImportRefusal if it can't be used."""
    return net_map(path, read_net(path, region), left=left)


def net_map(path: Path, net: SumoNet, *, left: bool) -> SourceMap:
    """Return what a network has that was read from a file, ``path``. Raise ImportRefusal if it can't be used."""
    net = _in_region(net)
    if left and not net.left:
        raise ImportRefusal(f"{path}: its lanes keep right; leave --traffic left out")
    edges = imported_edges(net)
    if not edges:
        where = "" if net.region is None else " in this region"
        raise ImportRefusal(f"{path}: has no roads{where} (edges with lanes for cars); name another file or part")
    extent = net.region or _extent(net, edges)
    refuse_large(path, extent)
    ground = roadway(net, edges)
    lanes, turns = _lanes(net, edges)
    made = mapped_lane_net(lanes, turns, ground, junction_regions(net, edges))
    return SourceMap(
        format="SUMO network",
        attribution=net.attribution,
        extent=extent,
        lanes=made.lanes,
        in_junction=made.in_junction,
        roadway=made.roadway,
        junctions=made.junctions,
        open_ends=tuple(open_ends(net, edges, extent)),
        crossings=tuple(_crossings(net, edges)),
        evidence=tuple(_evidence(net)),
        elements=tuple(_elements(net, edges)),
        left_out=tuple(_left_out(net, edges, made.no_turns)),
        notes=tuple(
            f"netconvert has guessed the {word} (its options in the file say so): they count as inferred"
            for word in sorted(net.guessed)
        ),
        elsewhere=_elsewhere(net, edges),
        mirrored=net.left,
    )


def _in_region(net: SumoNet) -> SumoNet:
    """Return a network with only the edges that come close to the region."""
    if net.region is None:
        return net
    west, south, east, north = (x + sign * AROUND for x, sign in zip(net.region, (-1, -1, 1, 1), strict=True))
    box = shapely.box(west, south, east, north)
    return net._replace(edges=[x for x in net.edges if box.intersects(shapely.LineString(_middle(net, x)))])


def imported_edges(net: SumoNet) -> list[Any]:
    """Return the edges of roads; none if no car may drive on any."""
    found = [edge for edge in net.edges if edge.getType() not in LEFT_OUT and is_road(edge)]
    return found if any(_is_driven(lane) for edge in found for lane in edge.getLanes()) else []


def _middle(net: SumoNet, edge: Any) -> np.ndarray:
    """Return the line of an edge's first lane that has one (point, 2) [m]."""
    return next((line for lane in edge.getLanes() if len(line := _line(net, lane)) > 1), np.zeros((2, 2)))


def _is_driven(lane: Any) -> bool:
    return is_for(lane, CARS) and len(lane.getShape()) > 1


def _line(net: SumoNet, lane: Any) -> np.ndarray:
    return net.points(lane.getShape())


def _extent(net: SumoNet, edges: Sequence[Any]) -> Box:
    points = np.concatenate([_line(net, lane) for edge in edges for lane in edge.getLanes()])
    (west, south), (east, north) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return west, south, east, north


def _lanes(net: SumoNet, edges: Sequence[Any]) -> tuple[list[MappedLane], list[MappedTurn]]:
    """Return the lanes for cars of some edges, and how they lead on."""
    driven = [lane for edge in edges for lane in edge.getLanes() if _is_driven(lane) and len(_line(net, lane)) > 1]
    number = {lane.getID(): n for n, lane in enumerate(driven)}
    lanes = [
        MappedLane(_line(net, lane), float(np.clip(lane.getWidth(), *LANE_WIDTHS)), _limit(lane)) for lane in driven
    ]
    joined = [
        (number[lane.getID()], number[link.getToLane().getID()], link)
        for lane in driven for link in lane.getOutgoing()
        if link.getToLane().getID() in number and link.getDirection() != BACK and link.allows(CARS)
    ]  # fmt: skip
    return lanes, [MappedTurn(before, after, _via(net, link)) for before, after, link in joined]


def _limit(lane: Any) -> float:
    return float(np.clip(lane.getSpeed(), *SPEEDS))


def _via(net: SumoNet, link: Any) -> np.ndarray:
    """Return the way of a connection inside its junction (point, 2) [m]; without points if it isn't mapped."""
    lines, via = [np.zeros((0, 2))], link.getViaLaneID()
    while via in net.inner and len(lines) <= MOST_VIA:
        lines.append(_line(net, net.inner[via]))
        via = next((x.getViaLaneID() for x in net.inner[via].getOutgoing()), "")
    return np.concatenate(lines)


def _crossings(net: SumoNet, edges: Sequence[Any]) -> Iterator[SourceCrossing]:
    """Yield the crossings of some edges."""
    imported = set(map(id, edges))
    for crossing in net.crossings:
        (lane,) = crossing.getLanes()
        line = _line(net, lane)
        if len(line) > 1 and any(id(edge) in imported for edge in crossing.getCrossingEdges()):
            kind, origin = _kind(net, crossing)
            whole = shapely.LineString(line)
            across = (line[-1] - line[0]) / np.hypot(*(line[-1] - line[0]))
            point = shapely.get_coordinates(whole.interpolate(0.5, normalized=True))[0]
            width = float(np.clip(lane.getWidth(), *CROSSING_WIDTHS))
            yield SourceCrossing(f"crossing {crossing.getID()}", kind, point, across, origin, width)


def _kind(net: SumoNet, crossing: Any) -> tuple[CrossingType, Origin]:
    """Return the kind of a crossing from the links that lead onto it: with a traffic light, or with right of way."""
    links = [link for links in crossing.getIncoming().values() for link in links]
    origin: Origin = "inferred" if "crossings" in net.guessed else "mapped"
    if any(link.getTLSID() for link in links):
        return "signals", origin
    return ("zebra" if any(link.getState() == "M" for link in links) else "unmarked"), origin


def _evidence(net: SumoNet) -> Iterator[WalkEvidence]:
    """Yield sidewalks, paths, and the outlines of walking areas."""
    origin = "inferred" if "sidewalks" in net.guessed else "mapped"
    lanes = [lane for edge in net.edges for lane in edge.getLanes()]
    lanes = [lane for lane in (*lanes, *net.inner.values()) if is_walk(lane)]
    yield from (WalkEvidence(line, origin, AT_KERB) for lane in lanes if len(line := _line(net, lane)) > 1)
    for area in net.walking_areas:
        outline = _line(net, area.getLanes()[0])
        if len(outline) > 2:
            yield WalkEvidence(np.concatenate([outline, outline[:1]]), origin, AT_KERB)


def _elements(net: SumoNet, edges: Sequence[Any]) -> Iterator[dict[str, Any]]:
    """Yield the facts of each road."""
    driven = [(edge, own) for edge in edges if (own := [lane for lane in edge.getLanes() if _is_driven(lane)])]
    for edge, lanes in driven:
        width = lanes[0].getWidth()
        yield {
            "element": f"edge {edge.getID()}", "name": edge.getName(), "class": edge.getType(),
            "lanes": [len(lanes), 0], "lanes_from": "mapped",
            "lane_width": round(width, 2), "width_from": "inferred" if width == USUAL_WIDTH else "mapped",
            "limit_km_h": round(lanes[0].getSpeed() * 3.6, 1), "limit_from": "mapped",
            "metres": round(float(edge.getLength()), 1),
        }  # fmt: skip


def _left_out(net: SumoNet, edges: Sequence[Any], no_turns: int) -> Iterator[str]:
    """Yield what isn't imported, and why."""
    motorways = sum(edge.getType() in LEFT_OUT for edge in net.edges)
    if motorways:
        yield f"{counted(motorways, 'edge')} of motorways: not among the roads that are imported"
    mixed = sum(any(is_for(lane, PEOPLE) and _is_driven(lane) for lane in edge.getLanes()) for edge in edges)
    if mixed:
        yield f"people on the roadway of {counted(mixed, 'edge')}: here they walk beside it, and cross it"
    buses = sum(not any(map(_is_driven, edge.getLanes())) for edge in edges)
    if buses:
        yield f"the lanes of {counted(buses, 'edge')} where no car may drive: they are roadway, on which nobody drives"
    stuck = sum(
        _is_driven(lane) and not leads_on(lane) for edge in ending_at_junctions(edges) for lane in edge.getLanes()
    )
    if stuck:
        yield (
            f"{counted(stuck, 'lane')} that {'end' if stuck > 1 else 'ends'} at a junction and "
            f"{'do' if stuck > 1 else 'does'}n't lead on: cars could only turn back there"
        )
    if no_turns:
        yield no_room(no_turns)


def _elsewhere(net: SumoNet, edges: Sequence[Any]) -> dict[str, int]:
    """Return the number of crossings that lead only over edges which aren't imported, by what they cross."""
    imported, near = set(map(id, edges)), set(map(id, net.edges))
    crossed = [(x, set(map(id, x.getCrossingEdges()))) for x in net.crossings]
    others = [x for x, own in crossed if own & near and not own & imported]
    kinds = Counter(
        "tracks" if any(lane.getPermissions() & TRACKS for edge in x.getCrossingEdges() for lane in edge.getLanes())
        else "other ways"
        for x in others
    )  # fmt: skip
    return dict(sorted(kinds.items()))
