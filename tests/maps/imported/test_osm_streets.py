"""Streets of small OpenStreetMap files, whose lanes, crossings and sidewalks are known by hand."""

import json
from dataclasses import replace

import numpy as np
import pytest
import shapely

from jaxwalk.maps import load_map
from jaxwalk.maps.check_network import network_faults
from jaxwalk.maps.imported.importing import import_street, import_tiles, read_source, report_of
from jaxwalk.maps.imported.street_maker import DISTANCES
from jaxwalk.maps.network_file import network_text, parse_network
from jaxwalk.report.import_page import report_json, write_import_page
from maps.imported.osm_files import OsmFile, cross, divided


def imported(made, folder, *, strict=False, left=False):
    source = read_source(made.write(folder / "town.osm"), left=left)
    return source, import_street(source, "town", strict=strict)


@pytest.fixture(scope="module")
def crossing(tmp_path_factory):
    return imported(cross(), tmp_path_factory.mktemp("osm"))


def test_a_junction_with_four_zebras(crossing):
    source, street = crossing
    assert network_faults(street.network, **DISTANCES) == []
    assert [x.kind for x in street.network.crossings] == ["zebra"] * 4
    assert all(x.placed and x.moved == 0 for x in street.report.crossings)
    assert source.attribution == street.network.attribution == "© OpenStreetMap contributors, ODbL 1.0"
    assert street.report.verdict == "usable with inferred parts"
    middles = sorted(tuple(np.round(x.point, 1)) for x in source.crossings)
    assert middles == [(-14, 0), (0, -14), (0, 14), (14, 0)]


def test_its_lanes_are_where_tags_say(crossing):
    """Two lanes of 3 m: their middles lie 1.5 m to the right of the road's line."""
    _, street = crossing
    middle = np.array(street.network.size) / 2
    inside = [lane for lane in street.network.lanes if lane.length() > 60]
    assert len(inside) == 8
    for lane in inside:
        assert (lane.width, round(lane.speed_limit, 2)) == (3.0, 8.33)
        ahead = (lane.line[-1] - lane.line[0]) / lane.length()
        to_left = ahead[0] * (middle - lane.line)[:, 1] - ahead[1] * (middle - lane.line)[:, 0]
        np.testing.assert_allclose(to_left, 1.5, atol=0.05)


def test_every_arm_leads_to_the_three_others(crossing):
    _, street = crossing
    pairs = {(route.lanes[0], route.lanes[-1]) for route in street.network.routes}
    assert len(pairs) == 12
    whole = [shapely.union_all([street.network.areas[n].shape() for n in x.areas]) for x in street.network.crossings]
    lines = [shapely.LineString(street.network.route_line(route)) for route in street.network.routes]
    assert all(any(line.intersects(area) for line in lines) for area in whole)


def test_a_crosswalk_leads_from_kerb_to_kerb(crossing):
    _, street = crossing
    for number in (area for x in street.network.crossings for area in x.areas):
        assert street.network.areas[number].shape().area == pytest.approx(4 * 6, rel=0.02)


def test_sidewalks_are_inferred_from_the_roads_tags(crossing):
    _, street = crossing
    pavement = street.report.pavement
    assert pavement.mapped == pavement.invented == 0
    assert pavement.parts_after == 1 and pavement.kept == pytest.approx(pavement.known)
    assert pavement.parts_before >= 1 and pavement.known > 4 * 2 * 80


def test_people_may_jaywalk_beside_the_crosswalks(crossing):
    assert crossing[1].report.counts["crossings with a jaywalk zone"] == 4


def test_the_street_can_be_loaded_and_comes_back_from_its_file(crossing, tmp_path):
    _, street = crossing
    text = network_text(street.network)
    assert network_text(parse_network(text, "again")) == text
    path = tmp_path / "street.json"
    path.write_text(text, encoding="utf-8")
    assert load_map(path).route_count == len(street.network.routes)


def test_a_divided_road_has_an_island(tmp_path):
    _, street = imported(divided(), tmp_path)
    (found,) = street.network.crossings
    assert found.kind == "signals" and len(found.areas) == 2 and len(found.nodes) == 5
    assert street.report.signals == ("way 3",)
    gap = 12 - 6.5
    island = next(area for area in street.network.areas if area.kind == "island")
    height = np.ptp(island.outline[:, 1])
    assert height == pytest.approx(gap, abs=0.1)


def test_nothing_is_invented_if_that_is_forbidden(tmp_path):
    made = cross(sidewalk="no")
    _, street = imported(made, tmp_path)
    assert street.report.pavement.invented > 600 and street.report.usable
    assert any("invented" in reason for reason in street.report.reasons)
    assert any("the sidewalks: 100%" in advice for advice in street.report.advice)
    _, street = imported(made, tmp_path, strict=True)
    assert street.network is None and street.report.verdict == "not usable"


def test_mapped_sidewalks_are_mapped(tmp_path):
    made = OsmFile()
    made.node(0, 0, highway="crossing", crossing="unmarked")
    made.way((-100, 0), (0, 0), (100, 0), highway="tertiary", width="7", lanes="2")
    for y in (-6, 6):
        made.way((-100, y), (100, y), highway="footway", footway="sidewalk")
    _, street = imported(made, tmp_path, strict=True)
    assert street.report.verdict == "usable" and street.report.pavement.inferred == 0
    assert street.network.crossings[0].kind == "unmarked"


def test_crossings_are_invented_where_people_would_be_cut_off(tmp_path):
    """Without the zebras of two arms, the sidewalk between those has no way to the others."""
    made = cross()
    for number, tags in made.node_tags.items():
        x, y = next(place for place, own in made.nodes.items() if own == number)
        if tags and (x > 0 or y > 0):
            tags.clear()
    _, street = imported(made, tmp_path)
    origins = [x.origin for x in street.report.facts]
    assert sorted(origins) == ["invented", "mapped", "mapped"]
    (repair,) = [repair for repair in street.report.repairs if "joins" in repair.what]
    assert 8 < repair.metres < 12  # 6 m of roadway, and half the pavement on both sides
    assert any("the crossings at" in advice for advice in street.report.advice)
    _, street = imported(made, tmp_path, strict=True)
    assert [x.origin for x in street.report.facts] == ["mapped", "mapped"]
    assert street.report.pavement.kept < street.report.pavement.known


def test_parking_and_houses_are_there_to_hide_people(tmp_path):
    made = cross(parking_right="lane")
    made.way((20, 20), (40, 20), (40, 40), (20, 40), (20, 20), building="yes")
    _, street = imported(made, tmp_path)
    assert street.report.counts["parking strips"] >= 4 and street.report.counts["buildings"] == 1
    widths = [np.ptp(area.outline, axis=0).min() for area in street.network.areas if area.kind == "parking"]
    np.testing.assert_allclose(widths, 2.0, atol=0.05)


def test_traffic_that_keeps_left(tmp_path):
    source, street = imported(cross(), tmp_path, left=True)
    assert source.mirrored and network_faults(street.network, **DISTANCES) == []
    middle = np.array(street.network.size) / 2
    for lane in (lane for lane in street.network.lanes if lane.length() > 60):
        ahead = (lane.line[-1] - lane.line[0]) / lane.length()
        to_left = ahead[0] * (middle - lane.line)[:, 1] - ahead[1] * (middle - lane.line)[:, 0]
        np.testing.assert_allclose(to_left, -1.5, atol=0.05)


def test_tiles_meet_every_crossing(tmp_path):
    """A road of 600 m with a crossing every 100 m, in tiles of 200 m."""
    made = OsmFile()
    places = [(float(x), 0.0) for x in range(-300, 301, 50)]
    for x, y in places[1::2]:
        made.node(x, y, highway="crossing", crossing="zebra")
    made.way(*places, **{"highway": "residential", "sidewalk": "both"})
    source = read_source(made.write(tmp_path / "long.osm"))
    streets = import_tiles(source, 200.0)
    report = report_of(source, streets, "long.osm", strict=False)
    assert len(report.crossings()) == 6 and all(x.placed for x in report.crossings().values())
    assert 3 <= len(streets) <= 6 and all(street.report.usable for street in streets)
    assert max(max(street.network.size) for street in streets) == 200


def test_the_report_as_a_page_and_as_json(crossing, tmp_path):
    source, street = crossing
    named = replace(street.report, name="<b>town</b>")
    report = report_of(source, [street._replace(report=named)], "<i>.osm", strict=False)
    write_import_page(tmp_path / "report.html", report, {named.name: street.network})
    page = (tmp_path / "report.html").read_text()
    assert "&lt;b&gt;town&lt;/b&gt;" in page and "<b>town</b>" not in page and "<i>.osm" not in page
    assert "4 of 4" in page and source.attribution in page and "data:image/png;base64," in page
    document = json.loads(report_json(report))
    assert document["schema"] == 1 and len(document["crossings"]) == 4
    assert {x["origin"] for x in document["streets"][0]["kerbsides"]} <= {"inferred", "joined"}
    assert {element["width_from"] for element in document["elements"]} == {"mapped"}
