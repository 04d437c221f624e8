"""Roads of an OpenDRIVE file, one by one: where a lane is. Junctions and what roads lead to aren't read."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

import numpy as np

from jaxwalk.scenarios.xosc.elements import XoscRefusal, number, read_elements, word

SAMPLED = 0.25
"""Distance of the points of a road's line [m]."""
LONGEST_ROAD = 100_000.0
"""Longest road [m]."""
MOST_PIECES = 2000
"""Most lane sections, offsets or widths of a road, one after the other."""
DRIVEN = ("driving", "bidirectional", "entry", "exit", "onRamp", "offRamp", "connectingRamp")
"""Types of lanes on which vehicles drive."""


class Pose(NamedTuple):
    """A place [m] and a direction [rad]."""

    x: float
    y: float
    heading: float

    def beside(self, ahead: float, left: float, turn: float = 0.0) -> Pose:
        """Return the place so far ahead and to the left [m], turned to the left [rad]."""
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        x, y = self.x + ahead * cos - left * sin, self.y + ahead * sin + left * cos
        return Pose(float(x), float(y), self.heading + turn)


class PlainRoads:
    """The roads of a file, which is read when the first one is asked for."""

    def __init__(self, path: Path | None) -> None:
        """Keep the path of the OpenDRIVE file; None if the scenario names none."""
        self.path = path
        self.roads: dict[str, ET.Element] | None = None
        self.lines: dict[str, np.ndarray] = {}

    def road(self, id: str) -> ET.Element:
        """Return a road. Raise XoscRefusal if it isn't there."""
        if self.path is None:
            raise XoscRefusal("RoadNetwork: names no OpenDRIVE file, so that positions on lanes are unknown; add one")
        if self.roads is None:
            try:
                root = read_elements(self.path, "OpenDRIVE")
            except XoscRefusal as error:
                raise XoscRefusal(f"LogicFile {self.path.name}: {error}") from None
            self.roads = {word(one, "id", ""): one for one in reversed(root.findall("road"))}
        if id not in self.roads:
            raise XoscRefusal(f"LogicFile {self.path.name}: has no road {id}; correct roadId")
        return self.roads[id]

    def at(self, id: str, s: float, t: float) -> Pose:
        """Return a place in the coordinates of a road [m]. Raise XoscRefusal if it isn't on the road."""
        line = self._line(id)
        if not -0.5 <= s <= line[-1, 0] + 0.5:
            raise XoscRefusal(f"road {id}: is {line[-1, 0]:g} m long, there is no s = {s:g}; correct it")
        x, y, heading = (float(np.interp(s, line[:, 0], line[:, k])) for k in (1, 2, 3))
        return Pose(x, y, heading).beside(0.0, t)

    def length(self, id: str) -> float:
        """Return the length of a road [m]."""
        return float(self._line(id)[-1, 0])

    def lane_at(self, id: str, lane: int, s: float) -> tuple[float, float]:
        """Return where the middle of a lane lies [m to the left of the road's line], and its width [m]."""
        lanes = self.lanes(id, s)
        if lane not in lanes:
            raise XoscRefusal(f"road {id}: has no lane {lane} at s = {s:g}; correct laneId")
        begin, end, _ = lanes[lane]
        return (begin + end) / 2, abs(end - begin)

    def direction(self, id: str, lane: int) -> int:
        """Return 1 if traffic on a lane follows the road's line, -1 if it goes the other way."""
        left_hand = self.road(id).get("rule") == "LHT"
        return 1 if (lane < 0) != left_hand else -1

    def roadway(self, id: str, lane: int, s: float) -> tuple[float, float]:
        """Return where the driven lanes begin and end that adjoin one lane, and each other [m to the left]."""
        lanes = self.lanes(id, s)
        edges = sorted(lanes[lane][:2])
        driven = [sorted((begin, end)) for begin, end, kind in lanes.values() if kind in DRIVEN]
        for begin, end in sorted(driven):
            edges[1] = max(edges[1], end) if begin <= edges[1] + 0.1 else edges[1]
        for begin, end in sorted(driven, reverse=True):
            edges[0] = min(edges[0], begin) if end >= edges[0] - 0.1 else edges[0]
        return edges[0], edges[1]

    def _line(self, id: str) -> np.ndarray:
        """Return s, x, y and heading of a road's line, float64 (point, 4)."""
        if id not in self.lines:
            geometries = self.road(id).findall("planView/geometry")
            length = sum(abs(number(one, "length")) for one in geometries)
            if not length <= LONGEST_ROAD:
                raise XoscRefusal(f"road {id}: is {length:g} m long; at most {LONGEST_ROAD:,g} m are read")
            pieces = [_sampled(one) for one in geometries]
            if not pieces:
                raise XoscRefusal(f"road {id}: has no geometry; correct the OpenDRIVE file")
            line = np.concatenate(pieces)
            line[:, 3] = np.unwrap(line[:, 3])
            self.lines[id] = line
        return self.lines[id]

    def lanes(self, id: str, s: float) -> dict[int, tuple[float, float, str]]:
        """Return where each lane begins and ends, outward [m to the left], and its type."""
        road = self.road(id)
        section = _in_force(road.findall("lanes/laneSection"), "s", s)
        if section is None:
            raise XoscRefusal(f"road {id}: has no lanes at s = {s:g}; correct the OpenDRIVE file")
        offset = _cubic(_in_force(road.findall("lanes/laneOffset"), "s", s), "s", s)
        found = {}
        for side, sign in (("left", 1), ("right", -1)):
            edge = offset
            for lane in sorted(section.findall(f"{side}/lane"), key=lambda one: abs(number(one, "id"))):
                ds = s - number(section, "s")
                width = _cubic(_in_force(lane.findall("width"), "sOffset", ds), "sOffset", ds)
                found[int(number(lane, "id"))] = (edge, edge + sign * width, word(lane, "type", "none"))
                edge += sign * width
        return found


def _in_force(elements: list[ET.Element], name: str, s: float) -> ET.Element | None:
    """Return the last element that has begun at some place [m]; the first if none has."""
    if len(elements) > MOST_PIECES:
        raise XoscRefusal(f"{elements[0].tag}: {len(elements):,} of one road; at most {MOST_PIECES:,} are read")
    begun = [one for one in elements if number(one, name, 0.0) <= s + 1e-6]
    return begun[-1] if begun else next(iter(elements), None)


def _cubic(element: ET.Element | None, name: str, s: float) -> float:
    """Return a cubic polynomial at a place [m]; 0 without an element."""
    if element is None:
        return 0.0
    ds = s - number(element, name, 0.0)
    a, b, c, d = (number(element, key, 0.0) for key in "abcd")
    return a + ds * (b + ds * (c + ds * d))


def _sampled(geometry: ET.Element) -> np.ndarray:
    """Return s, x, y and heading of a piece of a road's line, float64 (point, 4)."""
    start, length = number(geometry, "s"), number(geometry, "length")
    if length < 0:
        raise XoscRefusal(f"geometry: a length of {length:g} m; correct the OpenDRIVE file")
    along = np.linspace(0, length, max(2, int(np.ceil(length / SAMPLED)) + 1))
    u, v, turn = _local(geometry, along)
    x, y, heading = (number(geometry, name) for name in ("x", "y", "hdg"))
    cos, sin = np.cos(heading), np.sin(heading)
    return np.stack([start + along, x + u * cos - v * sin, y + u * sin + v * cos, heading + turn], axis=1)


def _local(geometry: ET.Element, along: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return places ahead and to the left of a geometry's beginning [m], and directions [rad]."""
    curved = {one.tag: one for one in geometry}
    if "paramPoly3" in curved:
        form, length = curved["paramPoly3"], along[-1]
        p = along if form.get("pRange") == "arcLength" else along / max(length, 1e-9)
        u, v = ([number(form, f"{key}{axis}") for key in "abcd"] for axis in "UV")
        slopes = [b + p * (2 * c + 3 * d * p) for _, b, c, d in (u, v)]
        ahead, left = (a + p * (b + p * (c + p * d)) for a, b, c, d in (u, v))
        return ahead, left, np.arctan2(slopes[1], slopes[0])
    if "line" in curved:
        curvature = 0 * along
    elif "arc" in curved:
        curvature = 0 * along + number(curved["arc"], "curvature")
    elif "spiral" in curved:
        ends = [number(curved["spiral"], name) for name in ("curvStart", "curvEnd")]
        curvature = np.interp(along, along[[0, -1]], ends)
    else:
        raise XoscRefusal("geometry: is no line, arc, spiral or paramPoly3; other roads can't be read")
    step = np.diff(along)
    turn = np.concatenate([[0.0], ((curvature[1:] + curvature[:-1]) / 2 * step).cumsum()])
    middle = (turn[1:] + turn[:-1]) / 2
    u, v = (np.concatenate([[0.0], (one(middle) * step).cumsum()]) for one in (np.cos, np.sin))
    return u, v, turn
