"""Episodes for other simulators: valid by the formats' schemas, and read back to where everybody was."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest

from formats.schemas import valid
from jaxwalk.formats.commonroad import commonroad, read_commonroad
from jaxwalk.formats.openscenario import openscenario, read_openscenario
from jaxwalk.formats.paths import Path, largest_error, paths
from jaxwalk.sim.sim_config import SimConfig

CONFIG = SimConfig()
CENTIMETRE = 0.01
PARKED = np.array([[20.0, 50.0, 1.0, 0.0, 2.2, 0.9], [30.0, 51.0, 0.0, -1.0, 2.2, 0.7]])
"""One that points east, and a narrower one that points south."""


@pytest.fixture(scope="module")
def scenario(episodes):
    """The collision of a turning car."""
    return max((one for one in episodes if one.known["ending"][0] == "collision"), key=lambda one: np.ptp(one.heading))


@pytest.fixture(scope="module")
def osc(scenario):
    return openscenario(scenario, name="a collision", road_file="map.xodr", config=CONFIG, parked=PARKED[:0])


@pytest.fixture(scope="module")
def common(scenario, road_plan):
    return commonroad(scenario, road_plan, name="a collision", config=CONFIG, parked=PARKED[:0])


def test_openscenario_is_valid_and_says_where_everybody_was(osc, scenario):
    assert valid(osc, "OpenSCENARIO_1_2.xsd") == []
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


def test_lanelets_hang_together(common, road_plan):
    lanelets = {one.get("id"): one for one in ET.fromstring(common).iter("lanelet")}
    street = road_plan.network
    crosswalks = sum(area.kind == "crosswalk" for area in street.areas)
    crossed = sum(len(crossing.nodes) - 1 for crossing in street.crossings)
    assert len(lanelets) == len(street.lanes) + crosswalks + len(street.walk.edges) - crossed

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
    assert links == 2 * sum(len(lane.successors) for lane in street.lanes)


def test_lanelets_beside_each_other_share_a_bound(common, road_plan):
    lanelets = {one.get("id"): one for one in ET.fromstring(common).iter("lanelet")}

    def ends(one, side):
        points = one.findall(f"{side}/point")
        return [(float(x.findtext("x")), float(x.findtext("y"))) for x in (points[0], points[-1])]

    tags = ("adjacentLeft", "adjacentRight")
    beside = [(one, x) for one in lanelets.values() for tag in tags for x in one.findall(tag)]
    assert len(beside) > 6
    for one, link in beside:
        side = "leftBound" if link.tag == "adjacentLeft" else "rightBound"
        opposite = link.get("drivingDir") == "opposite"
        there = side if opposite else {"leftBound": "rightBound", "rightBound": "leftBound"}[side]
        other = ends(lanelets[link.get("ref")], there)[:: -1 if opposite else 1]
        assert np.allclose(ends(one, side), other, atol=0.1)


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


def test_parked_vehicles_are_static_obstacles_in_commonroad(scenario, road_plan, common):
    root = ET.fromstring(commonroad(scenario, road_plan, name="parked", config=CONFIG, parked=PARKED))
    obstacles = root.findall("staticObstacle")
    places = [
        [
            float(one.findtext(f"initialState/{tag}"))
            for tag in ("position/point/x", "position/point/y", "orientation/exact")
        ]
        for one in obstacles
    ]
    np.testing.assert_allclose(places, [[20, 50, 0], [30, 51, -math.pi / 2]], atol=1e-6)
    sizes = [[float(one.findtext(f"shape/rectangle/{tag}")) for tag in ("length", "width")] for one in obstacles]
    np.testing.assert_allclose(sizes, [[4.4, 1.8], [4.4, 1.4]])
    assert {one.findtext("type") for one in obstacles} == {"parkedVehicle"}
    ids = [one.get("id") for one in root if one.get("id")]
    assert len(set(ids)) == len(ids)
    order = [one.tag for one in root]
    assert order.index("lanelet") < order.index("staticObstacle") < order.index("dynamicObstacle"), (
        "as the schema has it"
    )
    assert not ET.fromstring(common).findall("staticObstacle")


def test_parked_vehicles_stand_in_openscenario(scenario):
    document = openscenario(scenario, name="parked", road_file="map.xodr", config=CONFIG, parked=PARKED)
    assert valid(document, "OpenSCENARIO_1_2.xsd") == []
    assert largest_error(paths(scenario), read_openscenario(document)) < 1e-6
    root = ET.fromstring(document)
    bodies = {one.get("name"): one for one in root.iter("ScenarioObject")}
    assert [name for name in bodies if name.startswith("parked")] == ["parked0", "parked1"]
    starts = {one.get("entityRef"): next(one.iter("WorldPosition")) for one in root.iter("Private")}
    for number, (x, y, width) in enumerate(((20, 50, 1.8), (30, 51, 1.4))):
        place, body = starts[f"parked{number}"], bodies[f"parked{number}"]
        rear, centre = (float(place.get("x")), float(place.get("y"))), float(next(body.iter("Center")).get("x"))
        heading = float(place.get("h"))
        assert rear[0] + centre * math.cos(heading) == pytest.approx(x)
        assert rear[1] + centre * math.sin(heading) == pytest.approx(y)
        assert float(next(body.iter("Dimensions")).get("width")) == pytest.approx(width)
    assert not [one for one in root.iter("EntityRef") if one.get("entityRef").startswith("parked")], "nobody moves them"
