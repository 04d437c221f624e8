"""A street from a part of a source map: it is cut out, its people's ways are completed, and it is checked."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.check_network import network_faults
from jaxwalk.maps.imported.crossing_places import CrossingOutcome, CrossingPlaces, Placed, RoadLines, connected_parts
from jaxwalk.maps.imported.kerb_ground import KerbGround, polygons
from jaxwalk.maps.imported.kerb_origins import KerbEvidence, Stretch, known_lines
from jaxwalk.maps.imported.source_map import Box, SourceMap, StreetFrame
from jaxwalk.maps.imported.street_parts import street_areas
from jaxwalk.maps.imported.street_report import StreetReport
from jaxwalk.maps.imported.street_summary import Built, summary
from jaxwalk.maps.imported.tile_lanes import RouteFinder, lanes_within, without_lanes
from jaxwalk.maps.imported.tile_walks import ZoneFinder, make_walks
from jaxwalk.maps.network import Lane, Network, WalkGraph
from jaxwalk.maps.network_scene import NetworkScene

DISTANCES = {"goal_spacing": 20.0, "start_clearance": 10.0}
"""The simulator's shortest walk to a goal, and its smallest distance between the car's start and people's [m]."""
CLOSE = 0.05
"""Points of a lane are farther apart than this [m]."""
ROUNDS = 5
"""So often are parts left out that don't keep the rules of all networks, before a street is given up."""
AROUND = 8.0
"""A street reaches this far beyond its roadway [m]."""
_FAULT = re.compile(r"(crossings|routes|lanes)\[(\d+)\]")


class ImportedStreet(NamedTuple):
    """A street with what became of it."""

    network: Network | None
    """None if it isn't usable."""
    report: StreetReport


class _Site(NamedTuple):
    """What a street is made of, before its crossings are chosen."""

    box: Box
    region: BaseGeometry
    ground: KerbGround
    stretches: list[Stretch]
    lanes: list[Lane]
    in_junction: np.ndarray


class StreetMaker:
    """Makes streets of parts of a source map. ``strict``: pavement and crossings are never invented."""

    def __init__(self, source: SourceMap, *, strict: bool) -> None:
        self.source, self.strict = source, strict
        self.ground = KerbGround.along(source.roadway)
        self.evidence = KerbEvidence(source.evidence)

    def make(self, name: str, box: Box, about: np.ndarray | None = None) -> ImportedStreet:
        """Return the street in a box.

        It has the roads that hang together at a point (2,), or those with the most crossings.
        """
        site = self._site(box, about)
        own = [x for x in self.source.crossings if site.region.contains(shapely.Point(x.point))]
        if not site.lanes or not site.ground.walks:
            why = "no lanes" if not site.lanes else "no pavement along its roads"
            outcomes = tuple(CrossingOutcome(x.name, x.kind, False, why, at_edge=True) for x in own)
            return ImportedStreet(None, summary(name, self._frame(box), Built((), (), [], [], outcomes), why))
        along, through = ([lane.line for lane, x in zip(site.lanes, site.in_junction, strict=True) if x == inside]
                          for inside in (False, True))  # fmt: skip
        places = CrossingPlaces(site.ground, site.region, RoadLines(along, through))
        outcomes = [places.place(crossing) for crossing in own]
        mapped = list(places.placed)
        if not self.strict:
            places.join(site.stretches, along)
        return self._completed(name, site, (mapped, places.placed), outcomes)

    def _frame(self, box: Box) -> StreetFrame:
        return StreetFrame(box, self.source.mirrored)

    def _site(self, box: Box, about: np.ndarray | None) -> _Site:
        """Return what lies in a box, without the junctions that its edge would cut, and without other roads."""
        region: BaseGeometry = shapely.box(*box)
        edge = region.boundary
        cuts = [x for x in self.source.junctions if x.intersects(edge)]
        cuts += [x for x in self.source.open_ends if x.intersects(region)]
        region = region.difference(shapely.union_all(cuts))
        road = self._road(polygons(self.ground.filled.intersection(region)), about)
        region = region.intersection(road.buffer(AROUND))
        ground = self.ground.within(region).beside(road)
        stretches = self.evidence.stretches(ground.walks)
        if self.strict:
            ground = ground.with_walks(list(known_lines(ground.walks, stretches)))
            stretches = self.evidence.stretches(ground.walks)
        lanes, inside = lanes_within(self.source, region, ground.roadway)
        return _Site(box, region, ground, stretches, lanes, inside)

    def _road(self, roads: list[shapely.Polygon], about: np.ndarray | None) -> BaseGeometry:
        """Return the one of several separate roads that the street is made of."""
        if about is not None:
            return min(roads, key=lambda x: x.distance(shapely.Point(about)), default=shapely.Polygon())
        points = shapely.points([x.point for x in self.source.crossings]) if self.source.crossings else []
        return max(roads, key=lambda x: (int(shapely.contains(x, points).sum()), x.area), default=shapely.Polygon())

    def _completed(
        self, name: str, site: _Site, crossings: tuple[list[Placed], list[Placed]], outcomes: list[CrossingOutcome]
    ) -> ImportedStreet:
        """Return the street, without the crossings and routes that don't keep the rules of all networks."""
        mapped, placed = crossings
        dropped: dict[str, str] = {}
        reason = ""
        for _ in range(ROUNDS):
            kept = [crossing for crossing in placed if crossing.name not in dropped]
            walks, kept, cut_off = _connected(site, kept)
            dropped |= {crossing.name: "cut off: no way leads there from the other pavement" for crossing in cut_off}
            if not kept:
                reason = "it has no crossing that can be used"
                break
            network, routes_met, faults = self._network(site, walks, kept)
            named = [(found[1], int(found[2]), fault) for fault in faults if (found := _FAULT.match(fault))]
            bad = {kept[n].name: fault for kind, n, fault in named if kind == "crossings"}
            bad_lanes = {n for kind, n, _ in named if kind == "lanes"}
            if faults and not bad and not bad_lanes:
                reason = faults[0]
                break
            if not faults:
                results = _updated(outcomes, dropped, placed)
                built = Built(tuple(mapped), tuple(kept), walks, site.stretches, results, routes_met, site.ground.walks)
                return ImportedStreet(network, summary(name, self._frame(site.box), built, "", network))
            dropped |= bad
            lanes, inside = without_lanes(site.lanes, site.in_junction, bad_lanes, site.ground.roadway)
            site = site._replace(lanes=lanes, in_junction=inside)
        results = _updated(outcomes, dropped, placed)
        built = Built(tuple(mapped), (), [], site.stretches, results, lines=site.ground.walks)
        return ImportedStreet(
            None, summary(name, self._frame(site.box), built, reason or "its parts don't keep the rules of maps")
        )

    def _network(self, site: _Site, walks: list[int], placed: list[Placed]) -> tuple[Network, list[bool], list[str]]:
        """Return the network of a site, which crossings its routes meet, and its faults; routes with faults are out."""
        lines = [site.ground.walks[n] for n in walks]
        number = {walk: n for n, walk in enumerate(walks)}
        own = [
            replace(x, chord=x.chord._replace(walks=(number[x.chord.walks[0]], number[x.chord.walks[1]])))
            for x in placed
        ]  # fmt: skip
        areas, crosswalks = street_areas(self.source, shapely.box(*site.box), site.ground, own)
        size = (site.box[2] - site.box[0], site.box[3] - site.box[1])
        empty = Network(size, (), tuple(areas), WalkGraph(np.zeros((0, 2)), np.zeros((0, 2), int), 0), (), ())
        pairs = zip(site.lanes, site.in_junction, strict=True)
        between = [shapely.LineString(lane.line) for lane, inside in pairs if not inside]
        finder = ZoneFinder(lines, own, NetworkScene.of(empty), between)
        zones = [finder.find(crossing) for crossing in own]
        plan = make_walks(lines, own, crosswalks, zones)
        routes, met = RouteFinder(site.lanes).routes([x.areas for x in own])
        network = replace(
            empty, lanes=tuple(site.lanes), walk=plan.graph, crossings=plan.crossings, routes=tuple(routes),
            attribution=self.source.attribution,
        )  # fmt: skip
        network = _placed(network, self._frame(site.box))
        faults = network_faults(network, **DISTANCES)
        wrong = {int(found[2]) for fault in faults if (found := _FAULT.match(fault)) and found[1] == "routes"}
        if wrong:
            routes = tuple(route for n, route in enumerate(network.routes) if n not in wrong)
            network = replace(network, routes=routes)
            faults = network_faults(network, **DISTANCES)
        return network, met, faults


def _placed(network: Network, frame: StreetFrame) -> Network:
    """Return a network whose south-western corner is (0, 0)."""
    size = tuple(round(x, 3) for x in network.size)

    def placed(points: np.ndarray) -> np.ndarray:
        return np.clip(frame.placed(points), 0.0, size)  # rounding may lead over the edge

    return replace(
        network,
        size=size,
        lanes=tuple(replace(x, line=_distinct(placed(x.line))) for x in network.lanes),
        areas=tuple(
            replace(x, outline=placed(x.outline), holes=tuple(placed(hole) for hole in x.holes)) for x in network.areas
        ),
        walk=replace(network.walk, nodes=placed(network.walk.nodes)),
    )


def _distinct(line: np.ndarray) -> np.ndarray:
    """Return a line (point, 2) without points so close to the one before that rounding would turn its direction."""
    apart = np.hypot(*np.diff(line, axis=0).T) > CLOSE
    keep = np.concatenate([[True], apart[:-1], [True]])
    keep[-2] &= bool(apart[-1]) or len(line) == 2
    return line[keep]


def _connected(site: _Site, placed: list[Placed]) -> tuple[list[int], list[Placed], list[Placed]]:
    """Return the lines of people that hang together, with their crossings, and the crossings that are cut off."""
    group = np.array(connected_parts(len(site.ground.walks), placed))
    metres = np.bincount(group, [walk.length for walk in site.ground.walks])
    crossed = np.bincount(group[[x.chord.walks[0] for x in placed]], minlength=len(metres)) if placed else metres
    best = int(np.argmax(metres + 1e6 * (crossed > 0)))
    walks = np.flatnonzero(group == best).tolist()
    kept = [x for x in placed if x.chord.walks[0] in walks]
    return walks, kept, [x for x in placed if x.chord.walks[0] not in walks]


def _updated(
    outcomes: Sequence[CrossingOutcome], dropped: dict[str, str], placed: Sequence[Placed]
) -> tuple[CrossingOutcome, ...]:
    """Return what became of mapped crossings, of which some were placed and then left out."""
    found = []
    for outcome in outcomes:
        host = outcome.reason.removeprefix("one way with ") if outcome.placed and outcome.reason else outcome.name
        why = dropped.get(host)
        found.append(outcome if why is None else replace(outcome, placed=False, reason=why))
    return tuple(found)
