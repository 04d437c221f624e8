"""Tags of Lanelet2 maps: speed limits, who may use a lanelet, and in which direction."""

import pytest

from jaxwalk.maps.imported.importing import read_source
from jaxwalk.maps.imported.lanelet_shapes import use_of
from jaxwalk.maps.imported.refusals import ImportRefusal
from maps.imported.lanelet_maps import road_map
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
