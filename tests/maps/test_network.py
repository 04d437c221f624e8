"""A street as plain data: the paper's map as one, its file, and every kind of wrong one."""

import re
import time
from dataclasses import replace
from functools import reduce

import numpy as np
import pytest

from jaxwalk.maps import MapError, load_map
from jaxwalk.maps.check_network import network_faults
from jaxwalk.maps.file import parse
from jaxwalk.maps.map_network import network_of
from jaxwalk.maps.map_reading import map_content
from jaxwalk.maps.network import Area, Lane, LaneRoute, WalkGraph, along, corners
from jaxwalk.maps.network_file import network_text, parse_network
from jaxwalk.maps.network_routes import sampled_route
from jaxwalk.maps.network_zones import ZoneLines
from maps.networks import CENTRE, CROSSWALK, FIRST, LAST, PIECES, arc, bend, island, ring, turned

DISTANCES = {"goal_spacing": 20.0, "start_clearance": 10.0}


@pytest.fixture(scope="module")
def paper():
    return network_of(parse(map_content("paper"), "paper"))


def test_the_papers_map_is_a_network_without_faults(paper):
    assert network_faults(paper, **DISTANCES) == []
    kinds = [area.kind for area in paper.areas]
    assert [kinds.count(kind) for kind in ("roadway", "sidewalk", "crosswalk")] == [3, 20, 6]
    assert (len(paper.walk.nodes), paper.walk.waypoints, len(paper.crossings), len(paper.routes)) == (40, 34, 6, 90)
    assert paper.surface("roadway").area == 3 * 8 * 120 / 3 * 2 + 60 * 8 - 64  # two roads of 120 m, one of 60 m


def test_its_routes_are_those_of_the_map(paper):
    """An arc of 5 m with a point every 0.1 m is 1 mm shorter than the circle's."""
    world = load_map("paper")
    for number, route in enumerate(paper.routes):
        found = sampled_route(paper, route, 320)
        assert found.length == pytest.approx(world.route_length[number], abs=2e-3)
        there = np.stack([world.route_x[number], world.route_y[number]], axis=1)
        facing = np.stack([world.route_cos[number], world.route_sin[number]], axis=1)
        np.testing.assert_allclose(found.points, there, atol=2e-3)
        np.testing.assert_allclose(found.tangents, facing, atol=0.02)


def test_its_lanes_lead_on_or_end_at_the_edge(paper):
    ends = {tuple(lane.line[-1].round(6)) for lane in paper.lanes if not lane.successors}
    assert ends == {(120, 54), (0, 58), (58, 120), (54, 0), (120, 84)}
    assert all(lane.width == 4 for lane in paper.lanes)


def test_a_file_gives_the_same_numbers_again(paper):
    for network in (paper, bend()):
        text = network_text(network)
        again = parse_network(text, "again")
        assert network_text(again) == text
        np.testing.assert_array_equal(again.walk.nodes, network.walk.nodes)
        np.testing.assert_array_equal(again.lanes[0].line, network.lanes[0].line)


def test_a_bend_has_no_faults_however_it_lies():
    for angle in (0.0, 0.4, 2.0):
        assert network_faults(turned(bend(), angle)[0], **DISTANCES) == []


def test_places_of_a_bent_zone_face_each_other():
    """The middle of the street is half-way between radii of 45 m and 55 m; 16 pieces of 0.05 rad."""
    network = bend()
    lines = ZoneLines.of(network, network.crossings[0].zone)
    chord = 2 * 50 * np.sin(0.025)
    assert lines.length == pytest.approx(PIECES * chord)
    for side, radius in enumerate((45, 55)):
        place = lines.at(side, 2 * chord)
        np.testing.assert_allclose(place, CENTRE + radius * np.array([np.cos(-0.4), np.sin(-0.4)]), atol=1e-9)
        half = lines.at(side, chord / 2)
        np.testing.assert_allclose(half, arc(radius, CROSSWALK, CROSSWALK + 0.05, 1).mean(axis=0), atol=1e-9)


def test_a_route_by_hand():
    """Down 10 m, then left along a quarter of a circle of 6 m: 3 pi metres."""
    angle = np.linspace(np.pi, 1.5 * np.pi, 91)
    quarter = np.stack([16 + 6 * np.cos(angle), 10 + 6 * np.sin(angle)], axis=1)
    lanes = (Lane([[10, 20], [10, 10]], 4, 13.9, (1,)), Lane(quarter, 4, 8.3))
    network = replace(bend(), lanes=lanes)
    found = sampled_route(network, LaneRoute((0, 1), 2.0, 3 * np.pi), 37)
    assert found.length == pytest.approx(8 + 3 * np.pi, abs=1e-3)
    np.testing.assert_allclose(found.points[:2], [(10, 18), (10, 17.5)])
    np.testing.assert_allclose(found.tangents[:2], [(0, -1), (0, -1)], atol=1e-9)
    turn = (20 * 0.5 - 8) / 6  # after 10 m
    np.testing.assert_allclose(found.points[20], (16 - 6 * np.cos(turn), 10 - 6 * np.sin(turn)), atol=1e-3)
    np.testing.assert_allclose(found.tangents[20], (np.sin(turn), -np.cos(turn)), atol=1e-3)
    np.testing.assert_allclose(found.limits, [13.9] * 16 + [8.3] * 21)  # 8 m on the first lane
    past = 36 * 0.5 - found.length
    np.testing.assert_allclose(found.points[-1], (16 + past, 4), atol=0.01)  # the last piece leads half a degree down
    assert len(sampled_route(network, LaneRoute((0, 1), 2.0, 3 * np.pi)).points) == 35  # 0, 0.5, ... 17 m of 17.42 m


def test_along_a_line():
    np.testing.assert_array_equal(along(np.array([(0, 0), (3, 4), (3, 10)])), [0, 5, 11])


def changed(part, number, **values):
    """A change of one lane, area, crossing or route."""

    def change(network):
        parts = list(getattr(network, part))
        parts[number] = replace(parts[number], **values)
        return replace(network, **{part: tuple(parts)})

    return change


def zone(**values):
    """A change of the jaywalk zone."""
    return lambda n: changed("crossings", 0, zone=replace(n.crossings[0].zone, **values))(n)


def nodes(number, place):
    """A change of one node."""

    def change(network):
        moved = network.walk.nodes.copy()
        moved[number] = place
        return replace(network, walk=replace(network.walk, nodes=moved))

    return change


def edges(*more, without=()):
    """A change of the edges."""

    def change(network):
        kept = [edge for edge in network.walk.edges.tolist() if tuple(edge) not in without]
        return replace(network, walk=replace(network.walk, edges=np.array([*kept, *more])))

    return change


def areas(*more):
    """Areas more."""
    return lambda network: replace(network, areas=(*network.areas, *more))


def waypoints(count):
    """Another number of waypoints."""
    return lambda network: replace(network, walk=replace(network.walk, waypoints=count))


def both(*changes):
    """Several changes, one after the other."""
    return lambda network: reduce(lambda made, change: change(made), changes, network)


BOW_TIE = [[1, 1], [5, 5], [5, 1], [1, 5]]
EACH = len(bend().walk.nodes) // 2
MIDDLE = 2 * EACH
BACK = Lane(arc(52, LAST, FIRST), 4, 8.33)
ON_ONE_SIDE = both(
    nodes(MIDDLE, arc(45, CROSSWALK + 0.02, CROSSWALK + 0.02)[0]),
    edges((MIDDLE, 2)),
    changed("crossings", 0, nodes=(1, MIDDLE, 2)),
)
WRONG = [
    (lambda n: replace(n, size=(0, 90)), "size: 0 x 90 m is no area"),
    (lambda n: replace(n, size=(90, 3000)), "size: 90 x 3000 m is too large; at most 2000 m long"),
    (lambda n: replace(n, size=(1500, 1500)), "size: 1500 x 1500 m is too large"),
    (lambda n: replace(n, lanes=n.lanes * 1001), "lanes: 2,002 are too many; a street has at most 2,000"),
    (lambda n: replace(n, walk=replace(n.walk, nodes=np.zeros((10**6, 2)))), "walk.nodes: 1,000,000 are too many"),
    (changed("lanes", 0, line=np.zeros((10**6, 2))), "points of lanes and areas: 1,001,133 are too many"),
    (changed("lanes", 0, successors=(7,)), "lanes[0].successors: there is no 7; write numbers from 0 to 1"),
    (changed("routes", 0, lanes=(2,)), "routes[0].lanes: there is no 2"),
    (edges((0, 99)), "walk.edges: there is no 99"),
    (changed("crossings", 0, nodes=(1, -1, 2)), "crossings[0].nodes: there is no -1"),
    (zone(sides=((1, 99), (23, 24))), "crossings[0].zone.sides: there is no 99"),
    (lambda n: replace(n, crossings=()), "crossings: none; add at least one"),
    (areas(Area("sidewalk", BOW_TIE)), "areas[4].outline: crosses itself (Self-intersection"),
    (areas(Area("building", [[1, 1], [2, 2]])), "areas[4].outline: 2 points are no area"),
    (areas(Area("sidewalk", corners((25.0, 1.0, 31.0, 2.0)))), "areas[4].outline: (31, 1) is outside the map"),
    (areas(Area("building", corners((18.0, 40.0, 20.0, 50.0)))), "areas[4] (building): overlaps the roadway"),
    (areas(Area("parking", corners((2.0, 40.0, 4.0, 50.0)))), "areas[4] (parking): isn't wholly on the roadway"),
    (areas(Area("crosswalk", ring(46, 54, 0, 0.1))), "areas[4] (crosswalk at (24.0, 45.0)): no crossing leads over it"),
    (changed("lanes", 0, width=0.5), "lanes[0].width: 0.5 m; write 1.5 to 10 m"),
    (changed("lanes", 0, speed_limit=0), "lanes[0].speed_limit: 0 m/s"),
    (changed("lanes", 0, line=arc(54.5, -0.7, 0.7)), "lanes[0].line: leaves the roadway"),
    (changed("lanes", 0, line=[[20, 40]]), "lanes[0].line: needs at least two points"),
    (changed("lanes", 0, line=arc(52, -0.7, 0.5)), "lanes[0]: leads nowhere: it ends at (15.63, 69.93) on the roadway"),
    (changed("lanes", 0, successors=(1,)), "lanes[0].successors: lane 1 begins 4.00 m from its end"),
    (changed("routes", 0, lanes=(0, 1)), "routes[0].lanes: lane 1 doesn't follow lane 0"),
    (changed("routes", 0, goal=90.0), "routes[0]: start 5 and goal 90 must lie on the first and last lane (81.68"),
    (changed("routes", 0, start=71.0), "routes[0]: start 71 and goal 70 must lie"),
    (edges((2, EACH + 2)), f"(2 to {EACH + 2}): crosses a roadway from"),
    (edges((0, 8)), "(0 to 8): leaves the sidewalks from"),
    (edges((0, 1)), "(0 to 1): joined 2 times"),
    (edges((2, 2)), "(2 to 2): joins two nodes in one place"),
    (edges(without=[(MIDDLE, EACH + 1)]), "crossings[0].nodes: not joined one after the other"),
    (edges(without=[(0, 1)]), "walk.nodes[0] at (2.4, 13.8): cut off from the others"),
    (changed("crossings", 0, nodes=(1, EACH + 1)), "crossings[0]: needs an area and at least three nodes"),
    (changed("crossings", 0, areas=(0,)), "crossings[0].areas: areas[0] is a roadway"),
    (nodes(1, arc(46.5, CROSSWALK, CROSSWALK)[0]), "crossings[0].nodes: unreachable: its landings must lie on side"),
    (zone(begin=28.0), "crossings[0].zone: from 28 to 27 m; must lie within the 40.00 m of its sides"),
    (zone(end=41.0), "crossings[0].zone: from 3 to 41 m; must lie within"),
    (zone(begin=1.0), "crossings[0].zone: a way across from (9.9, 24.2) meets the crosswalk areas[3]"),
    (zone(sides=((1, 2, 3), (23, 24))), "crossings[0].zone.sides: 3 and 2 nodes; both need equally many"),
    (zone(sides=((2, 3), (24, 25))), "crossings[0].zone.sides: must begin at the landings 1 and 23"),
    (zone(sides=((1, 3), (23, 25))), "crossings[0].zone.sides: not joined one after the other"),
    (nodes(5, arc(45, CROSSWALK + 0.16, CROSSWALK + 0.16)[0]), "crossings[0].zone.sides: pieces of 1.60 to 3.40 m"),
    (waypoints(0), f"walk.waypoints: 0 of {MIDDLE + 1} nodes; there must be some"),
    (waypoints(MIDDLE + 1), "crossings[0].nodes: only its first and last node may be waypoints (numbers below"),
    (changed("lanes", 0, line=[[20, 40], [31, 40]]), "lanes[0].line: (31, 40) is outside the map"),
    (nodes(0, (31, 1)), "walk.nodes: (31, 1) is outside the map; move it inside, or correct size"),
    (lambda n: changed("lanes", 0, successors=(2,))(replace(n, lanes=(*n.lanes, BACK))), "lane 2 turns off sharply at"),
    (lambda n: replace(n, crossings=n.crossings * 2), "walk.nodes[1]: 2 crossings use it; give each its own nodes"),
    (edges((MIDDLE, 5)), f"walk.nodes[{MIDDLE}]: between the landings of a crossing, but joined to 5; remove"),
    (nodes(MIDDLE, arc(50, 0.1, 0.1)[0]), "crossings[0].nodes: the way leaves its crosswalk and the sidewalks"),
    (nodes(MIDDLE, arc(45.5, CROSSWALK, CROSSWALK)[0]), f"node {MIDDLE} is neither on the roadway nor on an island"),
    (nodes(MIDDLE, arc(54.5, CROSSWALK, CROSSWALK)[0]), f"node {MIDDLE} is neither on the roadway nor on an island"),
    (ON_ONE_SIDE, "crossings[0].nodes: crosses no roadway"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "message"), WRONG, ids=[message[:50] for _, message in WRONG])
def test_a_wrong_network_is_refused_in_a_moment(change, message):
    begun = time.process_time()
    faults = network_faults(change(bend()), **DISTANCES)
    assert any(message in fault for fault in faults), faults
    assert time.process_time() - begun < 5


def test_a_node_on_an_island_lies_in_its_middle():
    """The island reaches from y = 10 m to 14 m: 12.04 m is near enough to its middle, 12.06 m isn't."""
    assert network_faults(nodes(7, (30, 12.04))(island()), **DISTANCES) == []
    (fault,) = network_faults(nodes(7, (30, 12.06))(island()), **DISTANCES)
    assert fault == "crossings[0].nodes: node 7 isn't in the middle of its island; move it"


def test_a_start_has_waypoints_far_enough_away():
    faults = network_faults(bend(), goal_spacing=20.0, start_clearance=100.0)
    said = "no waypoint is 100 m from the car's start; add one farther away"
    assert faults == [f"routes[{n}]: {said}" for n in (0, 1)]


def test_a_sharp_bend_is_refused():
    """The car turns within 4.37 m; the lane turns with a radius of 3 m."""
    angle = np.linspace(0, np.pi / 2, 60)
    line = np.concatenate([[[5, 2]], np.stack([20 + 3 * np.sin(angle), 5 - 3 * np.cos(angle)], axis=1), [[23, 30]]])
    network = replace(
        bend(),
        lanes=(Lane(line, 4, 8.0),),
        areas=(Area("roadway", [[5, 0], [25, 0], [25, 30], [18, 30], [18, 6], [5, 6]]), *bend().areas[1:]),
        routes=(LaneRoute((0,), 0.0, 40.0),),
    )
    (fault,) = [x for x in network_faults(network, **DISTANCES) if "sharply" in x]
    assert fault.startswith("routes[0]: bends too sharply at (2")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"size"', '"sizes"', "size: missing"),
        ('"width": 4.0', '"width": "4"', "lanes.0.width: should be a valid number, not '4'"),
        ('"kind": "roadway"', '"kind": "river"', "areas.0.kind: should be 'roadway', 'sidewalk'"),
        ('"waypoints"', '"wayponts"', "walk.waypoints: missing"),
        ("[[0, 1]", "[[0, 1.5]", "walk.edges: must be pairs of whole numbers, not"),
        ("[[", "[[NaN, 1], [", "lanes.0.line: points must be [x, y] with two finite numbers each, not"),
        ("{", "{{", "not JSON that can be read (key must be a string at line 1 column 2); correct the file"),
    ],
)
def test_a_file_of_the_wrong_form_is_refused(old, new, message):
    text = network_text(bend()).replace(old, new, 1)
    with pytest.raises(MapError, match=re.escape(message)) as refusal:
        parse_network(text, "town.json")
    assert len(str(refusal.value)) < 2000
    assert "town.json" in str(refusal.value)


def test_a_file_of_a_million_nodes_is_not_read():
    nodes = "[" + ",".join(["[1.25, 2.25]"] * 10**6) + "]"
    with pytest.raises(MapError, match="larger than 8,000,000 bytes"):
        parse_network(f'{{"walk": {{"nodes": {nodes}}}}}', "town.json")


def test_a_file_with_many_faults_names_some_of_them():
    lanes = ",".join(["{}"] * 1000)
    with pytest.raises(MapError) as refusal:
        parse_network(f'{{"lanes": [{lanes}]}}', "town.json")
    assert len(refusal.value.faults) == 31
    assert refusal.value.faults[-1].endswith("more faults")


def test_walk_graphs_are_numbers_of_the_right_shape():
    for wrong in ([[0.5, 1]], [[0, 1, 2]], [["a", "b"]], [[True, False]]):
        with pytest.raises(ValueError, match="pairs of whole numbers"):
            WalkGraph([[0, 1]], wrong, 1)
