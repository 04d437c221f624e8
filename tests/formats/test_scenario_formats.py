"""Episodes for other simulators: valid by the formats' schemas, and read back to where everybody was."""

from __future__ import annotations

import math
import sys
import tomllib
import xml.etree.ElementTree as ET
from dataclasses import replace
from importlib import resources
from importlib.metadata import files

import numpy as np
import pytest
import xmlschema

from jaxwalk.formats.commonroad import commonroad, read_commonroad
from jaxwalk.formats.opendrive import opendrive
from jaxwalk.formats.openscenario import openscenario, read_openscenario
from jaxwalk.formats.paths import Path, largest_error, paths
from jaxwalk.formats.road_network import EAST, NORTH, Arm, road_network
from jaxwalk.formats.tracks import TracksError
from jaxwalk.maps import load_map
from jaxwalk.sim.sim_config import SimConfig
from sim.maps import turned, write

CONFIG = SimConfig()
CENTIMETRE = 0.01


@pytest.fixture(scope="module")
def network(road_map):
    return road_network(road_map)


@pytest.fixture(scope="module")
def drive(network):
    return opendrive(network, "paper")


@pytest.fixture(scope="module")
def scenario(episodes):
    """The collision of a turning car."""
    return max((one for one in episodes if one.known["ending"][0] == "collision"), key=lambda one: np.ptp(one.heading))


@pytest.fixture(scope="module")
def osc(scenario):
    return openscenario(scenario, name="a collision", road_file="map.xodr", config=CONFIG)


@pytest.fixture(scope="module")
def common(scenario, network):
    return commonroad(scenario, network, name="a collision", config=CONFIG)


def _valid(document, schema):
    """What is wrong with a document by a schema that comes with scenariogeneration."""
    (path,) = (file.locate() for file in files("scenariogeneration") or () if file.name == schema)
    return [error.reason for error in xmlschema.XMLSchema(str(path)).iter_errors(ET.fromstring(document))]


def test_lanes_of_the_papers_map(network):
    assert [(one.x, one.y, one.reach) for one in network.junctions] == [(56, 56, 6), (56, 86, 6)], "up to crosswalks"
    arms = [(arm.x, arm.y, arm.heading, arm.length, arm.width, arm.ends) for arm in network.arms]
    assert sorted(arms, key=repr) == sorted(
        [
            (0, 56, EAST, 50, 8, (None, 0)),
            (62, 56, EAST, 58, 8, (0, None)),
            (56, 0, NORTH, 50, 8, (None, 0)),
            (56, 62, NORTH, 18, 8, (0, 1)),
            (56, 92, NORTH, 28, 8, (1, None)),
            (62, 86, EAST, 58, 8, (1, None)),
        ],
        key=lambda arm: repr((*map(float, arm[:5]), arm[5])),
    )
    assert len(network.connections) == 4 * 3 + 3 * 2
    assert network.bounds() == (0, 0, 120, 120)
    turns = sorted(round(one.curvature, 3) for one in network.connections if one.junction == 1)
    assert turns == [-0.167, -0.167, 0, 0, 0.167, 0.167]


def test_a_turned_map_has_turned_lanes(network, tmp_path):
    table = tomllib.loads(resources.files("jaxwalk.maps").joinpath("paper.toml").read_text())
    other = road_network(load_map(write(tmp_path / "turned.toml", turned(table))))
    assert {(one.x, one.y, one.reach) for one in other.junctions} == {(64, 56, 6), (34, 56, 6)}
    assert sorted(arm.length for arm in other.arms) == sorted(arm.length for arm in network.arms)
    lengths = sorted((one.length, one.curvature) for one in network.connections)
    assert sorted((one.length, one.curvature) for one in other.connections) == lengths
    assert _valid(opendrive(other, "turned"), "opendrive_17_core.xsd") == []


def test_a_road_that_meets_no_other(road_map):
    alone = road_network(replace(road_map, roads=road_map.roads[:1]))
    assert alone.arms == (Arm(0.0, 56.0, EAST, 120.0, 8.0, (None, None)),)
    assert (alone.junctions, alone.connections) == ((), ())
    assert opendrive(alone, "one road").count(b"<road ") == 1


def test_no_room_for_a_junction(road_map):
    crosswalks = np.array([[58, 52, 60, 60]], np.float32)
    with pytest.raises(TracksError, match=r"the junction at \(56, 56\) has no room"):
        road_network(replace(road_map, crosswalks=crosswalks))


def test_opendrive_is_valid(drive):
    assert _valid(drive, "opendrive_17_core.xsd") == []
    header = ET.fromstring(drive).find("header")
    assert [float(header.get(side)) for side in ("north", "south", "east", "west")] == [120, 0, 120, 0]
    assert _valid(drive.replace(b'type="driving"', b'type="flying"', 1), "opendrive_17_core.xsd"), "it can fail"


def _ends(road):
    """Where an OpenDRIVE road of one line or arc begins and ends: x, y, heading."""
    geometry = road.find("planView/geometry")
    x, y, heading, length = (float(geometry.get(name)) for name in ("x", "y", "hdg", "length"))
    arc = geometry.find("arc")
    if arc is None:
        return (x, y, heading), (x + length * math.cos(heading), y + length * math.sin(heading), heading)
    curvature = float(arc.get("curvature"))
    end = heading + curvature * length
    dx, dy = math.sin(end) - math.sin(heading), math.cos(heading) - math.cos(end)
    return (x, y, heading), (x + dx / curvature, y + dy / curvature, end)


def test_roads_through_junctions_meet_their_arms(drive):
    roads = {road.get("id"): road for road in ET.fromstring(drive).iter("road")}
    through = [road for road in roads.values() if road.get("junction") != "-1"]
    assert len(through) == 18
    for road in through:
        for end, link in zip(_ends(road), ("predecessor", "successor"), strict=True):
            arm = road.find(f"link/{link}")
            at_end = arm.get("contactPoint") == "end"
            x, y, heading = _ends(roads[arm.get("elementId")])[at_end]
            against = at_end == (link == "successor")
            assert math.hypot(x - end[0], y - end[1]) < CENTIMETRE
            assert abs(math.remainder(heading + math.pi * against - end[2], 2 * math.pi)) < 1e-6
            lane = int(road.find(f"lanes/laneSection/right/lane/link/{link}").get("id"))
            assert lane == (1 if against else -1), "right-hand traffic"


def test_crosswalks_are_where_the_map_has_them(drive, road_map):
    found = []
    for road in ET.fromstring(drive).iter("road"):
        (x, y, heading), _ = _ends(road)
        for one in road.iter("object"):
            s, t = float(one.get("s")), float(one.get("t"))
            corners = [(s + float(c.get("u")), t + float(c.get("v"))) for c in one.iter("cornerLocal")]
            cos, sin = math.cos(heading), math.sin(heading)
            points = np.array([(x + a * cos - b * sin, y + a * sin + b * cos) for a, b in corners])
            found.append([*points.min(axis=0), *points.max(axis=0)])
    assert np.allclose(sorted(found), sorted(road_map.crosswalks.tolist()), atol=CENTIMETRE)


def test_openscenario_is_valid_and_says_where_everybody_was(osc, scenario):
    assert _valid(osc, "OpenSCENARIO_1_2.xsd") == []
    assert largest_error(paths(scenario), read_openscenario(osc)) < 1e-6
    root = ET.fromstring(osc)
    assert root.find("RoadNetwork/LogicFile").get("filepath") == "map.xodr"
    assert len(root.findall("Entities/ScenarioObject")) == 13
    vertex = next(root.iter("Vertex")).find("Position/WorldPosition")
    car = paths(scenario)[0]
    behind = car.x[0] - 1.25 * math.cos(car.heading[0]), car.y[0] - 1.25 * math.sin(car.heading[0])
    assert (float(vertex.get("x")), float(vertex.get("y"))) == pytest.approx(behind), "the rear axle's place"


def test_commonroad_says_where_everybody_was(common, scenario):
    copy = read_commonroad(common)
    assert largest_error(paths(scenario), copy) < 1e-5
    assert [one.type for one in copy.values()] == ["car"] + ["pedestrian"] * 12
    assert (copy[0].length, copy[0].width) == (4.5, 1.8)
    root = ET.fromstring(common)
    centre = root.find("planningProblem/goalState/position/circle/center")
    goal = scenario.known["goal_x"][0], scenario.known["goal_y"][0]
    assert (float(centre.findtext("x")), float(centre.findtext("y"))) == pytest.approx(goal, abs=1e-5)


def test_lanelets_hang_together(common, network):
    lanelets = {one.get("id"): one for one in ET.fromstring(common).iter("lanelet")}
    assert len(lanelets) == 2 * 6 + 18 + len(network.crosswalks) + len(network.sidewalks)

    def bound(one, side, end):
        point = one.findall(f"{side}/point")[end]
        return float(point.findtext("x")), float(point.findtext("y"))

    links = 0
    for one in lanelets.values():
        for end, link, other_end in ((-1, "successor", 0), (0, "predecessor", -1)):
            for other in (lanelets[ref.get("ref")] for ref in one.findall(link)):
                links += 1
                for side in ("leftBound", "rightBound"):
                    assert math.dist(bound(one, side, end), bound(other, side, other_end)) < CENTIMETRE
        (lx, ly), (rx, ry), (ax, ay) = (
            bound(one, "leftBound", 0),
            bound(one, "rightBound", 0),
            bound(one, "leftBound", 1),
        )
        assert (ax - lx) * (ry - ly) - (ay - ly) * (rx - lx) < 0, "the right bound lies to the right"
    assert links == 4 * 18


def test_states_count_on_from_the_initial_one(common, scenario):
    frames = int((scenario.id == 0).sum())
    for obstacle in ET.fromstring(common).iter("dynamicObstacle"):
        times = [int(one.text) for one in obstacle.findall(".//time/exact")]
        assert times == list(range(frames))


def test_errors_are_found(scenario):
    original = paths(scenario)
    car = original[0]
    assert largest_error(original, original) == 0
    assert largest_error(original, original | {0: replace(car, x=car.x + 0.03, y=car.y - 0.04)}) == pytest.approx(0.05)
    assert largest_error(original, original | {0: replace(car, t=car.t + 1)}) == math.inf
    assert largest_error(original, {0: car}) == math.inf
    corner = Path(
        "car", np.array([0.0, 1.0, 2.0]), np.array([0.0, 4.0, 4.0]), np.array([0.0, 0.0, 3.0]), np.zeros(3), 4.5, 1.8
    )
    cut = replace(corner, t=corner.t[::2], x=corner.x[::2], y=corner.y[::2], heading=corner.heading[::2])
    assert largest_error({0: corner}, {0: cut}) == pytest.approx(2.5), "half way between (0, 0) and (4, 3)"


def test_without_the_library_the_message_names_the_extra(network, monkeypatch):
    monkeypatch.setitem(sys.modules, "scenariogeneration", None)
    with pytest.raises(TracksError, match=r"jaxwalk\[scenarios\]"):
        opendrive(network, "paper")
