"""The crossings of a street: mapped ones where they are mapped, and invented ones that join what people can't reach."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.imported.chords import LEAST_HALF, SHIFTS, Chord, Chords
from jaxwalk.maps.imported.kerb_ground import KerbGround, unit
from jaxwalk.maps.imported.kerb_origins import Stretch
from jaxwalk.maps.imported.source_map import SourceCrossing
from jaxwalk.maps.network import CrossingType

FROM_EDGE = 3.0
"""A crossing closer to the street's edge is left to a neighbouring street [m]."""
NEAR_EDGE = 30.0
"""A crossing that can't be placed may find room in a neighbouring street if it lies so close to the edge [m]."""
SAME = 1.0
"""A mapped crossing this close to the crosswalk of another one is the same [m]."""
SHARED = 2.0
"""A mapped crossing without room of its own is one way with another one whose crosswalk is this close [m]."""
OVERLAP = 0.5
"""Crosswalks may overlap by this [m2]."""
APART = 0.4
"""Smallest distance between two landings [m]."""
FROM_LANE_END, EVERY = 3.0, 30.0
"""An invented crossing lies so far from where a lane begins or ends, or at such distances between [m]."""
FROM_EDGE_INVENTED = 25.0
"""The street goes on so far on both sides of an invented crossing if it can, so that routes lead over it [m]."""
WORTH = 30.0
"""A line of people that is shorter, and where the source says nothing of a sidewalk, isn't worth a crossing [m]."""
NEAREST_ROAD = 15.0
"""The direction of a road is that of the nearest lane within this [m]."""


@dataclass(frozen=True)
class Placed:
    """A crossing of a street."""

    name: str
    kind: CrossingType
    kind_origin: str
    origin: Literal["mapped", "invented"]
    chord: Chord
    areas: tuple[shapely.Polygon, ...]
    islands: tuple[shapely.Polygon, ...]
    aprons: tuple[shapely.Polygon, ...]
    """The ground between its landings and the roadway."""
    half: float
    """Half its width [m]."""
    wants_island: bool = False


@dataclass(frozen=True)
class CrossingOutcome:
    """What became of a mapped crossing."""

    name: str
    kind: CrossingType
    placed: bool
    reason: str = ""
    """Why it isn't in the street."""
    moved: float = 0.0
    """By how much it was moved [m]."""
    at_edge: bool = False
    """Whether a neighbouring street may have it."""
    point: tuple[float, float] = (0.0, 0.0)
    """[m] in the source map."""


class RoadLines:
    """The lanes of a street, to ask for the direction of a road."""

    def __init__(self, lines: Sequence[np.ndarray], through: Sequence[np.ndarray] = ()) -> None:
        """Get ready; ``through`` are lanes in junctions, which count where no other lane is near."""
        self.shapes = [[shapely.LineString(line) for line in own] for own in (lines, through)]
        self.trees = [shapely.STRtree(own) for own in self.shapes]

    def direction(self, point: np.ndarray) -> np.ndarray | None:
        """Return the unit vector along the road at a point (2,), or None if there is no road."""
        line = self._nearest(shapely.Point(point))
        if line is None:
            return None
        at = line.project(shapely.Point(point))
        low, high = (line.interpolate(min(max(at + step, 0.0), line.length)) for step in (-1.0, 1.0))
        return unit(np.array([high.x - low.x, high.y - low.y]))

    def _nearest(self, point: shapely.Point) -> shapely.LineString | None:
        for tree, shapes in zip(self.trees, self.shapes, strict=True):
            found = tree.query_nearest(point, max_distance=NEAREST_ROAD, all_matches=False)
            if len(found):
                return shapes[int(found[0])]
        return None


class CrossingPlaces:
    """The crossings of a street while they are placed."""

    def __init__(self, ground: KerbGround, region: BaseGeometry, roads: RoadLines) -> None:
        self.ground, self.region, self.roads = ground, region, roads
        self.chords = Chords(ground)
        self.placed: list[Placed] = []

    def place(self, crossing: SourceCrossing) -> CrossingOutcome:
        """Place a mapped crossing, and return what became of it."""
        point = crossing.point
        about = (crossing.name, crossing.kind)
        where = (float(point[0]), float(point[1]))
        twin = self._near(point, SAME)
        if twin is not None:
            return CrossingOutcome(*about, True, f"one way with {twin.name}", point=where)
        road = self.roads.direction(point)
        at_edge = self.region.boundary.distance(shapely.Point(point)) < FROM_EDGE
        if road is None or at_edge:
            reason = "at the street's edge" if at_edge else "no lane near it"
            return CrossingOutcome(*about, False, reason, at_edge=at_edge, point=where)
        found = self._found(crossing, road)
        if isinstance(found, str) and (twin := self._near(point, SHARED)) is not None:
            return CrossingOutcome(*about, True, f"one way with {twin.name}", point=where)
        if isinstance(found, str):
            near = self.region.boundary.distance(shapely.Point(point)) < NEAR_EDGE
            return CrossingOutcome(*about, False, found, at_edge=near, point=where)
        self.placed.append(found)
        return CrossingOutcome(*about, True, moved=found.chord.moved, point=where)

    def _found(self, crossing: SourceCrossing, road: np.ndarray) -> Placed | str:
        """Return the crossing where it is mapped, else moved along the road (2,), or why there is no room."""
        chord = self.chords.best(crossing.point, road, crossing.across)
        found = chord if isinstance(chord, str) else self._made(chord, crossing)
        for shift in SHIFTS[1:]:
            if not isinstance(found, str):
                return found
            chord = self.chords.best(crossing.point, road, shifts=(shift,))
            moved = chord if isinstance(chord, str) else self._made(chord, crossing)
            found = found if isinstance(moved, str) else moved
        return found

    def _near(self, point: np.ndarray, metres: float) -> Placed | None:
        """Return a placed crossing with a crosswalk so close to a point (2,), or None."""
        at = shapely.Point(point)
        return next((x for x in self.placed if any(area.distance(at) < metres for area in x.areas)), None)

    def _made(self, chord: Chord, crossing: SourceCrossing) -> Placed | str:
        """Return the crossing on a chord, as wide as there is room for, or why there is none."""
        ends = [end for x in self.placed for end in x.chord.ends]
        if any(np.hypot(*(end - other)) < APART for end in chord.ends for other in ends):
            return "its landing is another crossing's"
        for half in (crossing.width / 2, 1.5, LEAST_HALF):
            if half > crossing.width / 2:
                continue
            areas = chord.areas(self.ground.roadway, half)
            blocker = self._blocker(areas)
            if blocker is None:
                islands = chord.islands(self.ground.roadway, half + 0.5)
                aprons = chord.aprons(self.ground.roadway, half)
                return Placed(crossing.name, crossing.kind, crossing.kind_origin, "mapped", chord, tuple(areas),
                              tuple(islands), tuple(aprons), half, crossing.island)  # fmt: skip
        return f"it overlaps {self._blocker(areas)}"

    def _blocker(self, areas: Iterable[shapely.Polygon]) -> str | None:
        """Return the name of a crossing that some areas overlap."""
        whole = shapely.union_all(list(areas))
        for other in self.placed:
            if any(whole.intersection(area).area > OVERLAP for area in other.areas if area.intersects(whole)):
                return other.name
        return None

    def join(self, stretches: Sequence[Stretch], lines: Sequence[np.ndarray]) -> None:
        """Invent crossings where lines of people don't reach each other: short ones, straight over a road."""
        group = self.parts()
        worth = {s.walk for s in stretches if s.origin != "invented"}
        worth |= {n for n, walk in enumerate(self.ground.walks) if walk.length >= WORTH}
        for number, chord in enumerate(sorted(self._candidates(lines), key=self._preference)):
            one, other = chord.walks
            if group[one] == group[other] or not {one, other} <= worth:
                continue
            source = SourceCrossing(f"invented {number}", "unmarked", chord.at(chord.length / 2), width=3.0,
                                    kind_origin="invented")  # fmt: skip
            found = self._made(chord, source)
            if isinstance(found, Placed):
                self.placed.append(replace(found, origin="invented"))
                group = [group[one] if x == group[other] else x for x in group]

    def _preference(self, chord: Chord) -> tuple[bool, float]:
        """Return what sorts ways over roads: those well inside the street first, then the shortest."""
        along = FROM_EDGE_INVENTED * np.array([-chord.ahead[1], chord.ahead[0]])
        middle = chord.at(chord.length / 2)
        inside = shapely.contains(self.region, shapely.points([middle - along, middle + along]))
        return not inside.all(), chord.length

    def parts(self) -> list[int]:
        """Return the number of the connected part of each line of people."""
        return connected_parts(len(self.ground.walks), self.placed)

    def _candidates(self, lines: Sequence[np.ndarray]) -> Iterator[Chord]:
        """Yield ways straight over roads: near the ends of lanes, and between."""
        group = self.parts()
        found: dict[tuple[int, ...], Chord] = {}
        for point in _places_along(lines):
            road = self.roads.direction(point)
            chord = "no road" if road is None else self.chords.best(point, road, shifts=(0.0,))
            if isinstance(chord, str) or group[chord.walks[0]] == group[chord.walks[1]]:
                continue
            if self.region.boundary.distance(shapely.LineString(chord.ends)) >= FROM_EDGE / 2:
                found.setdefault(tuple(np.round(chord.ends.sum(axis=0)).astype(int).tolist()), chord)
        yield from found.values()


def _places_along(lines: Sequence[np.ndarray]) -> Iterator[np.ndarray]:
    """Yield points (2,) near the ends of lines, and between."""
    for line in map(shapely.LineString, lines):
        inner = line.length - 2 * FROM_LANE_END
        steps = FROM_LANE_END + np.linspace(0, inner, 2 + int(inner // EVERY)) if inner > 0 else np.zeros(0)
        yield from shapely.get_coordinates(shapely.line_interpolate_point(line, steps))


def connected_parts(walks: int, placed: Iterable[Placed]) -> list[int]:
    """Return the number of the connected part of each line of people, joined by crossings."""
    group = list(range(walks))
    for crossing in placed:
        one, other = (group[walk] for walk in crossing.chord.walks)
        group = [one if x == other else x for x in group]
    return group
