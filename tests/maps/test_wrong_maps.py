"""Every kind of wrong map is refused, by a message that names the place and says what to do."""

import re
from pathlib import Path

import numpy as np
import pytest

from jaxwalk.maps import MapError, load_map
from jaxwalk.maps.file import parse
from jaxwalk.maps.routes import centre_lines, lane_route, sample


def put(*path, to):
    """A change of a table: sets the value at ``path``."""

    def change(table):
        for key in path[:-1]:
            table = table[key]
        table[path[-1]] = to

    return change


def drop(*path):
    """A change of a table: removes the value at ``path``."""

    def change(table):
        for key in path[:-1]:
            table = table[key]
        del table[path[-1]]

    return change


def change_side(crosswalk, number, **values):
    """A change of one side of a crosswalk."""
    return lambda table: table["crosswalks"][crosswalk]["sides"][number].update(values)


WRONG_FORM = [
    (drop("size"), "size: missing"),
    (put("name", to="x"), "name: unknown key; remove it"),
    (put("car", "color", to="red"), "car.color: unknown key"),
    (put("car", "routes", to="some"), "car.routes: should be 'all', not 'some'"),
    (put("roads", "branch", to=[60, 82, 120]), "roads.branch.3: missing"),
    (put("roads", "branch", to=[60, 82, 120, "90"]), "roads.branch.3: should be a valid number, not '90'"),
    (put("waypoints", "west_s", to=[48, True]), "waypoints.west_s.1: should be a valid number, not True"),
    (put("waypoints", "west_s", to=[48, float("nan")]), "waypoints.west_s.1: should be a finite number, not nan"),
    (put("size", to=[120, float("inf")]), "size.1: should be a finite number"),
    (drop("crosswalks", "tee", "sides", 1), "crosswalks.tee.sides.1: missing"),
    (change_side("tee", 0, zone="far"), "crosswalks.tee.sides.0.zone: should be a valid tuple, not 'far'"),
]

WRONG_CONTENT = [
    (put("size", to=[0, 120]), "size: 0 x 120 m is no area"),
    (put("size", to=[119.5, 120]), "roads.branch: outside the map"),
    (put("waypoints", "west_s_end", to=[-1, 51]), "waypoints.west_s_end: outside the map"),
    (put("sidewalks", "tee_east", to=[62, 92, 60, 120]), "sidewalks.tee_east: empty"),
    (put("roads", "branch", to=[60, 90, 120, 82]), "roads.branch: empty"),
    (put("roads", to={}), "roads: none"),
    (put("roads", "stub", to=[10, 20, 18, 28]), "roads.stub: not longer than wide"),
    (put("roads", "twin", to=[70, 90, 120, 98]), "roads.branch and roads.twin: parallel and touching"),
    (put("sidewalks", "tee_east", to=[59, 92, 62, 120]), "sidewalks.tee_east: overlaps roads.south_north"),
    (put("walkways", "tee_east", 1, to="te_e"), "walkways.tee_east: no waypoint is called 'te_e'"),
    (change_side("tee", 1, landing="te_e"), "crosswalks.tee.sides[1].landing: no waypoint is called 'te_e'"),
    (change_side("tee", 1, outer="te_e"), "crosswalks.tee.sides[1].outer: no waypoint is called 'te_e'"),
    (put("waypoints", "west_s_mid", to=[20, 49]), "waypoints.west_s_mid: not on a sidewalk"),
    (put("waypoints", "west_s_mid", to=[20, 55]), "waypoints.west_s_mid: not on a sidewalk"),
    (put("waypoints", "again", to=[20, 51]), "waypoints.west_s_mid and waypoints.again: in the same place"),
    (put("waypoints", "alone", to=[30, 51]), "waypoints.alone: cut off from the others"),
    (put("walkways", "branch_north", to=["corner_tee_n"]), "walkways.branch_north: joins nothing"),
    (put("walkways", "stay", to=["west_s", "west_s"]), "walkways.stay, west_s to west_s: a waypoint is joined to its"),
    (put("walkways", "back", to=["corner_sw", "west_s"]), "corner_sw to west_s: already joined by walkways.west_south"),
    (put("walkways", "dash", to=["west_s_mid", "west_n_mid"]), "walkways.dash, west_s_mid to west_n_mid: crosses a"),
    (put("walkways", "hop", to=["corner_tee_s", "corner_tee_n"]), "corner_tee_s to corner_tee_n: crosses a roadway"),
    (put("walkways", "direct", to=["west_s", "west_n"]), "walkways.direct, west_s to west_n: crosses a roadway"),
    (put("walkways", "lawn", to=["west_s_mid", "south_w_mid"]), "west_s_mid to south_w_mid: leaves the sidewalks"),
    (put("crosswalks", to={}), "crosswalks: none"),
    (put("crosswalks", "tee", "area", to=[52, 92, 59, 96]), "crosswalks.tee.area: doesn't span one road"),
    (put("crosswalks", "tee", "area", to=[10, 92, 20, 96]), "crosswalks.tee.area: doesn't span one road"),
    (put("crosswalks", "north", "area", to=[52, 58, 60, 62]), "crosswalks.north.area: doesn't span one road"),
    (put("crosswalks", "north", "area", to=[52, 90, 60, 93]), "crosswalks.north and crosswalks.tee: overlap"),
    (change_side("tee", 0, landing="north_w"), "waypoints.north_w: the landing of 2 sides"),
    (put("waypoints", "tee_e", to=[61, 95]), "crosswalks.tee.sides[1].landing: not straight across the middle"),
    (put("sidewalks", "tee_east", to=[60.5, 92, 62, 120]), "sides[1].landing: the way to the crosswalk leaves the"),
    (put("crosswalks", "tee", "sides", 1, "landing", to="tee_w"), "crosswalks.tee.sides: the landings must be at opp"),
    (change_side("tee", 1, outer="tee_e"), "crosswalks.tee.sides[1].outer: where the landing is"),
    (change_side("tee", 1, outer="tee_w_end"), "crosswalks.tee.sides[1].outer: not along the landing's kerb"),
    (change_side("branch", 1, outer="east_n_end"), "crosswalks.branch.sides[1].outer: no walkway joins east_n_end"),
    (change_side("west", 0, outer="corner_sw"), "crosswalks.west.sides: the zones go in different directions"),
    (change_side("west", 0, zone=[0.5, 25]), "crosswalks.west.sides[0].zone: must be [from, to] with 1 <= from < to"),
    (change_side("west", 0, zone=[1, 25.5]), "crosswalks.west.sides[0].zone: must be [from, to] with"),
    (change_side("west", 0, zone=[9, 9]), "crosswalks.west.sides[0].zone: must be [from, to] with"),
    (change_side("north", 1, zone=[1, 15]), "crosswalks.north.sides[1].zone: reaches past corner_tee_s; end it bef"),
    (change_side("north", 0, zone=[1, 20]), "crosswalks.north.sides: the zones differ"),
    (put("car", "places", 0, to=[10, 55]), "car.places[0]: (10, 55) isn't on one road's centre line"),
    (put("car", "places", 0, to=[56, 56]), "car.places[0]: (56, 56) isn't on one road's centre line"),
    (put("car", "places", 1, to=[10, 56]), "car.places[0] and car.places[1]: the same"),
    (put("car", "places", to=[]), "car.routes: none"),
    (put("car", "routes", to=[]), "car.routes: none"),
    (put("car", "routes", to=[[0, 1], [0, 1]]), "car.routes: [0, 1] is listed 2 times"),
    (put("car", "routes", to=[[0, 10]]), "car.routes: [0, 10] must be two different places, 0 to 9"),
    (put("car", "routes", to=[[-1, 1]]), "car.routes: [-1, 1] must be two different places"),
    (put("car", "routes", to=[[4, 4]]), "car.routes: [4, 4] must be two different places"),
    (put("car", "right_turn_radius", to=4.3), "car.right_turn_radius: the car can't turn within 4.3 m; at least 4.37"),
    (put("car", "left_turn_radius", to=-8), "car.left_turn_radius: the car can't turn within -8 m"),
    (put("car", "right_turn_radius", to=6), "route from [10.0, 56.0] to [56.0, 10.0]: less than 0.5 m from the road's"),
    (put("car", "places", 1, to=[50.5, 56]), "route from [50.5, 56.0] to [56.0, 10.0]: the lane from (50.5, 54) is"),
    (put("car", "places", 0, to=[0.2, 56]), "route from [0.2, 56.0] to [30.0, 56.0]: less than 0.5 m from the road's"),
    (put("roads", "branch", to=[63, 82, 120, 90]), "route from [10.0, 56.0] to [80.0, 86.0]: no road leads there"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "message"), WRONG_FORM + WRONG_CONTENT)
def test_a_wrong_map_is_refused(change, message, paper, write):
    change(paper)
    path = write(paper)
    with pytest.raises(MapError, match=re.escape(message)) as refusal:
        load_map(path)
    assert str(path) in str(refusal.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (put("car", "places", 0, to=[10, 55]), "car.places[0]"),
        (put("waypoints", "alone", to=[30, 51]), "waypoints.alone"),
        (change_side("west", 0, zone=[1, 20]), "crosswalks.west.sides: the zones differ"),
        (put("walkways", "dash", to=["west_s_mid", "west_n_mid"]), "walkways.dash"),
    ],
)
def test_a_single_mistake_is_a_single_fault(change, message, paper, write):
    change(paper)
    with pytest.raises(MapError) as refusal:
        load_map(write(paper))
    (fault,) = refusal.value.faults
    assert fault.startswith(message)


def test_every_fault_is_named_at_once(paper, write):
    mistakes = [
        (put("waypoints", "west_s_end", to=[-1, 51]), "waypoints.west_s_end: outside the map"),
        (put("walkways", "tee_east", 1, to="te_e"), "walkways.tee_east: no waypoint is called 'te_e'"),
        (change_side("west", 0, zone=[0.5, 25]), "crosswalks.west.sides[0].zone: must be [from, to]"),
        (put("car", "places", 0, to=[10, 55]), "car.places[0]: (10, 55) isn't on one road's centre line"),
        (put("car", "right_turn_radius", to=4), "car.right_turn_radius: the car can't turn"),
    ]
    for change, _ in mistakes:
        change(paper)
    with pytest.raises(MapError) as refusal:
        load_map(write(paper))
    lines = str(refusal.value).splitlines()
    assert lines[0].endswith(f"has {len(refusal.value.faults)} faults:")
    for _, message in mistakes:
        assert any(message in line for line in lines), message


def test_an_empty_map_is_refused_for_all_it_lacks(paper, write):
    empty = {"size": [10, 10], "roads": {}, "sidewalks": {}, "waypoints": {}, "walkways": {}, "crosswalks": {}}
    empty["car"] = paper["car"] | {"places": []}
    with pytest.raises(MapError) as refusal:
        load_map(write(empty))
    assert [fault.split(":")[0] for fault in refusal.value.faults] == ["roads", "crosswalks", "waypoints", "car.routes"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda table: table["crosswalks"].update(second=table["crosswalks"]["only"] | {"area": [25, 6, 29, 14]}),
            "crosswalks.only.sides: the way between the zones meets crosswalks.second",
        ),
        (
            put("roads", "inner", to=[30, 6, 34, 14]),
            "crosswalks.only.sides: the way between the zones meets roads.inner",
        ),
        (
            put("sidewalks", "south", to=[0, 4, 60, 5.5]),
            "sides[0].landing: the way to the crosswalk leaves the sidewalk",
        ),
        (
            put("roads", "only", to=[0, 6, 30, 14]),
            "crosswalks.only.sides: the way between the zones leaves road and",
        ),
    ],
)
def test_people_may_cross_between_the_zones(change, message, small, write):
    load_map(write(small))
    change(small)
    with pytest.raises(MapError, match=re.escape(message)):
        load_map(write(small))


def test_waypoints_need_goals_and_routes_need_starts(small, write):
    path = write(small)
    assert load_map(path).goal_count.min() > 0
    with pytest.raises(MapError, match=r"waypoints.s: no waypoint is 60 m of walking away"):
        load_map(path, goal_spacing=60.0)
    with pytest.raises(MapError, match=r"route from \[5.0, 10.0\] to .*: no waypoint is 55 m from the car's start"):
        load_map(path, start_clearance=55.0)


def test_the_distances_can_be_chosen(write, small):
    nearer = load_map(write(small), goal_spacing=0.0, start_clearance=0.0)
    assert (nearer.goal_count == 6).all()
    assert (nearer.start_count == 6).all()


def test_broken_toml_is_refused_with_its_line(write):
    path = write("size = [120, 120]\nroads = = 3\n")
    with pytest.raises(MapError, match=r"not valid TOML: .*line 2") as refusal:
        load_map(path)
    assert str(path) in str(refusal.value)
    with pytest.raises(MapError, match=r"not valid TOML: .*line 3, the end of the file"):
        load_map(write("size = [120, 120]\nroads = [\n  3"))


def test_a_name_given_twice_is_refused(write):
    with pytest.raises(MapError, match=r"not valid TOML: .*line 3"):
        load_map(write("[waypoints]\na = [1, 1]\na = [2, 2]\n"))


def test_a_file_that_is_not_text_is_refused(write):
    with pytest.raises(MapError, match="not UTF-8"):
        load_map(write(b"\xff\xfe"))


def test_an_unknown_name_lists_the_bundled_maps():
    with pytest.raises(MapError, match=r"map papr has 1 fault:\n.*bundled one \(paper, test-track\)"):
        load_map("papr")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(MapError, match=r"nowhere\.toml(.|\n)*cannot be read \(No such file"):
        load_map(tmp_path / "nowhere.toml")


def test_routes_follow_any_roads_that_meet_at_right_angles():
    """A corner where the north-going road only touches the end of the other."""
    text = """
        size = [70, 70]
        roads = {east = [0, 10, 50, 18], north = [50, 10, 58, 60]}
        car = {places = [[10, 14], [54, 50]], right_turn_radius = 5, left_turn_radius = 8}
        sidewalks = {}
        waypoints = {}
        walkways = {}
        crosswalks = {}
    """
    lines = centre_lines(parse(text, "corner"))
    pieces, length = lane_route(lines, 0, 1, (5.0, 8.0))
    assert length == pytest.approx(38 + 4 * np.pi + 30)  # (10, 12) to (56, 12) to (56, 50), a left turn
    points, tangents = sample(pieces, np.array([0, 38, 38 + 4 * np.pi, length]))
    assert points == pytest.approx(np.array([(10, 12), (48, 12), (56, 20), (56, 50)]))
    assert tangents == pytest.approx(np.array([(1, 0), (1, 0), (0, 1), (0, 1)]))
    pieces, length = lane_route(lines, 1, 0, (5.0, 8.0))
    assert length == pytest.approx(29 + 2.5 * np.pi + 37)  # (52, 50) to (52, 16) to (10, 16), a right turn


def test_the_example_in_the_documentation_is_a_map(write):
    documentation = Path(__file__).parents[2] / "docs" / "maps.md"
    example = documentation.read_text(encoding="utf-8").split("```toml\n")[1].split("```")[0]
    assert load_map(write(example)).route_count == 2
