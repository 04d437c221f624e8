"""Tags of Lanelet2 maps: speed limits, who may use a lanelet, and in which direction."""

import numpy as np
import pytest

from jaxwalk.maps.imported.importing import read_source
from jaxwalk.maps.imported.lanelet_shapes import use_of
from jaxwalk.maps.imported.refusals import ImportRefusal
from maps.imported.lanelet_maps import HALF, LANE, MIDDLE, LaneletMap, road_map
from maps.imported.written_maps import written_as


def written(folder, made):
    return written_as(folder, made if isinstance(made, str) else made.text(), "road.osm")


@pytest.mark.parametrize(
    "tags, limit",
    [
        ({"speed_limit": "20 mph"}, (32.2, "mapped")),
        ({"speed_limit": ""}, (50.0, "inferred")),
        ({"speed_limit": "", "location": "nonurban"}, (100.0, "inferred")),
        ({"speed_limit": "", "subtype": "play_street"}, (15.0, "inferred")),
        ({"speed_limit": "13.888889 m/s"}, (50.0, "mapped")),
        ({"speed_limit": "40km/h"}, (40.0, "mapped")),
        ({"speed_limit": "30 knots"}, (50.0, "inferred")),
        ({"speed_limit": "0"}, (50.0, "inferred")),
        ({"speed_limit": "5"}, (6.0, "inferred")),
        ({"speed_limit": "1000"}, (130.0, "inferred")),
        ({"speed_limit": "50", "speed_limit__vehicle": "40"}, (40.0, "mapped")),
        ({"speed_limit": "50", "speed_limit__vehicle": "40", "speed_limit__vehicle__car": "30"}, (30.0, "mapped")),
        ({"speed_limit": "50", "speed_limit__bicycle": "20"}, (50.0, "mapped")),
    ],
)
def test_speed_limits(tmp_path, tags, limit):
    elements = read_source(written(tmp_path, road_map(**tags))).elements
    assert {(x["limit_km_h"], x["limit_from"]) for x in elements} == {limit}


def ruled(subtype, **about):
    """The road, of which a lanelet has a rule of speed with a sign, none if it has no subtype."""
    made = road_map(speed_limit="20")
    sign = made.line((0, -5), (0, -6), kind="traffic_sign", subtype=subtype)
    rule = made.relation(
        {"refers": [sign] if subtype else []}, type="regulatory_element", subtype="speed_limit", **about
    )
    return made.text().replace('role="right"/>', f'role="right"/><member type="relation" ref="{rule}" role="rule"/>')


@pytest.mark.parametrize(
    "sign, limit",
    [("de274-70", 70), ("de274", 30), ("de274.1", 30), ("de274_1-20", 20), ("de274.1-20", 20), ("de274-100", 100),
     ("de310", 50), ("usR2-1", 20)],
)  # fmt: skip
def test_the_speed_limit_of_a_sign(tmp_path, sign, limit):
    """The signs of Lanelet2's own German rules; a sign of which nobody knows the speed says nothing."""
    assert {x["limit_km_h"] for x in read_source(written(tmp_path, ruled(sign))).elements} == {limit}


@pytest.mark.parametrize(
    "subtype, about, limit",
    [("", {"sign_type": "60"}, 60), ("de274-70", {"sign_type": "60"}, 70), ("de274-70", {"dynamic": "yes"}, 20)],
)  # fmt: skip
def test_rules_of_speed(tmp_path, subtype, about, limit):
    """A sign counts before the rule's type, and a rule that holds only at times doesn't count."""
    assert {x["limit_km_h"] for x in read_source(written(tmp_path, ruled(subtype, **about))).elements} == {limit}


def test_who_may_use_a_lanelet(tmp_path):
    buses = road_map(participant__vehicle__bus="yes")
    with pytest.raises(ImportRefusal, match="has no roads"):
        read_source(written(tmp_path, buses))
    assert len(read_source(written(tmp_path, road_map(participant__vehicle__car="true"))).lanes) == 2


@pytest.mark.parametrize(
    "subtype, tags, use",
    [
        ("walkway", {}, "walk"),
        ("shared_walkway", {"pedestrian": "yes", "bicycle": "yes"}, "walk"),
        ("walkway", {"bicycle": "yes"}, "beside"),
        ("walkway", {"vehicle": "yes"}, "driven"),
        ("walkway", {"pedestrian": "no"}, "other"),
        ("crosswalk", {"pedestrian": "yes"}, "crosswalk"),
        ("crosswalk", {"vehicle": "no"}, "crosswalk"),
        ("crosswalk", {"bicycle": "yes"}, "other"),
        ("bus_lane", {"vehicle:car": "yes"}, "driven"),
        ("road", {"vehicle": "no"}, "other"),
        ("road", {"pedestrian": "yes"}, "walk"),
        ("stairs", {}, "other"),
    ],
)
def test_participants_override_the_subtype(subtype, tags, use):
    assert use_of({"subtype": subtype} | {f"participant:{who}": may for who, may in tags.items()}) == use


@pytest.mark.parametrize(
    "tags, lanes",
    [
        ({"one_way": "no"}, 4),
        ({"one_way": "0"}, 4),
        ({"one_way__vehicle": "no"}, 4),
        ({"one_way__vehicle__car": "no"}, 4),
        ({"one_way__bicycle": "no"}, 2),
        ({"one_way": "yes"}, 2),
    ],
)
def test_lanelets_in_both_directions(tmp_path, tags, lanes):
    source = read_source(written(tmp_path, road_map(**tags)))
    assert len(source.lanes) == lanes and {x["lanes"][1] for x in source.elements} == {lanes // 2 - 1}


@pytest.mark.parametrize(
    "stop, kind",
    [(MIDDLE - HALF - 2, ("signals", "inferred")), (MIDDLE - 60, ("zebra", "mapped")), (None, ("zebra", "mapped"))],
    ids=["just before it", "60 m before it", "at the lanelet's end"],
)
def test_a_crosswalk_at_the_stop_line_of_a_traffic_light_has_signals(tmp_path, stop, kind):
    """The light is that of one of the road's lanelets, which stops cars at its line, or at its end without one."""
    made = road_map()
    line = [] if stop is None else [made.line((stop, -LANE), (stop, 0), kind="stop_line")]
    light = made.line((stop or 0, -5), (stop or 0, -6), kind="traffic_light")
    about = {"type": "regulatory_element", "subtype": "traffic_light"}
    rule = made.relation({"refers": [light], "ref_line": line}, **about)
    member = f'role="right"/><member type="relation" ref="{rule}" role="regulatory_element"/>'
    (crossing,) = read_source(written(tmp_path, made.text().replace('role="right"/>', member, 1))).crossings
    assert (crossing.kind, crossing.kind_origin) == kind


@pytest.mark.parametrize(
    "subtype, what", [("rail", "tracks"), ("bicycle_lane", "cycleways"), ("", "pavement or islands")]
)
def test_a_crosswalk_over_no_roadway_is_only_counted(tmp_path, subtype, what):
    """30 m to the north of the road; over a lanelet of a subtype, or over nothing."""
    made = road_map()
    if subtype:
        made.lanelet(*(made.line((0, y), (200, y)) for y in (33, 30)), subtype=subtype)
    made.lanelet(*(made.line((x, 28), (x, 35)) for x in (100, 104)), subtype="crosswalk")
    source = read_source(written(tmp_path, made))
    assert len(source.crossings) == 1 and source.elsewhere == {what: 1}


def test_a_lanelet_without_a_surface_is_left_out(tmp_path):
    """Its left bound is its right one."""
    made = road_map()
    line = made.line((0, 20), (20, 20))
    made.lanelet(line, line, subtype="road")
    source = read_source(written(tmp_path, made))
    assert len(source.lanes) == 2 and source.left_out == ("1 lanelet without a left or right bound in the file",)


def test_a_point_that_is_named_twice_counts_once(tmp_path):
    made = LaneletMap()
    sides = [made.line((0, y), (0, y), (100, y), (100, y)) for y in (LANE, 0)]
    made.lanelet(*sides, subtype="road")
    (lane,) = read_source(written(tmp_path, made)).lanes
    assert lane.length() == pytest.approx(100.0)


def strip(made, *points):
    """A lanelet along points from west to east, `LANE` wide."""
    made.lanelet(*(made.line(*((x, y + aside) for x, y in points)) for aside in (LANE / 2, -LANE / 2)), subtype="road")


@pytest.mark.parametrize("pieces, lanes, ways", [(6, 4 + 2, 2), (7, 2 + 1, 0)])
def test_a_way_through_a_junction_leads_over_at_most_six_lanelets(tmp_path, pieces, lanes, ways):
    """Two roads that cross: one over some lanelets of 3 m within the junction, the other one over a single lanelet.

    Over seven, the first road has no way through: it ends and begins anew, and the other one is a single lane.
    """
    made = LaneletMap()
    reach = 3 * pieces
    strip(made, (-60, 0), (0, 0))
    for n in range(pieces):
        strip(made, (3 * n, 0), (3 * n + 3, 0))
    strip(made, (reach, 0), (reach + 60, 0))
    for y, end in ((-60, -2), (-2, 2), (2, 60)):
        made.lanelet(*(made.line((x, y), (x, end)) for x in (0, reach)), subtype="road")
    source = read_source(written(tmp_path, made))
    assert (len(source.lanes), source.in_junction.sum()) == (lanes, ways)


def test_a_turn_between_lanelets_without_room_is_named(tmp_path):
    """From the end of a road a lanelet leads on, and over it another one turns back with a radius of 3 m."""
    made = LaneletMap()
    for ends in ((0, 100), (100, 120), (120, 200)):
        strip(made, *((x, 0) for x in ends))
    bends = []
    for radius in (3 - LANE / 2, 3 + LANE / 2):
        bend = [(100 + radius * np.cos(angle), 3 + radius * np.sin(angle)) for angle in np.linspace(-1.4, 1.4, 15)]
        bends.append(made.line((100, 3 - radius), *bend, (100, 3 + radius)))
    made.lanelet(*bends, subtype="road")
    made.lanelet(*(made.line((100, y), (0, y)) for y in (6 - LANE / 2, 6 + LANE / 2)), subtype="road")
    source = read_source(written(tmp_path, made))
    (said,) = source.left_out
    assert said.startswith("1 turn at junctions: too tight")
    assert len(source.lanes) == 2 and not any(lane.successors for lane in source.lanes)
