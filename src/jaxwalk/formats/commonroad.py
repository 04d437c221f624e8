"""An episode as a CommonRoad scenario: lanelets, all road users as obstacles, and the car's planning problem.

Format: commonroad.in.tum.de, *XML format of scenarios*, version 2020a. Written with the standard library.
"""

from __future__ import annotations

import datetime
import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence

import numpy as np

from jaxwalk.formats.paths import Path, paths
from jaxwalk.formats.road_network import Arm, Connection, Rectangle, RoadNetwork
from jaxwalk.formats.tracks import CAR, Tracks
from jaxwalk.sim.sim_config import SimConfig

FIRST_OBSTACLE, PROBLEM = 10_000, 20_000
"""Ids of the first obstacle and of the planning problem. Obstacles follow the order of the table's ids; lanelets have
smaller ids."""
ARC_POINTS = 13
"""Points of each bound of a lanelet that turns."""
NOWHERE = {"geoNameId": "-999", "gpsLatitude": "999", "gpsLongitude": "999"}
"""CommonRoad's values for an unknown location."""

Points = Sequence[tuple[float, float]]


def commonroad(tracks: Tracks, network: RoadNetwork, *, name: str, config: SimConfig) -> bytes:
    """Return the scenario as an XML document.

    Args:
        tracks: an episode of the simulator, with all road users in every frame.
        network: the lanes of its map.
        name: the scenario's source, as a text.
        config: gives the length of a step and the goal distance.
    """
    root = ET.Element(
        "commonRoad", commonRoadVersion="2020a", benchmarkID=f"ZAM_Jaxwalk-1_{tracks.episode + 1}_T-1",
        date=datetime.date.today().isoformat(), author="jaxwalk", affiliation="jaxwalk", source=name,
        timeStepSize=_decimal(config.dt),
    )  # fmt: skip
    location = ET.SubElement(root, "location")
    for tag, text in NOWHERE.items():
        ET.SubElement(location, tag).text = text
    tags = ET.SubElement(root, "scenarioTags")
    for tag in ("urban", "simulated"):
        ET.SubElement(tags, tag)
    _add_lanelets(root, network)
    everybody = paths(tracks)
    for number, path in enumerate(everybody.values()):
        _add_obstacle(root, FIRST_OBSTACLE + number, path, config.dt)
    car = next(path for path in everybody.values() if path.type == CAR)
    _add_problem(root, car, tracks, config)
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True)


def _decimal(value: float | np.floating) -> str:
    """Return a number as text without an exponent, with six decimals at most."""
    return f"{float(value):.6f}".rstrip("0").rstrip(".")


def _add_point(parent: ET.Element, x: float, y: float) -> None:
    point = ET.SubElement(parent, "point")
    for tag, value in (("x", x), ("y", y)):
        ET.SubElement(point, tag).text = _decimal(value)


def _add_exact(parent: ET.Element, tag: str, text: str) -> None:
    ET.SubElement(ET.SubElement(parent, tag), "exact").text = text


def _add_lanelets(root: ET.Element, network: RoadNetwork) -> None:
    """Add two lanelets for every arm, and one for every connection, crosswalk and sidewalk."""
    for number, arm in enumerate(network.arms):
        line = _along(arm)
        for along, id, other in ((True, *_ids(number)), (False, *reversed(_ids(number)))):
            left = line if along else line[::-1]
            lanelet = _add_lanelet(root, id, left, _offset(left, arm.width / 2), "urban")
            _add_links(lanelet, network, number, along)
            ET.SubElement(lanelet, "adjacentLeft", ref=str(other), drivingDir="opposite")
            _add_kind(lanelet, "urban", one_way="vehicle")
    for number, connection in enumerate(network.connections):
        left, right = _bounds(connection)
        lanelet = _add_lanelet(root, _connection_id(network, number), left, right, "intersection")
        from_along = network.arms[connection.incoming].ends[1] == connection.junction
        to_along = network.arms[connection.outgoing].ends[0] == connection.junction
        ET.SubElement(lanelet, "predecessor", ref=str(_ids(connection.incoming)[not from_along]))
        ET.SubElement(lanelet, "successor", ref=str(_ids(connection.outgoing)[not to_along]))
        _add_kind(lanelet, "intersection", one_way="vehicle")
    first = _connection_id(network, len(network.connections))
    areas = [("crosswalk", area) for area in network.crosswalks] + [("sidewalk", area) for area in network.sidewalks]
    for id, (kind, area) in enumerate(areas, start=first):
        lanelet = _add_lanelet(root, id, *_sides(area), kind)
        _add_kind(lanelet, kind, both_ways="pedestrian")


def _ids(arm: int) -> tuple[int, int]:
    """Return the ids of an arm's two lanelets: along the arm, and in the opposite direction."""
    return 1 + 2 * arm, 2 + 2 * arm


def _connection_id(network: RoadNetwork, number: int) -> int:
    return 1 + 2 * len(network.arms) + number


def _add_lanelet(root: ET.Element, id: int, left: Points, right: Points, kind: str) -> ET.Element:
    lanelet = ET.SubElement(root, "lanelet", id=str(id))
    for tag, points in (("leftBound", left), ("rightBound", right)):
        bound = ET.SubElement(lanelet, tag)
        for x, y in points:
            _add_point(bound, x, y)
        ET.SubElement(bound, "lineMarking").text = "unknown" if kind == "urban" else "no_marking"
    return lanelet


def _add_kind(lanelet: ET.Element, kind: str, *, one_way: str | None = None, both_ways: str | None = None) -> None:
    ET.SubElement(lanelet, "laneletType").text = kind
    for tag, user in (("userOneWay", one_way), ("userBidirectional", both_ways)):
        if user is not None:
            ET.SubElement(lanelet, tag).text = user


def _add_links(lanelet: ET.Element, network: RoadNetwork, arm: int, along: bool) -> None:
    """Add the connections that lead into an arm's lane, and those that lead out of it."""
    before, after = network.arms[arm].ends if along else network.arms[arm].ends[::-1]
    numbered = list(enumerate(network.connections))
    into = [n for n, one in numbered if one.outgoing == arm and one.junction == before]
    out = [n for n, one in numbered if one.incoming == arm and one.junction == after]
    for tag, numbers in (("predecessor", into), ("successor", out)):
        for number in numbers:
            ET.SubElement(lanelet, tag, ref=str(_connection_id(network, number)))


def _along(arm: Arm) -> list[tuple[float, float]]:
    """Return the centre line of an arm [m]."""
    cos, sin = math.cos(arm.heading), math.sin(arm.heading)
    return [(arm.x, arm.y), (arm.x + arm.length * cos, arm.y + arm.length * sin)]


def _offset(line: Points, by: float) -> list[tuple[float, float]]:
    """Return a straight line moved to the right by some distance [m]."""
    (x0, y0), (x1, y1) = line
    length = math.hypot(x1 - x0, y1 - y0)
    right = by * (y1 - y0) / length, -by * (x1 - x0) / length
    return [(x + right[0], y + right[1]) for x, y in line]


def _bounds(connection: Connection) -> tuple[Points, Points]:
    """Return the left and right bound of a connection [m]."""
    s = np.linspace(0, connection.length, ARC_POINTS if connection.curvature else 2)
    heading = connection.heading + connection.curvature * s
    if connection.curvature:
        x = connection.x + (np.sin(heading) - math.sin(connection.heading)) / connection.curvature
        y = connection.y - (np.cos(heading) - math.cos(connection.heading)) / connection.curvature
    else:
        x, y = connection.x + s * math.cos(connection.heading), connection.y + s * math.sin(connection.heading)
    width = np.interp(s, [0, connection.length], connection.widths)
    right_x, right_y = x + width * np.sin(heading), y - width * np.cos(heading)
    left, right = (list(zip(a.tolist(), b.tolist(), strict=True)) for a, b in ((x, y), (right_x, right_y)))
    return left, right


def _sides(area: Rectangle) -> tuple[Points, Points]:
    """Return the long sides of a rectangle in one direction [m], the left one first."""
    x0, y0, x1, y1 = area
    if x1 - x0 >= y1 - y0:
        return [(x0, y1), (x1, y1)], [(x0, y0), (x1, y0)]
    return [(x0, y0), (x0, y1)], [(x1, y0), (x1, y1)]


def _add_obstacle(root: ET.Element, id: int, path: Path, dt: float) -> None:
    """Add a road user with its trajectory."""
    obstacle = ET.SubElement(root, "dynamicObstacle", id=str(id))
    ET.SubElement(obstacle, "type").text = path.type
    rectangle = ET.SubElement(ET.SubElement(obstacle, "shape"), "rectangle")
    for tag, value in (("length", path.length), ("width", path.width)):
        ET.SubElement(rectangle, tag).text = _decimal(value)
    speed = np.hypot(np.gradient(path.x, path.t), np.gradient(path.y, path.t))
    _add_state(ET.SubElement(obstacle, "initialState"), path, 0, speed, dt)
    trajectory = ET.SubElement(obstacle, "trajectory")
    for moment in range(1, len(path.t)):
        _add_state(ET.SubElement(trajectory, "state"), path, moment, speed, dt)


def _add_state(state: ET.Element, path: Path, moment: int, speed: np.ndarray, dt: float) -> None:
    _add_point(ET.SubElement(state, "position"), path.x[moment], path.y[moment])
    _add_exact(state, "orientation", _decimal(path.heading[moment]))
    _add_exact(state, "time", str(round(path.t[moment] / dt)))
    _add_exact(state, "velocity", _decimal(speed[moment]))


def _add_problem(root: ET.Element, car: Path, tracks: Tracks, config: SimConfig) -> None:
    """Add the car's planning problem: from its start to within the goal distance of its goal, before the horizon."""
    problem = ET.SubElement(root, "planningProblem", id=str(PROBLEM))
    start = ET.SubElement(problem, "initialState")
    _add_point(ET.SubElement(start, "position"), car.x[0], car.y[0])
    rows = np.flatnonzero(tracks.type == CAR)
    for tag, value in (
        ("velocity", float(tracks.known["speed"][rows[0]])), ("orientation", car.heading[0]),
        ("yawRate", 0.0), ("slipAngle", 0.0),
    ):  # fmt: skip
        _add_exact(start, tag, _decimal(value))
    _add_exact(start, "time", "0")
    goal = ET.SubElement(problem, "goalState")
    time = ET.SubElement(goal, "time")
    for tag, step in (("intervalStart", 0), ("intervalEnd", config.horizon)):
        ET.SubElement(time, tag).text = str(step)
    circle = ET.SubElement(ET.SubElement(goal, "position"), "circle")
    ET.SubElement(circle, "radius").text = _decimal(config.goal_distance)
    centre = ET.SubElement(circle, "center")
    for tag, column in (("x", "goal_x"), ("y", "goal_y")):
        ET.SubElement(centre, tag).text = _decimal(float(tracks.known[column][rows[0]]))


def read_commonroad(document: bytes) -> dict[int, Path]:
    """Return the paths of centres in a document that `commonroad` wrote, by their order."""
    root, found = ET.fromstring(document), {}
    dt = float(root.attrib["timeStepSize"])
    for number, obstacle in enumerate(root.iter("dynamicObstacle")):
        states = [*obstacle.iter("initialState"), *obstacle.iter("state")]

        def column(path: str, states: list[ET.Element] = states) -> np.ndarray:
            return np.array([float(state.findtext(path, "nan")) for state in states])

        found[number] = Path(
            type=obstacle.findtext("type", ""), t=column("time/exact") * dt, x=column("position/point/x"),
            y=column("position/point/y"), heading=column("orientation/exact"),
            length=float(obstacle.findtext("shape/rectangle/length", "nan")),
            width=float(obstacle.findtext("shape/rectangle/width", "nan")),
        )  # fmt: skip
    return found
