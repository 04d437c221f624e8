"""Roads for other simulators: valid by the schema of OpenDRIVE, and where the street has its lanes."""

from __future__ import annotations

import math
import re
import sys
import tomllib
import xml.etree.ElementTree as ET
from dataclasses import replace
from importlib import resources

import numpy as np
import pytest
import shapely

from formats.schemas import valid
from jaxwalk.formats.opendrive import opendrive
from jaxwalk.formats.road_network import Connection, _ways, road_network
from jaxwalk.formats.tracks import TracksError
from jaxwalk.maps import load_network
from jaxwalk.sim.sim_config import SimConfig
from maps.networks import bend
from sim.maps import turned, write

CONFIG = SimConfig()
CENTIMETRE = 0.01


@pytest.fixture(scope="module")
def drive(road_plan):
    return opendrive(road_plan, "a street")


def test_roads_of_the_papers_map():
    papers = road_network(load_network("paper"))
    lengths = [[round(_length(papers, lane), 2) for lane in (*x.along, *x.against)] for x in papers.roads]
    assert sorted(lengths) == [[16], [17], [27], [28], *2 * [[49, 49]], *2 * [[57, 57]]]
    assert papers.junction.max() == 1
    assert len(papers.connections) == 4 * 3 + 3 * 2


def _length(roads, lane):
    return roads.network.lanes[lane].length()


def test_a_turned_map_has_turned_roads(tmp_path):
    table = tomllib.loads(resources.files("jaxwalk.maps").joinpath("paper.toml").read_text())
    papers = road_network(load_network("paper"))
    other = road_network(load_network(write(tmp_path / "turned.toml", turned(table))))
    assert len(other.roads) == len(papers.roads)
    lengths = [
        sorted(round(_length(x, lane), 3) for way in x.connections for lane in way.lanes) for x in (papers, other)
    ]
    assert lengths[0] == lengths[1]
    assert valid(opendrive(other, "turned"), "opendrive_17_core.xsd") == []


def test_a_bend_that_meets_no_other_road():
    alone = road_network(bend())
    assert [(x.along, x.against) for x in alone.roads] == [((0,), (1,))]
    assert (alone.junction.max(), alone.connections) == (-1, ())
    document = opendrive(alone, "one road")
    assert document.count(b"<road ") == 1 and document.count(b"<paramPoly3") > 20
    (road,) = ET.fromstring(document).iter("road")
    assert float(road.get("length")) == pytest.approx(50 * math.pi / 2, abs=0.03), "half-way between the lanes"


def test_a_lane_that_forks_into_the_ends_of_the_street_is_refused():
    one, _ = bend().lanes
    half = len(one.line) // 2
    lanes = (replace(one, line=one.line[: half + 1], successors=(1, 2)), *2 * [replace(one, line=one.line[half:])])
    with pytest.raises(TracksError, match=r"lanes\[0\] forks into a lane that ends the street"):
        road_network(replace(bend(), lanes=lanes))


def test_lanes_that_lead_to_different_roads_at_one_place_are_refused():
    """The street is cut in its middle; beyond it, only the way back is cut once more."""
    whole, other = bend().lanes
    line, back = whole.line, other.line[::-1]
    cut, later = len(line) // 2, 3 * len(line) // 4
    lanes = (
        replace(whole, line=line[: cut + 1], successors=(1,)), replace(whole, line=line[cut:]),
        replace(other, line=back[: cut + 1][::-1]), replace(other, line=back[cut : later + 1][::-1], successors=(2,)),
        replace(other, line=back[later:][::-1], successors=(3,)),
    )  # fmt: skip
    with pytest.raises(TracksError, match=r"lanes \[0, 2\] lead to different roads at one place: cut them at the same"):
        opendrive(road_network(replace(bend(), lanes=lanes)), "uneven")


def test_a_way_through_a_junction_uses_each_of_its_lanes_once():
    """Lanes 1 and 2 of the junction lead round to each other; lane 3 leads out of it."""
    lane = bend().lanes[0]
    lanes = tuple(replace(lane, successors=after) for after in ((1,), (2, 3), (1,), ()))
    ways = _ways(replace(bend(), lanes=lanes), np.array([-1, 0, 0, -1]), 0)
    assert list(ways) == [Connection(junction=0, incoming=0, outgoing=3, lanes=(1,))]


def test_opendrive_is_valid(drive, road_plan):
    assert valid(drive, "opendrive_17_core.xsd") == []
    header = ET.fromstring(drive).find("header")
    width, height = road_plan.network.size
    assert [float(header.get(side)) for side in ("north", "south", "east", "west")] == [height, 0, width, 0]
    assert valid(drive.replace(b'type="driving"', b'type="flying"', 1), "opendrive_17_core.xsd"), "it can fail"


def test_a_document_is_the_same_each_time(drive, road_plan):
    one, other = (re.sub(rb' date="[^"]*"', b"", x, count=1) for x in (drive, opendrive(road_plan, "a street")))
    assert one == other


def _line(road):
    """An OpenDRIVE road's line, read as the standard says: x, y and heading of many points."""
    found = []
    for geometry in road.iter("geometry"):
        x, y, heading, length = (float(geometry.get(name)) for name in ("x", "y", "hdg", "length"))
        cubic, share = geometry.find("paramPoly3"), np.linspace(0, 1, 21)
        if cubic is None:
            u, v, du, dv = length * share, 0 * share, 1 + 0 * share, 0 * share
        else:
            assert cubic.get("pRange") == "normalized"
            ahead, aside = (np.polynomial.Polynomial([float(cubic.get(k + axis)) for k in "abcd"]) for axis in "UV")
            u, v, du, dv = (curve(share) for curve in (ahead, aside, ahead.deriv(), aside.deriv()))
            assert np.hypot(np.diff(u), np.diff(v)).sum() == pytest.approx(length, abs=1e-3)
        cos, sin = math.cos(heading), math.sin(heading)
        found.append(np.stack([x + cos * u - sin * v, y + sin * u + cos * v, heading + np.arctan2(dv, du)], axis=1))
    return np.concatenate(found)


def _beside(line, lanes, number):
    """The left edge of an OpenDRIVE lane in its direction of travel."""
    inward = [n for n in lanes if n * number > 0 and abs(n) < abs(number)]
    aside = math.copysign(sum(lanes[n] for n in inward), number)
    x, y, heading = line.T
    edge = np.stack([x - aside * np.sin(heading), y + aside * np.cos(heading), heading], axis=1)
    return edge if number < 0 else edge[::-1] + np.array([0, 0, math.pi])


def _widths(road):
    """The width of each lane of an OpenDRIVE road at its begin, by number."""
    lanes = [lane for side in ("left", "right") for lane in road.findall(f".//{side}/lane")]
    return {int(lane.get("id")): float(lane.find("width").get("a")) for lane in lanes}


def test_lines_are_smooth_and_lie_beside_the_lanes(drive, road_plan):
    roads = {road.get("id"): road for road in ET.fromstring(drive).iter("road")}
    for number, road in enumerate(road_plan.roads):
        lines = {lane: _beside(_line(roads[str(number)]), _widths(roads[str(number)]), road.number(lane))
                 for lane in road.along + road.against}  # fmt: skip
        for lane, line in lines.items():
            middle = shapely.LineString(road_plan.network.lanes[lane].line)
            half = road_plan.network.lanes[lane].width / 2
            assert np.abs(shapely.distance(middle, shapely.points(line[:, :2])) - half).max() < 2 * CENTIMETRE
            begin = road_plan.network.lanes[lane].line[0] - line[0, :2]
            assert math.sin(line[0, 2]) * begin[0] - math.cos(line[0, 2]) * begin[1] == pytest.approx(half, abs=0.02)
    for road in roads.values():
        line = _line(road)
        assert np.abs(np.angle(np.exp(1j * np.diff(line[:, 2])))).max() < 0.1
        assert np.hypot(*np.diff(line[:, :2], axis=0).T)[20::21].max(initial=0) < 1e-3, "pieces meet"


def test_ways_through_junctions_meet_their_roads(drive, road_plan):
    roads = {road.get("id"): road for road in ET.fromstring(drive).iter("road")}
    through = [road for road in roads.values() if road.get("junction") != "-1"]
    assert len(through) == len(road_plan.connections) > 10
    for road in through:
        line = _line(road)
        for at, link in ((0, "predecessor"), (-1, "successor")):
            other = road.find(f"link/{link}")
            lane = int(road.find(f"lanes/laneSection/right/lane/link/{link}").get("id"))
            at_end = other.get("contactPoint") == "end"
            assert at_end == ((lane < 0) == (link == "predecessor")), "right-hand traffic"
            beside = roads[other.get("elementId")]
            edge = _beside(_line(beside), _widths(beside), lane)[-1 if link == "predecessor" else 0]
            assert math.dist(edge[:2], line[at, :2]) < CENTIMETRE
            assert abs(math.remainder(edge[2] - line[at, 2], 2 * math.pi)) < 1e-3


def test_junctions_and_roads_know_each_other(drive):
    root = ET.fromstring(drive)
    through = {road.get("id"): road for road in root.iter("road") if road.get("junction") != "-1"}
    for junction in root.iter("junction"):
        for link in junction.iter("connection"):
            road = through.pop(link.get("connectingRoad"))
            assert road.get("junction") == junction.get("id")
            assert road.find("link/predecessor").get("elementId") == link.get("incomingRoad")
    assert not through
    ends = {x.get("elementId") for road in root.iter("road") for x in road.findall("link/*")
            if x.get("elementType") == "junction"}  # fmt: skip
    assert ends == {junction.get("id") for junction in root.iter("junction")}


def test_roads_that_follow_each_other_are_linked():
    """A raised crosswalk has a speed limit of its own, so it is a road between two others."""
    whole, other = bend().lanes
    line, back = whole.line, other.line[::-1]
    cut = len(line) // 2
    lanes = (
        replace(whole, line=line[: cut + 1], successors=(1,)), replace(whole, line=line[cut:]),
        replace(other, line=back[cut:][::-1], successors=(3,)), replace(other, line=back[: cut + 1][::-1]),
    )  # fmt: skip
    roads = list(ET.fromstring(opendrive(road_network(replace(bend(), lanes=lanes)), "two")).iter("road"))
    assert len(roads) == 2
    links = [[(x.tag, x.get("elementId"), x.get("contactPoint")) for x in road.findall("link/*")] for road in roads]
    assert links == [[("successor", "1", "start")], [("predecessor", "0", "end")]]
    for road, name in zip(roads, ("successor", "predecessor"), strict=True):
        found = [(lane.get("id"), x.tag, x.get("id")) for lane in road.iter("lane") for x in lane.findall("link/*")]
        assert found == [("1", name, "1"), ("-1", name, "-1")]


def test_crosswalks_islands_parking_strips_and_buildings_are_where_the_street_has_them(drive, road_plan):
    kinds = {"crosswalk": "crosswalk", "trafficIsland": "island", "parkingSpace": "parking", "building": "building"}
    found = {kind: [] for kind in kinds.values()}
    for road in ET.fromstring(drive).iter("road"):
        points = _line(road)
        metres = np.concatenate([[0], np.hypot(*np.diff(points[:, :2], axis=0).T).cumsum()])
        for one in road.iter("object"):
            s, t = float(one.get("s")), float(one.get("t"))
            x, y = (np.interp(s, metres, points[:, k]) for k in (0, 1))
            heading = np.interp(s, metres, np.unwrap(points[:, 2]))
            u, v = np.array([(float(c.get("u")), t + float(c.get("v"))) for c in one.iter("cornerLocal")]).T
            cos, sin = math.cos(heading), math.sin(heading)
            shape = shapely.Polygon(np.stack([x + cos * u - sin * v, y + sin * u + cos * v], axis=1))
            found[kinds[one.get("type")]].append(shape)
    for kind, shapes in found.items():
        there = road_plan.network.surface(kind)
        assert len(shapes) == sum(area.kind == kind for area in road_plan.network.areas)
        assert shapely.union_all(shapes).symmetric_difference(there).buffer(-3 * CENTIMETRE).is_empty


def test_without_the_library_the_message_names_the_extra(road_plan, monkeypatch):
    monkeypatch.setitem(sys.modules, "scenariogeneration", None)
    with pytest.raises(TracksError, match=r"jaxwalk\[scenarios\]"):
        opendrive(road_plan, "paper")
