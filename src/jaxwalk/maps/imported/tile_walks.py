"""The people's side of an imported street: its walk graph and crossings, with jaywalk zones where there is room."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from jaxwalk.maps.check_walking import UNEVEN, chord_faults, ways_across
from jaxwalk.maps.imported.crossing_places import Placed
from jaxwalk.maps.network import Crossing, JaywalkZone, WalkGraph
from jaxwalk.maps.network_scene import NetworkScene
from jaxwalk.maps.network_zones import ZoneLines
from jaxwalk.maps.walk_lines import WalkLines

LENGTHS = (24.0, 18.0, 12.0, 8.0)
"""Lengths of jaywalk zones that are tried [m]."""
BESIDE, END = 1.0, 0.5
"""A zone begins this far from its crosswalk, and its sides go on beyond it by this [m]."""
FROM_LANE_END = 1.0
"""A zone ends this far from where its lane does, which is where a junction's kerbs begin to bend [m]."""
BEND, TURN = 0.1, 0.05
"""A kerb that leaves the line between its ends by less than this is straight [m]; sides that differ by less than
this in direction are parallel [rad]."""
PIECE = 3.0
"""Longest piece of a bent zone's kerb [m]."""
OBLIQUE = 0.3
"""Beside a bent road, a crossing at a larger angle from straight over it has no zone [rad]."""


class ZoneSides(NamedTuple):
    """A jaywalk zone before its nodes have numbers."""

    places: tuple[list[float], list[float]]
    """Where the nodes of the two sides lie on their lines of people [m], the landings first."""
    begin: float
    end: float


class WalkPlan(NamedTuple):
    """The walk graph and the crossings of a street."""

    graph: WalkGraph
    crossings: tuple[Crossing, ...]


def make_walks(
    walks: Sequence[shapely.LineString], placed: Sequence[Placed], areas: Sequence[tuple[int, ...]],
    zones: Sequence[ZoneSides | None],
) -> WalkPlan:  # fmt: skip
    """Return the walk graph and the crossings; ``areas`` are the numbers of each crossing's crosswalks."""
    lines = WalkLines(walks)
    chains, sides = [], []
    for crossing, zone in zip(placed, zones, strict=True):
        chord = crossing.chord
        ends = [lines.add_on(walk, end, waypoint=True) for walk, end in zip(chord.walks, chord.ends, strict=True)]
        chains.append((ends[0], *(lines.add(node) for node in chord.nodes()), ends[1]))
        sides.append(None if zone is None else _add_zone(lines, chord.walks, ends, zone))
    for chain in chains:
        lines.edges += pairwise(chain)
    for number in range(len(walks)):
        lines.join(number)
    graph, number = lines.renumbered()
    crossings = []
    for crossing, chain, own, zone, side in zip(placed, chains, areas, zones, sides, strict=True):
        found = None
        if zone is not None and side is not None:
            one, other = (tuple(int(number[n]) for n in nodes) for nodes in side)
            found = JaywalkZone((one, other), zone.begin, zone.end)
        crossings.append(Crossing(crossing.kind, own, tuple(int(number[n]) for n in chain), found))
    return WalkPlan(graph, tuple(crossings))


def _add_zone(
    lines: WalkLines, walks: tuple[int, int], ends: Sequence[int], zone: ZoneSides
) -> tuple[list[int], list[int]]:
    """Add the nodes of a zone and return those of its two sides."""
    found: tuple[list[int], list[int]] = ([ends[0]], [ends[1]])
    for walk, nodes, places in zip(walks, found, zone.places, strict=True):
        for place in places[1:]:
            point = np.array(lines.lines[walk].interpolate(place).coords[0])
            nodes.append(lines.add_on(walk, point, waypoint=place == places[-1]))
        lines.straight |= {frozenset(pair) for pair in pairwise(nodes)}
    return found


class ZoneFinder:
    """Finds jaywalk zones, none of which meets another one, a crosswalk or a junction."""

    def __init__(
        self, walks: Sequence[shapely.LineString], placed: Sequence[Placed], scene: NetworkScene,
        lines: Sequence[shapely.LineString],
    ) -> None:  # fmt: skip
        """Get ready; ``lines`` are lanes outside junctions."""
        self.walks, self.placed, self.scene, self.lines = walks, placed, scene, lines
        self.tree = shapely.STRtree(list(lines))
        self.taken: list[list[tuple[float, float]]] = [[] for _ in walks]
        for crossing in placed:
            for walk, place in zip(crossing.chord.walks, crossing.chord.places, strict=True):
                self.taken[walk].append((place, place))

    def find(self, crossing: Placed) -> ZoneSides | None:
        """Return the zone of a crossing, the longest one for which there is room; None without one."""
        chord = crossing.chord
        if len(chord.over) > 1:
            return None
        middle = chord.at(float(chord.over.mean()))
        number = self.tree.query_nearest(shapely.LineString(chord.ends), max_distance=0.01, all_matches=False)
        if not len(number):
            return None
        lane = self.lines[int(number[0])]
        at = lane.project(shapely.Point(middle))
        rooms = sorted(((room, sign) for room, sign in ((lane.length - at, 1), (at, -1))), reverse=True)
        tries = [(length, sign) for length in LENGTHS for room, sign in rooms if length + END <= room - FROM_LANE_END]
        zones = (self._tried(crossing, lane, (at, sign), length) for length, sign in tries)
        zone = next((zone for zone in zones if zone is not None), None)
        for walk, places in zip(chord.walks, zone.places, strict=True) if zone is not None else ():
            self.taken[walk].append((min(places), max(places)))
        return zone

    def _tried(
        self, crossing: Placed, lane: shapely.LineString, where: tuple[float, int], length: float
    ) -> ZoneSides | None:
        """Return the zone of a length, if it keeps all rules. ``where``: the place on the lane, and which way."""
        at, sign = where
        near, far = (np.array(lane.interpolate(x).coords[0]) for x in (at, at + sign * 2.0))
        ahead = (far - near) / max(float(np.hypot(*(far - near))), 1e-9)
        reach = length + END
        signs = [self._way(walk, place, ahead) for walk, place in zip(*crossing.chord[1:3], strict=True)]
        straight = [[place, place + way * reach] for place, way in zip(crossing.chord.places, signs, strict=True)]
        places = straight if self._is_straight(crossing, straight) else self._bent(crossing, lane, where, reach)
        if places is None or not self._is_free(crossing, places, signs):
            return None
        zone = ZoneSides((places[0], places[1]), crossing.half + BESIDE, length)
        return zone if self._is_clear(crossing, zone) else None

    def _way(self, walk: int, place: float, ahead: np.ndarray) -> int:
        """Return 1 if a line of people leads ahead at a place, -1 if it leads back."""
        one, other = self._points(walk, [place - 0.5, place + 0.5])
        return 1 if float((other - one) @ ahead) >= 0 else -1

    def _points(self, walk: int, places: Sequence[float]) -> np.ndarray:
        return shapely.get_coordinates(shapely.line_interpolate_point(self.walks[walk], np.maximum(places, 0.0)))

    def _is_straight(self, crossing: Placed, places: list[list[float]]) -> bool:
        """Return whether both kerbs are straight and parallel between their two places."""
        headings = []
        for walk, (begin, end) in zip(crossing.chord.walks, places, strict=True):
            if not 0 <= end <= self.walks[walk].length:
                return False
            inner = self._points(walk, np.linspace(begin, end, 13).tolist())
            chord = shapely.LineString([inner[0], inner[-1]])
            if chord.length < 1 or shapely.distance(chord, shapely.points(inner)).max() > BEND:
                return False
            headings.append((inner[-1] - inner[0]) / chord.length)
        return float(headings[0] @ headings[1]) > float(np.cos(TURN))

    def _bent(
        self, crossing: Placed, lane: shapely.LineString, where: tuple[float, int], reach: float
    ) -> list[list[float]] | None:
        """Return the places of nodes along bent kerbs: where lines straight over the road meet them."""
        at, sign = where
        count = int(np.ceil(reach / PIECE))
        stations = at + sign * np.linspace(0, reach, count + 1)[1:]
        before, after = (
            shapely.get_coordinates(shapely.line_interpolate_point(lane, stations + d)) for d in (-0.5, 0.5)
        )
        ahead = (after - before) / np.hypot(*(after - before).T)[:, None]
        if abs(float(crossing.chord.ahead @ ahead[0])) > np.sin(OBLIQUE):
            return None
        aside = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)
        ends = np.stack([before + after - 80 * aside, before + after + 80 * aside], axis=1) / 2
        rays = [shapely.LineString(pair) for pair in ends]
        found = [self._facing(walk, place, rays) for walk, place in zip(*crossing.chord[1:3], strict=True)]
        return None if found[0] is None or found[1] is None else [found[0], found[1]]

    def _facing(self, walk: int, place: float, rays: Sequence[shapely.LineString]) -> list[float] | None:
        """Return a place on a line of people and those where rays meet it, one after the other; None if one doesn't."""
        places = [place]
        for ray in rays:
            last = self.walks[walk].interpolate(places[-1])
            met = shapely.get_parts(self.walks[walk].intersection(ray)).tolist()
            point = min(met, key=last.distance, default=None)
            if point is None or point.geom_type != "Point" or point.distance(last) > 2 * PIECE:
                return None
            places.append(float(self.walks[walk].project(point)))
        return places

    def _is_free(self, crossing: Placed, places: list[list[float]], signs: Sequence[int]) -> bool:
        """Return whether the nodes follow each other along their lines, with no other zone or landing between."""
        for walk, own, sign in zip(crossing.chord.walks, places, signs, strict=True):
            steps = np.diff(own) * sign
            low, high = min(own) - 0.5, max(own) + 0.5
            if steps.min() < 0.5 or low < 0 or high > self.walks[walk].length:
                return False
            own_landing = (own[0], own[0])
            if any(a < high and low < b for a, b in self.taken[walk] if (a, b) != own_landing):
                return False
        return crossing.chord.walks[0] != crossing.chord.walks[1] or not _meet(places)

    def _is_clear(self, crossing: Placed, zone: ZoneSides) -> bool:
        """Return whether every way across the zone keeps the rules of all networks."""
        sides = [self._points(walk, places) for walk, places in zip(crossing.chord.walks, zone.places, strict=True)]
        lines = ZoneLines.between(np.stack(sides))
        if lines.pieces.max() > UNEVEN * lines.pieces.min() or not zone.begin < zone.end < lines.length:
            return False
        pieces = [shapely.LineString(pair) for side in sides for pair in pairwise(side)]
        if not shapely.covers(self.scene.pavement, pieces).all():
            return False
        return not any(chord_faults(np.array(list(ways_across(lines, zone.begin, zone.end))), self.scene))


def _meet(places: list[list[float]]) -> bool:
    """Return whether two stretches of one line meet."""
    (a, b), (c, d) = ((min(own), max(own)) for own in places)
    return a < d + 0.5 and c < b + 0.5
