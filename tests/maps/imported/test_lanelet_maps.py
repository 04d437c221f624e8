"""Streets of Lanelet2 maps: a small one whose lanes and crosswalk are known by hand, and bad ones."""

import sys

import numpy as np
import pytest
import shapely

from jaxwalk.maps.imported.importing import import_street, read_source, report_of
from jaxwalk.maps.imported.lanelet_reading import is_lanelet_map
from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.region import Region
from maps.imported.lanelet_maps import LANE, LENGTH, MIDDLE, LaneletMap, road_map
from maps.imported.osm_files import cross
from maps.imported.written_maps import only_crossing, written_as


def written(folder, made, name="road.osm"):
    return written_as(folder, made if isinstance(made, str) else made.text(), name)


@pytest.fixture(scope="module")
def road(tmp_path_factory):
    source = read_source(written(tmp_path_factory.mktemp("lanelet"), road_map()))
    return source, import_street(source, "road", strict=True)


def test_a_road_with_one_crosswalk(road):
    source, street = road
    _, found = only_crossing(source, street)
    assert found.kind_origin == "mapped" and found.width == 4.0
    np.testing.assert_allclose(found.point, (MIDDLE, 0.0), atol=1e-9)
    np.testing.assert_allclose(np.abs(found.across), (0, 1), atol=1e-9)
    assert source.attribution == street.network.attribution == "Lanelet2 map road.osm, which names no author"


def test_its_lanes_lie_between_their_bounds(road):
    """Whatever the direction of the lines: that in the middle leads to the west, and bounds lanelets to both sides."""
    source, street = road
    assert len(source.lanes) == 2 and not source.in_junction.any()
    assert {(lane.width, round(lane.speed_limit * 3.6, 6)) for lane in source.lanes} == {(LANE, 30.0)}
    for lane in source.lanes:
        east = lane.line[-1, 0] > lane.line[0, 0]
        np.testing.assert_allclose(lane.line[:, 1], (-1 if east else 1) * LANE / 2, atol=1e-6)
    assert {route.lanes for route in street.network.routes} == {(0,), (1,)}
    report = report_of(source, [street], "road.osm", strict=True)
    assert [(x["lane_width"], x["limit_km_h"], x["limit_from"]) for x in report.elements] == [(LANE, 30, "mapped")] * 2
    assert report.left_out == () and [x.placed for x in report.crossings().values()] == [True]


def test_degrees_become_metres(tmp_path):
    source = read_source(written(tmp_path, road_map(degrees=True)))
    west, south, east, north = source.extent
    assert east - west == pytest.approx(LENGTH, abs=0.1) and north - south == pytest.approx(2 * LANE, abs=0.01)
    part = read_source(tmp_path / "road.osm", Region.around(49.0, 8.4 + MIDDLE / 73_170.2, 60.0))
    assert len(part.crossings) == 1 and part.extent == pytest.approx((-60, -60, 60, 60), abs=0.5)
    with pytest.raises(ImportRefusal, match="has no roads in this region"):
        read_source(tmp_path / "road.osm", Region.around(60.17, 24.94, 100.0))
    with pytest.raises(ImportRefusal, match="doesn't say where on earth it lies; leave --centre and --bbox out"):
        read_source(written(tmp_path, road_map()), Region.around(49.0, 8.4, 60.0))


@pytest.mark.parametrize(
    "about, kind",
    [
        ({"lights": True}, ("signals", "mapped")),
        ({"markings": "pedestrian_marking"}, ("unmarked", "mapped")),
        ({"markings": "virtual"}, ("zebra", "inferred")),
    ],
)
def test_kinds_of_crosswalks(tmp_path, about, kind):
    (crossing,) = read_source(written(tmp_path, road_map(**about))).crossings
    assert (crossing.kind, crossing.kind_origin) == kind


def test_areas_have_holes_and_a_whole_outline(tmp_path):
    made = road_map()
    outer = [made.line((50, 20), (70, 20), (70, 40)), made.line((70, 40), (50, 40), (50, 20))]
    hole = made.line((55, 25), (65, 25), (65, 35), (55, 35), (55, 25))
    made.relation({"outer": outer, "inner": [hole]}, type="multipolygon", subtype="building")
    (building,) = read_source(written(tmp_path, made)).buildings
    assert building.area == pytest.approx(400 - 100)
    text = "\n".join(x for x in made.text().split("\n") if f'<way id="{outer[1]}"' not in x)
    source = read_source(written(tmp_path, text))
    assert source.buildings == () and "1 area without a whole outline in the file" in source.left_out


def test_traffic_that_keeps_left_as_the_lanelets_lie(tmp_path):
    source = read_source(written(tmp_path, road_map(left=True)))
    street = import_street(source, "road", strict=True)
    assert source.mirrored and street.report.usable
    middle = street.network.size[1] / 2
    for lane in street.network.lanes:
        east = lane.line[-1, 0] > lane.line[0, 0]
        np.testing.assert_allclose(lane.line[:, 1], middle + (1 if east else -1) * LANE / 2, atol=0.01)
    with pytest.raises(ImportRefusal, match="its lanes keep right; leave --traffic left out"):
        read_source(written(tmp_path, road_map()), left=True)


def fork():
    """A road to the east of two lanelets that follow each other; from the second one a lanelet leads on, one away."""
    made = LaneletMap()
    for points in (((0, 0), (60, 0)), ((60, 0), (100, 0)), ((100, 0), (120, 0)), ((120, 0), (200, 0))):
        pair = [made.line(*((x, y) for x, _ in points), kind="virtual") for y in (LANE / 2, -LANE / 2)]
        made.lanelet(*pair, subtype="road")
    away = [made.line((100, 1.75), (120, -6), (124, -60)), made.line((100, -1.75), (115, -9), (120, -60))]
    made.lanelet(*away, subtype="road")
    return made


def test_lanelets_over_each_other_are_ways_through_a_junction(tmp_path):
    source = read_source(written(tmp_path, fork()))
    first, straight, _, *ways = source.lanes
    assert source.in_junction.tolist() == [False, False, False, True, True]
    np.testing.assert_allclose(first.line[[0, -1]], [(0, 0), (97, 0)], atol=1e-6)  # 3 m shorter, for the way aside
    np.testing.assert_allclose(straight.line[[0, -1]], [(120, 0), (200, 0)], atol=1e-6)
    assert first.successors == (3, 4) and {after for way in ways for after in way.successors} == {1, 2}
    assert all(any(x.covers(shapely.LineString(way.line)) for x in source.junctions) for way in ways[1:])
    assert len(source.open_ends) == 3


@pytest.mark.parametrize("subtype, is_roadway", [("", True), ("vegetation", False), ("parking", True)])
def test_a_gap_between_lanelets_of_a_junction_is_roadway_unless_something_is_mapped_there(
    tmp_path, subtype, is_roadway
):
    """In the corner where a lanelet leads away from the road to the right."""
    made = fork()
    if subtype:
        outline = made.line((90, -40), (150, -40), (150, -2), (90, -2), (90, -40))
        made.relation({"outer": [outline]}, type="multipolygon", subtype=subtype)
    roadway = read_source(written(tmp_path, made)).roadway
    assert roadway.contains(shapely.Point(118.5, -4.6)) == is_roadway
    assert roadway.contains(shapely.Point(112, -4)), "the lanelet itself"


def test_curbstones_speak_of_sidewalks_and_the_map_ends_where_nobody_has_surveyed(tmp_path):
    text = road_map().text().replace("walkway", "vegetation")
    source = read_source(written(tmp_path, text))
    assert {x.origin for x in source.evidence} == {"inferred"} and len(source.evidence) == 2
    assert any("subtype=vegetation" in x for x in source.left_out)
    assert len(source.open_ends) == 4
    made = road_map()
    made.line((LENGTH, -LANE), (LENGTH, LANE), kind="curbstone")
    assert len(read_source(written(tmp_path, made)).open_ends) == 2, "a kerb closes the road's end"
    plain = road_map(kerb="line_thin").text().replace("walkway", "vegetation")
    assert not read_source(written(tmp_path, plain)).evidence


def test_openstreetmap_files_are_told_apart(tmp_path):
    assert not is_lanelet_map(cross().write(tmp_path / "cross.osm"))
    for text in (road_map().text(), road_map().text().replace('"', "'"), "<osm><tag  v='lanelet' k='type'/>"):
        assert is_lanelet_map(written(tmp_path, text))
    late = road_map().text().replace("<MetaInfo", f"<!--{' ' * 65_400}--><MetaInfo")
    for pad in range(0, 400, 7):
        assert is_lanelet_map(written(tmp_path, late.replace("<!--", f"<!--{' ' * pad}"))), "the tag may lie anywhere"


WHOLE = road_map().text()
BAD = {
    "cut off": (WHOLE[: len(WHOLE) - 30], "can't be read as a Lanelet2 map"),
    "a document type": (WHOLE.replace("<osm ", "<!DOCTYPE a><osm "), "declares a document type"),
    "no roads": (WHOLE.replace('v="road"', 'v="stairs"'), "has no roads"),
    "no nodes": ("\n".join(x for x in WHOLE.split("\n") if not x.startswith("<node")), "has no roads"),
    "no lines": ("\n".join(x for x in WHOLE.split("\n") if not x.startswith("<way")), "has no roads"),
    "no bounds": (WHOLE.replace("<member ", "<nothing "), "has no roads"),
    "a word for a number": (WHOLE.replace('v="240.0"', 'v="far"'), "can't be read as a Lanelet2 map"),
    "no finite place": (WHOLE.replace('v="240.0"', 'v="nan"'), "has no finite place"),
    "no number": (WHOLE.replace('<node id="1"', "<node"), "a node without 'id'"),
    "nowhere on earth": (road_map(degrees=True).text().replace('lat="49', 'lat="149'), "lies nowhere on earth"),
    "far apart": (WHOLE.replace('v="240.0"', 'v="90000000"').replace('v="3.5"', 'v="3500"'), "more than 12 km2"),
    "two frames": (
        WHOLE.replace('lat="" lon=""', 'lat="1" lon="2"', 1).replace('k="local_x"', 'k="x"', 1),
        "only degrees",
    ),
}


@pytest.mark.parametrize("text, message", BAD.values(), ids=BAD)
def test_a_bad_map_ends_in_one_message(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises(ImportRefusal) as refusal:
        read_source(path)
    said = str(refusal.value)
    assert message in said and said.startswith(str(path)) and "\n" not in said and ";" in said


def test_what_is_missing_is_named(tmp_path):
    way = next(x for x in WHOLE.split("\n") if x.startswith("<way") and 'v="wall"' in x)
    source = read_source(written(tmp_path, WHOLE.replace(way, "")))
    assert "1 lanelet without a left or right bound in the file" in source.left_out
    node = way.split('<nd ref="')[1].split('"')[0]
    kept = [x for x in WHOLE.split("\n") if not x.startswith(f'<node id="{node}"')]
    source = read_source(written(tmp_path, "\n".join(kept)))
    assert source.left_out == (
        "1 lanelet without a left or right bound in the file",
        "1 node that ways name and the file doesn't have; these ways aren't read",
    )
    buses = written(
        tmp_path,
        WHOLE.replace(
            'v="walkway"/>',
            'v="walkway"/><tag k="participant:bicycle" v="no"/><tag k="participant:pedestrian" v="no"/>',
        ),
    )
    (said,) = read_source(buses).left_out
    assert said.startswith("2 lanelets with subtype=walkway and tags participant:...: not along a road")


def test_too_large_a_map(tmp_path, monkeypatch):
    monkeypatch.setattr("jaxwalk.maps.imported.lanelet_reading.MOST_BYTES", 1000)
    with pytest.raises(ImportRefusal, match="larger than 1,000 bytes"):
        read_source(written(tmp_path, WHOLE))


def test_a_map_in_metres_needs_no_package(tmp_path, monkeypatch):
    for name in ("osmium", "pyproj", "sumolib"):
        monkeypatch.setitem(sys.modules, name, None)
    assert read_source(written(tmp_path, road_map())).crossings
    with pytest.raises(ImportRefusal, match=r'needs pyproj; install it by: pip install "jaxwalk\[osm\]"'):
        read_source(written(tmp_path, road_map(degrees=True)))
