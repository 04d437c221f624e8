"""Streets without the parts that don't keep the rules of networks, and crossings that no tile has."""

import pytest

from jaxwalk.maps.imported.importing import CUT_OFF, import_street, import_tiles, read_source, report_of
from maps.imported.osm_files import OsmFile

ROAD = {"highway": "residential", "sidewalk": "both"}


def road(*crossings):
    """A road of 160 m to the east with zebras at some places [m]."""
    made = OsmFile()
    for x in crossings:
        made.node(x, 0.0, highway="crossing", crossing="zebra")
    return made.way((0.0, 0.0), *((x, 0.0) for x in crossings), (160.0, 0.0), **ROAD)


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return read_source(road(50.0, 110.0).write(tmp_path_factory.mktemp("osm") / "road.osm"))


@pytest.fixture
def street(source, monkeypatch):
    """Makes the street of the road, by other rules of networks than ours: what they find wrong with a network."""

    def make(faults):
        monkeypatch.setattr("jaxwalk.maps.imported.street_maker.network_faults", lambda network, **_: faults(network))
        return import_street(source, "road", strict=True)

    return make


def test_a_crossing_that_does_not_keep_the_rules_is_left_out_with_the_reason(street):
    made = street(lambda network: ["crossings[0].nodes: too steep"] if len(network.crossings) == 2 else [])
    assert made.report.usable and len(made.network.crossings) == 1
    assert [(x.placed, x.reason) for x in made.report.crossings] == [
        (False, "crossings[0].nodes: too steep"),
        (True, ""),
    ]


def test_a_route_that_does_not_keep_the_rules_is_left_out(street):
    assert len(street(lambda network: []).network.routes) == 2
    made = street(lambda network: ["routes[1]: too fast"] if len(network.routes) == 2 else [])
    assert made.report.usable and len(made.network.routes) == 1


@pytest.mark.parametrize(
    "fault, reason",
    [
        ("crossings[0]: too steep", "it has no crossing that can be used"),
        ("lanes[0]: too steep", "its parts don't keep the rules of maps"),
        ("walk.nodes: too many", "walk.nodes: too many"),
    ],
)
def test_a_street_whose_faults_remain_is_given_up_with_a_reason(street, fault, reason):
    made = street(lambda network: [fault])
    assert made.network is None and made.report.reasons == (reason,)


def test_a_crossing_that_no_tile_has_gets_a_street_about_it_and_a_reason_if_that_has_none(tmp_path):
    """It lies 0.3 m from where the road ends at the map's edge, which is no part of any street."""
    made = road(0.3).way((160.0, 0.0), (160.0, -50.0), **ROAD).way((160.0, 0.0), (160.0, 50.0), **ROAD)
    source = read_source(made.write(tmp_path / "road.osm"))
    streets = import_tiles(source, 200.0)
    assert [(x.report.name, x.report.crossings) for x in streets] == [("tile-002", ())]
    (outcome,) = report_of(source, streets, "road.osm", strict=False).crossings().values()
    assert (outcome.placed, outcome.reason) == (False, CUT_OFF)
