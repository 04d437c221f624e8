"""Parts of SUMO networks that are left out, or count for something else than roads and crossings for cars."""

import numpy as np
import pytest

from jaxwalk.maps.imported.importing import read_source
from maps.imported.sumo_nets import road_net
from maps.imported.written_maps import written_as


@pytest.fixture
def read(tmp_path):
    """Reads the text of a network."""
    return lambda text: read_source(written_as(tmp_path, text, "road.net.xml"))


def edge(who, y, x=(0, 116), about=""):
    """An edge of one lane beside the road, up to its junction."""
    lane = (
        f'<lane id="more_0" index="0" allow="{who}" speed="10" length="116" width="3" shape="{x[0]},{y} {x[1]},{y}"/>'
    )
    return f'<edge id="more" from="w" to="m" {about}>{lane}</edge>'


def road_with(*parts, **about):
    """The road with more elements."""
    return road_net(**about).replace("</net>", "\n".join(parts) + "</net>")


BACK = '<connection from="east1" to="west2" fromLane="1" toLane="1" dir="l" state="M"/>'


@pytest.mark.parametrize(
    "text, said",
    [
        (road_with(edge("all", 60, about='type="highway.motorway"')), "1 edge of motorways: not among the roads that "),
        (road_net(car='allow="passenger pedestrian"'), "people on the roadway of 4 edges: here they walk beside it"),
        (road_with(edge("bus", 60)), "the lanes of 1 edge where no car may drive: they are roadway, on which nobody"),
        (road_with(BACK), "1 turn at junctions: too tight (a radius below 4.7 m), too sharp, or off the roadway"),
    ],
    ids=["a motorway", "people on the road", "a lane for buses", "a turn without room"],
)
def test_what_is_left_out_is_named(read, text, said):
    assert [x[: len(said)] for x in read(text).left_out if x.startswith(said[:12])] == [said]
    assert not read(road_net()).left_out


@pytest.mark.parametrize("who, what", [("tram", "tracks"), ("bicycle", "other ways")])
def test_crossings_of_what_is_no_road_are_only_counted(read, who, what):
    text = road_with(edge(who, 60)).replace('crossingEdges="east1 west2"', 'crossingEdges="more"')
    source = read(text)
    assert source.crossings == () and source.elsewhere == {what: 1}
    assert len(read(road_net()).crossings) == 1 and read(road_net()).elsewhere == {}


def test_a_walking_area_without_a_surface_says_nothing_of_sidewalks(read):
    """The road's four sidewalks and two walking areas, of which one has only two corners."""
    shape = road_net().split('id=":m_w0_0"')[1].split('shape="')[1].split('"')[0]
    assert len(read(road_net()).evidence) == 6
    assert len(read(road_net().replace(shape, " ".join(shape.split(" ")[:2]))).evidence) == 5


def test_a_lane_without_length_is_no_ground(read):
    plain, more = read(road_net()), read(road_with(edge("bus", 46, x=(100, 100))))
    assert more.roadway.equals(plain.roadway) and len(more.lanes) == len(plain.lanes)
    np.testing.assert_allclose(more.extent, plain.extent)
