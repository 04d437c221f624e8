"""What OpenStreetMap files say, before a street is made of it: crossings, ends of roads, parking, what is left out."""

import numpy as np
import pytest

from jaxwalk.maps.imported.importing import read_source
from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.region import Region
from maps.imported.osm_files import OsmFile

ROAD = {"highway": "residential"}


@pytest.fixture
def read(tmp_path):
    """Reads a file that a test has made."""
    return lambda made, **about: read_source(made.write(tmp_path / "town.osm"), **about)


def road(*more):
    """A road of 100 m to the east, with a node in its middle, and other ways: their points and tags."""
    made = OsmFile().way((0, 0), (50, 0), (100, 0), **ROAD)
    for points, tags in more:
        made.way(*points, **tags)
    return made


def footway(*points, **tags):
    return points, {"highway": "footway", "footway": "crossing"} | tags


def test_a_node_where_crossing_is_forbidden_is_no_crossing(read):
    made = road()
    made.node(50, 0, highway="crossing", crossing="no")
    assert read(made).crossings == ()


@pytest.mark.parametrize(
    "way, names",
    [
        (footway((50, -10), (50, 10)), ["way 2"]),
        (footway((50, -10), (50, 10), crossing="no"), []),
        (footway((50, -10), (50, 1)), []),
        (footway((10, -10), (10, 10), (30, 10), (30, -10)), ["way 2", "way 2 (2)"]),
    ],
    ids=["over the road", "where it is forbidden", "only to the road", "over and back"],
)
def test_a_footway_is_a_crossing_where_it_leads_over_a_road(read, way, names):
    assert [x.name for x in read(road(way)).crossings] == names


def test_a_footway_over_a_junction_is_one_crossing(read):
    """It meets the three roads of the junction in one place, 30 m to the south of the map's middle."""
    aside = ((50, 0), (50, 60)), ROAD
    (found,) = read(road(aside, footway((42, -8), (50, 0), (58, 8)))).crossings
    np.testing.assert_allclose(found.point, (0, -30), atol=0.01)


@pytest.mark.parametrize(
    "tags, what",
    [
        ({"railway": "tram"}, "tracks"),
        ({"highway": "cycleway"}, "cycleways"),
        ({"highway": "service"}, "service roads"),
        ({"highway": "footway"}, "paths"),
        ({"highway": "track"}, "other ways"),
    ],
)
def test_crossings_of_what_is_not_imported_are_counted_by_what_they_cross(read, tags, what):
    made = road((((0, 20), (50, 20), (100, 20)), tags))
    made.node(50, 20, highway="crossing")
    source = read(made)
    assert source.crossings == () and source.elsewhere == {what: 1}


@pytest.mark.parametrize("beyond, open_ends", [("", 5), ("footway", 5), ("track", 6)])
def test_a_dead_end_inside_the_map_is_open_if_a_road_that_is_not_imported_goes_on(read, beyond, open_ends):
    """Roads end at the map's edge in five places; another one ends 50 m inside."""
    made = road((((50, 0), (50, -100)), ROAD), (((0, 100), (100, 100)), ROAD))
    made.way((50, 0), (50, 50), **ROAD)
    if beyond:
        made.way((50, 50), (50, 70), highway=beyond)
    assert len(read(made).open_ends) == open_ends


@pytest.mark.parametrize("metres, strips", [(44, 2), (34, 0)])
def test_a_short_road_between_junctions_has_no_parking(read, metres, strips):
    """A junction's mouth is 8 m long: 3 m of road and the kerb's arc of 5 m. Nobody parks within 8 m of it.

    So 12 m or 2 m are left, and a strip has at least 6 m.
    """
    made = OsmFile().way((0, 0), (metres, 0), **ROAD, parking_both="lane")
    for x, end in ((0, -80), (metres, metres + 80)):
        made.way((x, 0), (end, 0), **ROAD).way((x, 0), (x, 50), **ROAD)
    assert len(read(made).parking) == strips


@pytest.mark.parametrize(
    "corners, count",
    [
        ([(10, 20), (14, 20), (14, 24), (10, 24)], 1),
        ([(10, 20), (13, 20), (13, 23), (10, 23)], 0),
        ([(10, 20), (20, 30), (20, 20), (10, 30)], 0),
        ([(10, 20), (30, 20)], 0),
    ],
    ids=["16 m2", "9 m2: too small", "an outline that crosses itself", "a line"],
)
def test_buildings_are_sound_outlines_of_at_least_12_m2(read, corners, count):
    made = road(([*corners, corners[0]], {"building": "yes"}))
    assert len(read(made).buildings) == count


def test_ways_that_are_not_imported_are_named_with_the_reason(read):
    track, yard = ((0, 20), (50, 20)), ((0, 40), (50, 40))
    made = road((track, {"highway": "track"}), (yard, ROAD | {"access": "private"}), (yard, {"highway": "footway"}))
    assert read(made).left_out == (
        "1 way with highway=residential: private, closed, or an area",
        "1 way with highway=track: not among the roads that are imported",
    )


def test_nodes_that_the_file_lacks_are_counted(tmp_path):
    path = road().write(tmp_path / "town.osm")
    path.write_text(path.read_text().replace('<nd ref="1"/>', '<nd ref="1"/><nd ref="77"/>'))
    (said,) = read_source(path).left_out
    assert said == "1 reference to nodes that the file doesn't have: parts of ways are missing"


def test_a_road_of_which_only_one_node_is_known_is_left_out(read):
    made = road((((30, 30), (30, 30)), ROAD))
    assert [x["element"] for x in read(made).elements] == ["way 1"]


def test_a_file_of_too_many_bytes_is_refused(tmp_path, monkeypatch):
    path = road().write(tmp_path / "town.osm")
    monkeypatch.setattr("jaxwalk.maps.imported.osm_reading.MOST_BYTES", {".osm": 100})
    with pytest.raises(ImportRefusal, match=r"town\.osm: larger than 100 bytes; cut a part out"):
        read_source(path)


def test_a_box_is_a_region():
    assert Region.of_box((24.9, 60.1, 25.0, 60.2)) == Region(west=24.9, south=60.1, east=25.0, north=60.2)


def test_side_roads_that_almost_face_each_other_are_one_junction(read):
    """The 6 m between them are within the junction: from each of its four roads cars reach the three others."""
    made = OsmFile().way((-100, 0), (0, 0), (6, 0), (100, 0), **ROAD)
    made.way((0, 0), (0, 80), **ROAD).way((6, 0), (6, -80), **ROAD)
    assert ways_on(read(made)) == [3, 3, 3, 3]


def test_a_turn_that_would_leave_the_roadway_follows_the_roads_within_the_junction(read):
    """Side roads 12 m apart that lean to the west: the way straight from one to the other leaves the roadway."""
    made = OsmFile().way((-100, 0), (0, 0), (12, 0), (100, 0), **ROAD, width="9")
    for x, side, degrees in ((0, 1, 115), (12, -1, 100)):
        radians = np.radians(degrees)
        made.way((x, 0), (round(x + 80 * side * np.cos(radians), 2), round(80 * side * np.sin(radians), 2)), **ROAD)
    assert ways_on(read(made)) == [3, 3, 3, 3]


def test_no_car_drives_against_a_one_way_road_within_a_junction(read):
    """As before, but the 6 m may only be driven to the east: the road in the east leads nowhere but to the south.

    From the road in the north cars reach the three others, from that in the south only the one in the east.
    """
    made = OsmFile().way((-100, 0), (0, 0), **ROAD).way((0, 0), (6, 0), **ROAD, oneway="yes")
    made.way((6, 0), (100, 0), **ROAD).way((0, 0), (0, 80), **ROAD).way((6, 0), (6, -80), **ROAD)
    assert ways_on(read(made)) == [1, 1, 3, 3]


def ways_on(source):
    """For each lane that ends at the only junction: how many others it leads to."""
    assert len(source.junctions) == 1
    outside = [lane for lane, inside in zip(source.lanes, source.in_junction, strict=True) if not inside]
    return sorted(len(lane.successors) for lane in outside if lane.successors)


@pytest.mark.parametrize("angle, turns", [(60, 0), (50, 1)])
def test_a_turn_without_room_is_left_out_and_named(read, angle, turns):
    """A side road at an angle [degrees]: with 50, to turn back into it to the right is too tight."""
    radians = np.radians(angle)
    aside = (round(80 * np.cos(radians), 3), round(80 * np.sin(radians), 3))
    source = read(OsmFile().way((-100, 0), (0, 0), (100, 0), **ROAD).way((0, 0), aside, **ROAD))
    named = ("1 turn at junctions: too tight (a radius below 4.7 m), too sharp, or off the roadway",) * turns
    assert source.in_junction.sum() == 6 - turns and source.left_out == named


SQUARE = ((0, 0), (30, 0), (30, 30), (0, 30), (0, 0))
"""Anticlockwise, as traffic that keeps right goes round."""


@pytest.mark.parametrize("points, side, other", [(SQUARE, "right", "left"), (SQUARE[::-1], "left", "right")])
def test_roundabouts_tell_on_which_side_traffic_keeps(read, points, side, other):
    made = OsmFile()
    for aside in (0, 100):
        made.way(*((x + aside, y) for x, y in points), **ROAD, junction="roundabout")
    assert read(made, left=side == "left").mirrored == (side == "left")
    with pytest.raises(ImportRefusal, match=f"by its roundabouts.*traffic keeps {side} there, not {other}"):
        read(made, left=side == "right")


@pytest.mark.parametrize("most, asked", [(4, True), (3, False)])
def test_a_divided_road_of_too_many_pieces_is_not_asked_for_the_side(read, monkeypatch, most, asked):
    """Two one-way roads of two pieces each, whose opposite direction lies to the left."""
    monkeypatch.setattr("jaxwalk.maps.imported.osm_mirror.MOST_PIECES", most)
    made = OsmFile().way((0, 0), (40, 0), (80, 0), **ROAD, oneway="yes", name="Wide")
    made.way((80, 12), (40, 12), (0, 12), **ROAD, oneway="yes", name="Wide")
    if not asked:
        assert read(made, left=True).mirrored
        return
    with pytest.raises(ImportRefusal, match=r"divided roads.*traffic keeps right there, not left"):
        read(made, left=True)
