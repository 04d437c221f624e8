"""Where and how fast the tested car of an OpenSCENARIO document goes, if nothing is in its way."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from jaxwalk.scenarios.xosc.changing_speeds import change_of
from jaxwalk.scenarios.xosc.elements import XoscRefusal, called, number, only, part
from jaxwalk.scenarios.xosc.made_street import Strip
from jaxwalk.scenarios.xosc.plain_roads import Pose
from jaxwalk.scenarios.xosc.positions import Positions, points_of
from jaxwalk.scenarios.xosc.road_users import DRIVING, RoadUser, private_actions
from jaxwalk.scenarios.xosc.trajectories import times_of, timing_of, vertices, waypoints
from jaxwalk.scenarios.xosc.triggers import Beginning, Comes

LANE_WIDTH = 3.5
"""Width of lanes where no road is known [m]."""
AHEAD, FARTHEST_AHEAD = 150.0, 600.0
"""The street leads at least, and at most, so far ahead of the car [m]."""
SECONDS = 20.0
"""It leads as far as the car drives in this time [s]."""
CLOSE, BENT = 5.0, 0.35
"""Waypoints farther apart than this [m] have no bend between them of more than this [rad]."""


class TestedWay(NamedTuple):
    """The way of the tested car."""

    __test__ = False
    strip: Strip
    speed: float
    """Its speed at the start [m/s]."""
    fastest: float
    """It drives no faster [m/s]."""
    notes: list[str]
    """What of its own actions isn't played."""


def tested_way(car: RoadUser, positions: Positions) -> TestedWay:
    """Return the way of the tested car. Raise XoscRefusal if its speed or way can't be read."""
    begin = positions.begin(car.name)
    centre = begin.beside(car.size[2], 0.0)
    line, speeds = _line(car, positions)
    first = _first_speeds(car)
    later = [number(one, "value") for event in car.events for one in event.element.iter("AbsoluteTargetSpeed")]
    speed = first[-1] if first else (speeds[0] if len(speeds) and _at_once(car) else 0.0)
    fastest = max([speed, *later, *speeds.tolist()])
    if fastest <= 0:
        raise XoscRefusal(
            f"{called(car.element)} as {car.name!r}: nothing says how fast it drives; write a SpeedAction"
        )
    notes = [
        f"{called(event.element)} of {car.name} isn't played: the driver under test drives"
        for event in car.events
        if any(one.tag in DRIVING for one in private_actions(event.element))
    ]
    ahead = float(np.clip(fastest * SECONDS, AHEAD, FARTHEST_AHEAD))
    return TestedWay(_strip(car, positions, centre, line, ahead), speed, fastest, notes)


def _first_speeds(car: RoadUser) -> list[float]:
    """Return the speeds that Init gives the car [m/s]. Raise XoscRefusal if it gathers them: drivers do that."""
    changes = [change_of(one, Beginning(Comes.AT_ONCE)) for one in car.first if one.tag == "LongitudinalAction"]
    if any(one.value > 0 for one in changes):
        raise XoscRefusal(
            f"{called(car.element)} as {car.name!r}: its speed in Init is gathered; write dynamicsShape step, and let "
            "the driver under test do the rest"
        )
    return [one.target for one in changes if one.target is not None]


def _at_once(car: RoadUser) -> bool:
    """Return whether the car follows its way from the start on."""
    if any(one.tag == "RoutingAction" for one in car.first):
        return True
    event = next(one for one in car.events if any(kind.tag == "RoutingAction" for _, kind in one.private_actions))
    waits = [one for owner in (event.act, event.element) for one in owner.findall("StartTrigger/*/Condition")]
    times = [one.find("ByValueCondition/SimulationTimeCondition") for one in waits]
    return all(time is not None and number(time, "value") <= 0 for time in times)


def _line(car: RoadUser, positions: Positions) -> tuple[np.ndarray, np.ndarray]:
    """Return the places of the car's centre that its actions name (point, 2) [m], and its speeds there [m/s]."""
    for action in car.actions("RoutingAction"):
        kind = only(action)
        if kind.tag == "FollowTrajectoryAction":
            corners = vertices(kind, positions.catalogs)
            poses = np.array([positions.at(part(one, "Position")) for one in corners])
            return _centres(poses, car.size[2]), _speeds(poses, kind, corners)
        if kind.tag == "AssignRouteAction":
            return _route(positions, car, waypoints(kind, positions.catalogs)), np.zeros(0)
        if kind.tag == "AcquirePositionAction":
            return _on_from(positions, car, points_of(positions, [kind])), np.zeros(0)
    lane = positions.on_lane(positions.begins[car.name])
    if lane is not None:
        return positions.lane_ahead(lane, FARTHEST_AHEAD), np.zeros(0)
    return np.zeros((0, 2)), np.zeros(0)


def _on_from(positions: Positions, car: RoadUser, points: np.ndarray) -> np.ndarray:
    """Return points of a route that lie ahead of the car."""
    begin = positions.begin(car.name)
    ahead = (points - np.array(begin[:2])) @ np.array([np.cos(begin.heading), np.sin(begin.heading)])
    return points[int(np.argmax(ahead > 0.5)) :] if (ahead > 0.5).any() else points[:0]


def _route(positions: Positions, car: RoadUser, stops: list[ET.Element]) -> np.ndarray:
    """Return the points of a route ahead of the car. Raise XoscRefusal if roads lead from one to the next in bends."""
    points = _on_from(positions, car, points_of(positions, stops))
    poses = [positions.at(part(one, "Position")) for one in stops]
    path = np.concatenate([[positions.begin(car.name)[:2]], points])
    for (before, after), pose in zip(pairwise(path), poses[len(poses) - len(points) :], strict=True):
        step = after - before
        turn = np.arctan2(step[1], step[0]) - pose.heading
        on_road = positions.on_lane(part(stops[-1], "Position")) is not None
        if on_road and np.hypot(*step) > CLOSE and abs(np.angle(np.exp(1j * turn))) > BENT:
            raise XoscRefusal("Route: roads lead from one waypoint to the next in a bend; only straight ways are read")
    return points


def _centres(poses: np.ndarray, ahead: float) -> np.ndarray:
    """Return places so far ahead of reference points (point, 3), along their headings [m]."""
    return poses[:, :2] + ahead * np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=1)


def _speeds(poses: np.ndarray, action: ET.Element, corners: list[ET.Element]) -> np.ndarray:
    """Return the speeds between places [m/s]; none where the car's own speed counts."""
    if timing_of(action) is None:
        return np.zeros(0)
    return np.hypot(*np.diff(poses[:, :2], axis=0).T) / np.diff(times_of(corners))


def _strip(car: RoadUser, positions: Positions, centre: Pose, line: np.ndarray, ahead: float) -> Strip:
    """Return the way of the car's centre, straight on beyond the places that are known, and the roadway beside it."""
    start = np.array(centre[:2])
    onward = np.array([np.cos(centre.heading), np.sin(centre.heading)])
    points = [start]
    for point in line:
        step = point - points[-1]
        if np.hypot(*step) > 0.3 and step @ onward > 0:
            points.append(point)
            onward = step / np.hypot(*step)
    length = float(np.hypot(*np.diff(points, axis=0).T).sum()) if len(points) > 1 else 0.0
    points.append(points[-1] + max(ahead - length, 30.0) * onward)
    right, left = LANE_WIDTH / 2, 1.5 * LANE_WIDTH
    lane = positions.on_lane(positions.begins[car.name])
    if lane is not None:
        middle, _ = positions.roads.lane_at(lane.road, lane.lane, lane.s)
        edges = positions.roads.roadway(lane.road, lane.lane, lane.s)
        away = np.array([middle + lane.offset - edges[0], edges[1] - middle - lane.offset])
        right, left = away if positions.roads.direction(lane.road, lane.lane) > 0 else away[::-1]
    return Strip(np.array(points), centre.heading, float(max(right, LANE_WIDTH / 2)), float(max(left, LANE_WIDTH / 2)))
