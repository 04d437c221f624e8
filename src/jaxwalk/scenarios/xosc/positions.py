"""Positions of an OpenSCENARIO document as places of the world."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from jaxwalk.scenarios.xosc.catalog_entries import CatalogEntries
from jaxwalk.scenarios.xosc.elements import XoscRefusal, number, only, part, word
from jaxwalk.scenarios.xosc.plain_roads import PlainRoads, Pose


class OnLane(NamedTuple):
    """A place in the coordinates of a lane."""

    road: str
    lane: int
    s: float
    offset: float
    """Metres to the left of the lane's middle, seen along the road's line."""


class Positions:
    """Where positions are; those that count from road users count from where they begin."""

    def __init__(self, roads: PlainRoads, catalogs: CatalogEntries, begins: Mapping[str, ET.Element]) -> None:
        """Keep the roads, the catalogs, and the ``Position`` at which each road user begins."""
        self.roads, self.catalogs, self.begins = roads, catalogs, begins
        self.pending: set[str] = set()

    def at(self, position: ET.Element) -> Pose:
        """Return the place of a ``Position``. Raise XoscRefusal for kinds of position that aren't read."""
        found = only(position)
        lane = self.on_lane(position)
        if lane is not None:
            return _oriented(self._of_lane(lane), found)
        if found.tag == "WorldPosition":
            return Pose(*(number(found, name, 0.0 if name == "h" else None) for name in "xyh"))
        if found.tag == "RoadPosition":
            road, s, t = word(found, "roadId"), number(found, "s"), number(found, "t")
            return _oriented(self.roads.at(road, s, t), found)
        if found.tag in ("RelativeWorldPosition", "RelativeObjectPosition"):
            return self._relative(found)
        raise XoscRefusal(
            f"{found.tag}: isn't read; write a WorldPosition, LanePosition, RoadPosition, or one relative to an entity"
        )

    def begin(self, name: str) -> Pose:
        """Return where a road user begins. Raise XoscRefusal if nothing says so."""
        with _Once(self, name) as position:
            return self.at(position)

    def on_lane(self, position: ET.Element) -> OnLane | None:
        """Return the lane of a position; None if it doesn't name one."""
        found = only(position)
        if found.tag == "LanePosition":
            return OnLane(
                word(found, "roadId"), _lane(found, "laneId"), number(found, "s"), number(found, "offset", 0.0)
            )
        if found.tag == "RoutePosition":
            return self._on_route(found)
        if found.tag != "RelativeLanePosition":
            return None
        with _Once(self, word(found, "entityRef")) as other:
            lane = self.on_lane(other)
        if lane is None:
            raise XoscRefusal("RelativeLanePosition: its entity doesn't begin at a LanePosition; write a WorldPosition")
        ahead = number(found, "ds") * self.roads.direction(lane.road, lane.lane)
        number_of_lane = lane.lane + _lane(found, "dLane")
        if number_of_lane * lane.lane <= 0:
            raise XoscRefusal("RelativeLanePosition: a lane on the other side of the road; write a LanePosition")
        return OnLane(lane.road, number_of_lane, lane.s + ahead, number(found, "offset", 0.0))

    def lane_ahead(self, lane: OnLane, farthest: float) -> np.ndarray:
        """Return the middle of a lane from a place on, to the end of its road or so far [m], float64 (point, 2) [m]."""
        onward = self.roads.direction(lane.road, lane.lane)
        length = self.roads.length(lane.road)
        end = min(lane.s + farthest, length) if onward > 0 else max(lane.s - farthest, 0.0)
        count = max(2, int(abs(end - lane.s)) + 1)
        places = [self._of_lane(lane._replace(s=s)) for s in np.linspace(lane.s, end, count).tolist()]
        return np.array([place[:2] for place in places])

    def _of_lane(self, lane: OnLane) -> Pose:
        middle, _ = self.roads.lane_at(lane.road, lane.lane, lane.s)
        pose = self.roads.at(lane.road, lane.s, middle + lane.offset)
        backwards = self.roads.direction(lane.road, lane.lane) < 0
        return pose.beside(0.0, 0.0, np.pi if backwards else 0.0)

    def _on_route(self, found: ET.Element) -> OnLane:
        """Return a place so far along a route, if it is on the road of the first waypoint."""
        route = self.catalogs.resolved(only(part(found, "RouteRef")))
        first = self.on_lane(part(part(route, "Waypoint"), "Position"))
        place = only(part(found, "InRoutePosition"))
        if first is None or place.tag != "FromLaneCoordinates":
            raise XoscRefusal("RoutePosition: is read only with FromLaneCoordinates, on a route of LanePositions")
        ahead = number(place, "pathS") * self.roads.direction(first.road, first.lane)
        lane = OnLane(first.road, _lane(place, "laneId"), first.s + ahead, number(place, "laneOffset", 0.0))
        if not 0 <= lane.s <= self.roads.length(lane.road):
            raise XoscRefusal("RoutePosition: lies beyond the road of the first waypoint; write a LanePosition")
        return lane

    def _relative(self, found: ET.Element) -> Pose:
        other = self.begin(word(found, "entityRef"))
        dx, dy = number(found, "dx"), number(found, "dy")
        if found.tag == "RelativeObjectPosition":
            return _oriented(other.beside(dx, dy), found)
        return _oriented(Pose(other.x + dx, other.y + dy, other.heading), found)


class _Once:
    """The position at which a road user begins; a circle of positions is refused."""

    def __init__(self, positions: Positions, name: str) -> None:
        self.positions, self.name = positions, name

    def __enter__(self) -> ET.Element:
        if self.name in self.positions.pending:
            raise XoscRefusal(f"entity {self.name!r}: its position counts from itself; write a WorldPosition")
        if self.name not in self.positions.begins:
            raise XoscRefusal(f"entity {self.name!r}: no TeleportAction of Init says where it begins; add one")
        self.positions.pending.add(self.name)
        return self.positions.begins[self.name]

    def __exit__(self, *_: object) -> None:
        self.positions.pending.discard(self.name)


def _lane(element: ET.Element, name: str) -> int:
    value = number(element, name)
    if value != int(value):
        raise XoscRefusal(f"{element.tag}: {name} {value:g} is no whole number; correct it")
    return int(value)


def _oriented(pose: Pose, element: ET.Element) -> Pose:
    """Return a pose turned as its ``Orientation`` says, which by default counts from the map's east."""
    turn = element.find("Orientation")
    if turn is None:
        return pose
    angle = number(turn, "h", 0.0)
    return pose._replace(heading=pose.heading + angle if turn.get("type") == "relative" else angle)


def points_of(positions: Positions, elements: list[ET.Element]) -> np.ndarray:
    """Return the places of elements that have a ``Position``, float64 (point, 2) [m]."""
    return np.array([positions.at(part(one, "Position"))[:2] for one in elements]).reshape(-1, 2)
