"""What tags say of roads and crossings."""

import pytest

from jaxwalk.maps.imported.osm_tags import crossing_kind, metres, road_facts, sidewalk


@pytest.mark.parametrize("key", ["width:carriageway", "width"])
def test_parking_on_the_road_is_part_of_its_width(key):
    """9.6 m less two strips of 2 m, for two lanes."""
    profile = road_facts({"highway": "residential", key: "9.6", "parking:both": "lane"}).profile
    assert (profile.forward, profile.backward, profile.lane_width) == (1, 1, pytest.approx(2.8))


@pytest.mark.parametrize("tags", [({"crossing": "no"}, {}), ({}, {"crossing": "no"})])
def test_who_may_not_cross_has_no_crossing(tags):
    assert crossing_kind(*tags) is None


@pytest.mark.parametrize(
    "tags, lanes",
    [
        ({"oneway": "-1"}, (0, 1)),
        ({"oneway": "reverse", "lanes": "2"}, (0, 2)),
        ({"lanes:forward": "2", "lanes:backward": "1"}, (2, 1)),
        ({"lanes": "3", "lanes:backward": "1"}, (2, 1)),
        ({"lanes": "3"}, (2, 1)),
    ],
)
def test_lanes_with_a_way_and_against_it(tags, lanes):
    profile = road_facts({"highway": "residential"} | tags).profile
    assert (profile.forward, profile.backward) == lanes


@pytest.mark.parametrize(
    "text, length",
    [("3.5", 3.5), ("3,5 m", 3.5), ("10 ft", 3.048), ("16'6\"", 5.0292), ("7'", 2.1336), ("wide", None), (None, None)],
)
def test_lengths_in_metres_and_feet(text, length):
    """A foot is 0.3048 m, an inch a twelfth of that."""
    assert metres(text) == (None if length is None else pytest.approx(length))


@pytest.mark.parametrize(
    "tags, answer",
    [
        ({"sidewalk:left": "separate"}, "yes"),
        ({"sidewalk:left": "no", "sidewalk": "both"}, "no"),
        ({"sidewalk:both": "yes"}, "yes"),
        ({"sidewalk": "right"}, "no"),
        ({"sidewalk": "lost"}, "unknown"),
        ({}, "unknown"),
    ],
)
def test_the_sidewalk_on_the_left(tags, answer):
    assert sidewalk(tags, "left") == answer


@pytest.mark.parametrize(
    "tags, kind",
    [
        ({"crossing": "zebra", "traffic_calming": "table"}, ("raised", "mapped")),
        ({"traffic_calming": "table"}, ("raised", "mapped")),
        ({"crossing": "unmarked", "traffic_calming": "table"}, ("unmarked", "mapped")),
        ({"crossing": "toucan", "traffic_calming": "table"}, ("signals", "mapped")),
        ({"crossing": "zebra", "crossing:markings": "no"}, ("unmarked", "mapped")),
        ({"highway": "crossing"}, ("unmarked", "inferred")),
    ],
)
def test_kinds_of_crossings(tags, kind):
    assert crossing_kind(tags, {}) == crossing_kind({}, tags) == kind
