"""What tags say of roads and crossings."""

import pytest

from jaxwalk.maps.imported.osm_tags import crossing_kind, road_facts


@pytest.mark.parametrize("key", ["width:carriageway", "width"])
def test_parking_on_the_road_is_part_of_its_width(key):
    """9.6 m less two strips of 2 m, for two lanes."""
    profile = road_facts({"highway": "residential", key: "9.6", "parking:both": "lane"}).profile
    assert (profile.forward, profile.backward, profile.lane_width) == (1, 1, pytest.approx(2.8))


@pytest.mark.parametrize("tags", [({"crossing": "no"}, {}), ({}, {"crossing": "no"})])
def test_who_may_not_cross_has_no_crossing(tags):
    assert crossing_kind(*tags) is None
