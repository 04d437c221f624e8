"""Streets of SUMO networks: a small one whose lanes and crossing are known by hand, and bad ones."""

import gzip
import sys
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
import shapely

from jaxwalk.maps.imported.importing import import_street, read_source, report_of
from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.region import Region
from jaxwalk.maps.imported.source_map import SourceCrossing, WalkEvidence
from jaxwalk.maps.imported.sumo_ground import open_ends
from jaxwalk.maps.imported.sumo_reading import read_net
from maps.imported.sumo_nets import LIMIT, MIDDLE, WIDTH, road_net
from maps.imported.written_maps import only_crossing, written_as


def written(folder, text, name="road.net.xml"):
    return written_as(folder, text, name)


@pytest.fixture(scope="module")
def road(tmp_path_factory):
    source = read_source(written(tmp_path_factory.mktemp("sumo"), road_net()))
    return source, import_street(source, "road", strict=True)


def test_a_road_with_one_crossing(road):
    source, street = road
    _, found = only_crossing(source, street)
    assert found.name == "crossing :m_c0" and found.kind_origin == "mapped"
    np.testing.assert_allclose(found.point, (MIDDLE, 50.0))
    assert source.attribution == street.network.attribution == "SUMO network road.net.xml, which names no author"


def test_its_lanes_are_where_the_network_has_them(road):
    source, street = road
    lanes = [lane for lane, inside in zip(source.lanes, source.in_junction, strict=True) if not inside]
    assert len(lanes) == 2 and not source.in_junction.any()  # nothing forks or merges at the crossing
    assert {(lane.width, round(lane.speed_limit, 2)) for lane in lanes} == {(WIDTH, LIMIT)}
    for lane in lanes:
        east = lane.line[-1, 0] > lane.line[0, 0]
        np.testing.assert_allclose(lane.line[:, 1], 50 + (-1 if east else 1) * WIDTH / 2, atol=1e-6)
    assert {route.lanes for route in street.network.routes} == {(0,), (1,)}
    (area,) = street.network.crossings[0].areas
    assert street.network.areas[area].shape().area == pytest.approx(4 * 2 * WIDTH, rel=0.01)


def test_every_road_and_its_lanes_are_in_the_report(road):
    source, street = road
    assert [x["element"] for x in source.elements] == ["edge east1", "edge east2", "edge west1", "edge west2"]
    assert {x["width_from"] for x in source.elements} == {"mapped"}
    report = report_of(source, [street], "road.net.xml", strict=True)
    assert report.notes == () and [x.placed for x in report.crossings().values()] == [True]


@pytest.mark.parametrize(
    "about, kind", [({"signals": True}, "signals"), ({"state": "m"}, "unmarked"), ({"state": "M"}, "zebra")]
)
def test_kinds_of_crossings(tmp_path, about, kind):
    (crossing,) = read_source(written(tmp_path, road_net(**about))).crossings
    assert crossing.kind == kind


def test_what_netconvert_guessed_is_inferred(tmp_path):
    options = "".join(f'<{x}.guess value="true"/>' for x in ("crossings", "sidewalks"))
    source = read_source(written(tmp_path, road_net(comment=f"<!-- <netconvertConfiguration>{options} -->\n")))
    assert len(source.notes) == 2 and source.crossings[0].kind_origin == "inferred"
    assert {x.origin for x in source.evidence} == {"inferred"}
    assert import_street(source, "road", strict=True).report.verdict == "usable with inferred parts"


def test_data_of_openstreetmap_is_named(tmp_path):
    comment = '<!-- <osm-files value="town.osm.xml"/> -->\n'
    assert "OpenStreetMap" in read_source(written(tmp_path, road_net(comment=comment))).attribution
    names = road_net().replace("</edge>", '<param key="origId" value="7"/></edge>')
    assert "names no author" in read_source(written(tmp_path, names)).attribution, "other formats have names too"
    names = names.replace('id="east1"', 'id="east1" type="highway.residential"')
    assert "OpenStreetMap" in read_source(written(tmp_path, names)).attribution


def test_traffic_that_keeps_left_as_the_network_says(tmp_path):
    source = read_source(written(tmp_path, road_net(left=True)))
    street = import_street(source, "road")
    assert source.mirrored and street.report.usable
    middle = street.network.size[1] / 2
    for lane in street.network.lanes:
        east = lane.line[-1, 0] > lane.line[0, 0]
        np.testing.assert_allclose(lane.line[:, 1], middle + (1 if east else -1) * WIDTH / 2, atol=0.01)
    with pytest.raises(ImportRefusal, match="its lanes keep right; leave --traffic left out"):
        read_source(written(tmp_path, road_net()), left=True)


@pytest.mark.parametrize(
    "aside, reason", [(3.8, "one way with crossing :m_c0"), (4.8, "no pavement at one of its kerbs")]
)
def test_a_crossing_without_room_beside_another_one_is_one_way_with_it(road, aside, reason):
    """The crosswalk reaches 2 m to the side, and the pavement little farther."""
    source, _ = road
    lines = [np.array([(0.0, 50 + y), (MIDDLE + 1.0, 50 + y)]) for y in (-WIDTH - 1.25, WIDTH + 1.25)]
    other = SourceCrossing("other", "zebra", np.array([MIDDLE + aside, 50.0]))
    source = replace(
        source,
        crossings=(*source.crossings, other),
        evidence=tuple(WalkEvidence(line, "mapped", 1.0) for line in lines),
    )
    first, second = import_street(source, "road", strict=True).report.crossings
    assert first.placed and not first.reason
    assert second.reason == reason and second.placed == reason.startswith("one way")


def test_a_road_that_goes_on_as_a_motorway_has_an_open_end(tmp_path):
    far = (-500.0, -500.0, 900.0, 900.0)
    beyond = '<edge id="far" from="e" to="w" type="highway.motorway"><lane id="far_0" index="0" speed="30" ' \
        'length="9" shape="240,50 300,50"/></edge></net>'  # fmt: skip
    for text, count in ((road_net(), 0), (road_net().replace("</net>", beyond), 2)):
        net = read_net(written(tmp_path, text), None)
        edges = [edge for edge in net.edges if edge.getID() != "far"]
        assert len(list(open_ends(net, edges, far))) == count


@pytest.mark.parametrize("last", [40, 1])
def test_a_dead_end_whose_two_sides_have_other_edges_is_one(tmp_path, last):
    """As where a turning lane begins on one side: cars can only turn back at the end, so that it is no junction."""
    path = written(tmp_path, road_net(last=last))
    net = read_net(path, None)
    for extent, count in (((-500.0, -500.0, 900.0, 900.0), 0), ((0.0, 0.0, 240.0, 100.0), 2)):
        assert len(list(open_ends(net, net.edges, extent))) == count
    source = read_source(path)
    assert not any(x.intersects(shapely.Point(244, 50)) for x in source.junctions)
    assert sorted(x.line[-1, 0].round() for x in source.lanes) == [0, 240], "lanes end where the road does"
    street = import_street(source, "road", strict=True)
    assert {route.lanes for route in street.network.routes} == {(0,), (1,)} and street.report.verdict == "usable"


def test_lanes_from_which_cars_can_only_turn_back_are_named(tmp_path):
    text = road_net().replace('toLane="1" via=":m_0_0" dir="s"', 'toLane="1" via=":m_0_0" dir="t"')
    said = "1 lane that ends at a junction and doesn't lead on"
    assert any(x.startswith(said) for x in read_source(written(tmp_path, text)).left_out)
    assert not read_source(written(tmp_path, road_net())).left_out


def test_a_packed_network_and_a_part_of_one(tmp_path):
    path = tmp_path / "road.net.xml.gz"
    path.write_bytes(gzip.compress(road_net(proj="+proj=utm +zone=33 +ellps=WGS84").encode()))
    assert len(read_source(path).crossings) == 1
    with pytest.raises(ImportRefusal, match="has no roads in this region"):
        read_source(path, Region.around(60.17, 24.94, 100.0))
    with pytest.raises(ImportRefusal, match="doesn't say where on earth it lies"):
        read_source(written(tmp_path, road_net()), Region.around(60.17, 24.94, 100.0))


WHOLE = road_net()
DOCTYPE = WHOLE.replace("<net ", '<!DOCTYPE net [<!ENTITY a "b">]><net ')
BAD = {
    "cut off": (WHOLE[: len(WHOLE) // 2], "can't be read as a SUMO network"),
    "nothing": ("", "not XML that can be read"),
    "a document type": (DOCTYPE, "declares a document type"),
    "another root": ("<osm></osm>", "begins with <osm>, not with <net>"),
    "no roads": (road_net(car='allow="pedestrian"'), "has no roads"),
    "a word for a number": (WHOLE.replace('speed="8.33"', 'speed="fast"', 1), "can't be read as a SUMO network"),
    "no finite place": (WHOLE.replace("120.0,53.5", "nan,53.5"), "a place isn't finite"),
    "an unknown edge": (WHOLE.replace('to="east2"', 'to="nowhere"'), "can't be read as a SUMO network"),
    "an unknown lane": (WHOLE.replace('toLane="1"', 'toLane="7"'), "can't be read as a SUMO network"),
    "no junction": (WHOLE.replace('<junction id="m"', '<junction id="x"'), "junction m isn't in it"),
    "a broken point": (WHOLE.replace("120.0,53.5", "120.0"), "can't be read as a SUMO network"),
    "no lanes": ('<net version="1.20"></net>', "has no roads"),
    "far apart": (WHOLE.replace("240,", "90000000,"), "more than 12 km2"),
}  # fmt: skip


@pytest.mark.parametrize("text, message", BAD.values(), ids=BAD)
def test_a_bad_network_ends_in_one_message(tmp_path, text, message):
    path = written(tmp_path, text)
    with pytest.raises(ImportRefusal) as refusal:
        read_source(path)
    said = str(refusal.value)
    assert message in said and said.startswith(str(path)) and "\n" not in said and ";" in said


def test_a_packed_bomb_needs_little_memory(tmp_path, monkeypatch):
    monkeypatch.setattr("jaxwalk.maps.imported.sumo_reading.MOST_BYTES", 1_000_000)
    path = tmp_path / "bomb.net.xml.gz"
    path.write_bytes(gzip.compress(WHOLE.replace("</net>", " " * 50_000_000).encode()))
    tracemalloc.start()
    with pytest.raises(ImportRefusal, match="larger than 1,000,000 bytes"):
        read_source(path)
    assert tracemalloc.get_traced_memory()[1] < 20e6
    tracemalloc.stop()


def test_each_format_without_the_others_packages(tmp_path, monkeypatch):
    path = written(tmp_path, road_net())
    for name in ("osmium", "pyproj"):
        monkeypatch.setitem(sys.modules, name, None)
    assert read_source(path).crossings
    monkeypatch.setitem(sys.modules, "sumolib", None)
    with pytest.raises(ImportRefusal, match=r'needs sumolib; install it by: pip install "jaxwalk\[sumo\]"'):
        read_source(path)
