"""Files that can't be imported: each ends in one message, and needs little memory."""

import gzip

import pytest

from jaxwalk.maps.imported.importing import import_street, import_tiles, read_source
from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.region import Region
from maps.imported.osm_files import OsmFile, cross

BOMB = (
    '<?xml version="1.0"?><!DOCTYPE osm [<!ENTITY a "aaaaaaaaaa">'
    + "".join(f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 9)).replace("&a0;", "&a;")
    + ']><osm version="0.6"><node id="1" lat="0" lon="0"><tag k="a" v="&a8;"/></node></osm>'
)
HALF = cross().text()
NO_NODES = """<?xml version="1.0"?><osm version="0.6"><way id="1"><nd ref="5"/><nd ref="6"/>
<tag k="highway" v="primary"/></way></osm>"""
BAD = {
    "cut off": ("a.osm", HALF[: len(HALF) // 2].encode(), "can't be read as OpenStreetMap data"),
    "nothing": ("a.osm", b"", "not XML that can be read"),
    "no XML": ("a.osm", b"PK\x03\x04 something else", "not XML that can be read"),
    "an entity bomb": ("a.osm", BOMB.encode(), "declares a document type"),
    "a packed one": ("a.osm.gz", gzip.compress(BOMB.encode()), "not a format that is known by its name"),
    "no PBF": ("a.osm.pbf", b"\x00\x00\x00\x0d nonsense nonsense", "can't be read as OpenStreetMap data"),
    "PBF cut off": ("a.osm.pbf", b"\x00\x00", "can't be read as OpenStreetMap data"),
    "no roads": ("a.osm", OsmFile().way((0, 0), (9, 9), highway="footway").text().encode(), "has no roads"),
    "ways without nodes": ("a.osm", NO_NODES.encode(), "has no roads"),
    "nowhere on earth": ("a.osm", HALF.replace('lat="60', 'lat="160').encode(), "has no roads"),
    "a place without numbers": (
        "a.osm",
        HALF.replace('lat="60', 'lat="" alt="60').encode(),
        "can't be read as OpenStreetMap",
    ),
    "another format": ("a.txt", b"", "not a format that is known by its name"),
}


@pytest.mark.parametrize("name, content, message", BAD.values(), ids=BAD)
def test_a_bad_file_ends_in_one_message(tmp_path, name, content, message):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ImportRefusal) as refusal:
        read_source(path)
    said = str(refusal.value)
    assert message in said and said.startswith(str(path)) and "\n" not in said and ";" in said


def test_a_missing_file(tmp_path):
    with pytest.raises(ImportRefusal, match="no such file"):
        read_source(tmp_path / "nowhere.osm")


def test_a_region_without_roads_and_impossible_ones(tmp_path):
    path = cross().write(tmp_path / "cross.osm")
    with pytest.raises(ImportRefusal, match="has no roads in this region"):
        read_source(path, Region.around(-33.9, 18.4, 200.0))
    for wrong in ((91.0, 0.0, 100.0), (0.0, 181.0, 100.0), (0.0, 0.0, 1.0), (0.0, 0.0, float("nan"))):
        with pytest.raises(ImportRefusal):
            Region.around(*wrong)
    for box in ((1.0, 2.0, 0.0, 3.0), (0.0, 2.0, 1.0, 2.0), (0.0, float("inf"), 1.0, 2.0)):
        with pytest.raises(ImportRefusal, match="--bbox"):
            Region.of_box(box)


def test_a_part_of_a_map(tmp_path):
    path = cross(arm=600.0).write(tmp_path / "cross.osm")
    with pytest.raises(ImportRefusal, match="too large for one street"):
        import_street(read_source(path), "cross")
    street = import_street(read_source(path, Region.around(60.17, 24.94, 100.0)), "cross")
    assert street.report.usable and max(street.network.size) < 225


def test_too_large_an_area(tmp_path):
    made = OsmFile().way((0, 0), (5000, 0), (5000, 5000), highway="primary")
    with pytest.raises(ImportRefusal, match="more than 12 km2; name a part"):
        read_source(made.write(tmp_path / "large.osm"))


def test_no_crossing_is_mapped(tmp_path):
    made = OsmFile().way((0, 0), (200, 0), highway="primary", sidewalk="both")
    source = read_source(made.write(tmp_path / "road.osm"))
    with pytest.raises(ImportRefusal, match="no crossing is mapped"):
        import_tiles(source)
    street = import_street(source, "road")
    assert street.report.usable and [x.origin for x in street.report.facts] == ["invented"]


def test_the_other_side(tmp_path):
    made = cross(driving_side="left").write(tmp_path / "cross.osm")
    made.write_text(made.read_text().replace("driving:side", "driving_side"))
    with pytest.raises(ImportRefusal, match="traffic keeps left there, not right; add --traffic left"):
        read_source(made)
    assert read_source(made, left=True).mirrored


STRANGE = {
    "a loop": OsmFile().way((0, 0), (60, 0), (60, 60), (0, 60), (0, 0), highway="residential", sidewalk="both"),
    "one point twice": OsmFile().way((0, 0), (0, 0), (80, 0), highway="residential", sidewalk="both"),
    "there and back": OsmFile().way((0, 0), (80, 0), (40, 0), (0, 0), highway="residential", sidewalk="both"),
    "hairpins": OsmFile().way(*[(float(60 * (n % 2)), 3.0 * n) for n in range(20)], highway="residential"),
    "two ways in one place": OsmFile().way((0, 0), (80, 0), highway="primary").way((80, 0), (0, 0), highway="primary"),
    "a bow": OsmFile().way((0, 0), (80, 80), (80, 0), (0, 80), highway="residential", sidewalk="both"),
    "wild numbers": OsmFile().way((0, 0), (80, 0), highway="primary", lanes="1e9", width="-3", maxspeed="9" * 400),
    "dust": OsmFile().way((0, 0), (0.01, 0), highway="primary").way((0, 9), (50, 9), highway="primary"),
}


@pytest.mark.parametrize("made", STRANGE.values(), ids=STRANGE)
def test_strange_roads_give_a_street_or_say_why_not(tmp_path, made):
    street = import_street(read_source(made.write(tmp_path / "strange.osm")), "strange")
    assert street.report.usable or street.report.reasons
