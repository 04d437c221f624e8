"""An episode as a CommonRoad scenario: lanelets, all road users and parked vehicles as obstacles, the planning problem.

Format: commonroad.in.tum.de, *XML format of scenarios*, version 2020a. Written with the standard library.
"""

from __future__ import annotations

import datetime
import xml.etree.ElementTree as ET

import numpy as np
from jaxtyping import Float

from jaxwalk.formats.commonroad_lanelets import add_lanelets, add_point, decimal
from jaxwalk.formats.paths import Path, paths, standing
from jaxwalk.formats.road_network import RoadNetwork
from jaxwalk.formats.tracks import CAR, Tracks
from jaxwalk.sim.sim_config import SimConfig

FIRST_OBSTACLE, FIRST_PARKED, PROBLEM = 10_000, 15_000, 20_000
"""Ids of the first obstacle, of the first parked vehicle and of the planning problem.

Obstacles follow the order of the table's ids; lanelets have smaller ids.
"""
NOWHERE = {"geoNameId": "-999", "gpsLatitude": "999", "gpsLongitude": "999"}
"""CommonRoad's values for an unknown location."""


def commonroad(
    tracks: Tracks, network: RoadNetwork, *, name: str, config: SimConfig,
    parked: Float[np.ndarray, "vehicle column"],
) -> bytes:  # fmt: skip
    """Return the scenario as an XML document.

    Args:
        tracks: an episode of the simulator, with all road users in every frame.
        network: the roads of its street.
        name: the scenario's source, as a text.
        config: gives the length of a step and the goal distance.
        parked: the boxes of parked vehicles (`jaxwalk.maps.parking_slots.SLOT_COLUMNS`).
    """
    root = ET.Element(
        "commonRoad", commonRoadVersion="2020a", benchmarkID=f"ZAM_Jaxwalk-1_{tracks.episode + 1}_T-1",
        date=datetime.date.today().isoformat(), author="jaxwalk", affiliation="jaxwalk", source=name,
        timeStepSize=decimal(config.dt),
    )  # fmt: skip
    location = ET.SubElement(root, "location")
    for tag, text in NOWHERE.items():
        ET.SubElement(location, tag).text = text
    tags = ET.SubElement(root, "scenarioTags")
    for tag in ("urban", "simulated"):
        ET.SubElement(tags, tag)
    add_lanelets(root, network)
    for number, path in enumerate(standing(parked)):
        _add_parked(root, FIRST_PARKED + number, path)
    everybody = paths(tracks)
    for number, path in enumerate(everybody.values()):
        _add_obstacle(root, FIRST_OBSTACLE + number, path, config.dt)
    car = next(path for path in everybody.values() if path.type == CAR)
    _add_problem(root, car, tracks, config)
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True)


def _add_exact(parent: ET.Element, tag: str, text: str) -> None:
    ET.SubElement(ET.SubElement(parent, tag), "exact").text = text


def _add_obstacle(root: ET.Element, id: int, path: Path, dt: float) -> None:
    """Add a road user with its trajectory."""
    obstacle = ET.SubElement(root, "dynamicObstacle", id=str(id))
    _add_body(obstacle, path.type, path)
    speed = np.hypot(np.gradient(path.x, path.t), np.gradient(path.y, path.t))
    _add_state(ET.SubElement(obstacle, "initialState"), path, 0, speed, dt)
    trajectory = ET.SubElement(obstacle, "trajectory")
    for moment in range(1, len(path.t)):
        _add_state(ET.SubElement(trajectory, "state"), path, moment, speed, dt)


def _add_parked(root: ET.Element, id: int, path: Path) -> None:
    """Add a vehicle that stands."""
    obstacle = ET.SubElement(root, "staticObstacle", id=str(id))
    _add_body(obstacle, "parkedVehicle", path)
    state = ET.SubElement(obstacle, "initialState")
    add_point(ET.SubElement(state, "position"), path.x[0], path.y[0])
    _add_exact(state, "orientation", decimal(path.heading[0]))
    _add_exact(state, "time", "0")


def _add_body(obstacle: ET.Element, type: str, path: Path) -> None:
    ET.SubElement(obstacle, "type").text = type
    rectangle = ET.SubElement(ET.SubElement(obstacle, "shape"), "rectangle")
    for tag, value in (("length", path.length), ("width", path.width)):
        ET.SubElement(rectangle, tag).text = decimal(value)


def _add_state(state: ET.Element, path: Path, moment: int, speed: np.ndarray, dt: float) -> None:
    add_point(ET.SubElement(state, "position"), path.x[moment], path.y[moment])
    _add_exact(state, "orientation", decimal(path.heading[moment]))
    _add_exact(state, "time", str(round(path.t[moment] / dt)))
    _add_exact(state, "velocity", decimal(speed[moment]))


def _add_problem(root: ET.Element, car: Path, tracks: Tracks, config: SimConfig) -> None:
    """Add the car's planning problem: from its start to within the goal distance of its goal, before the horizon."""
    problem = ET.SubElement(root, "planningProblem", id=str(PROBLEM))
    start = ET.SubElement(problem, "initialState")
    add_point(ET.SubElement(start, "position"), car.x[0], car.y[0])
    rows = np.flatnonzero(tracks.type == CAR)
    for tag, value in (
        ("velocity", float(tracks.known["speed"][rows[0]])), ("orientation", car.heading[0]),
        ("yawRate", 0.0), ("slipAngle", 0.0),
    ):  # fmt: skip
        _add_exact(start, tag, decimal(value))
    _add_exact(start, "time", "0")
    goal = ET.SubElement(problem, "goalState")
    time = ET.SubElement(goal, "time")
    for tag, step in (("intervalStart", 0), ("intervalEnd", config.horizon)):
        ET.SubElement(time, tag).text = str(step)
    circle = ET.SubElement(ET.SubElement(goal, "position"), "circle")
    ET.SubElement(circle, "radius").text = decimal(config.goal_distance)
    centre = ET.SubElement(circle, "center")
    for tag, column in (("x", "goal_x"), ("y", "goal_y")):
        ET.SubElement(centre, tag).text = decimal(float(tracks.known[column][rows[0]]))


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
