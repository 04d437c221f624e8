"""What is drawn of a street: its surfaces where they are, stripes along the traffic, lines between lanes."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from jaxwalk.maps import load_network
from jaxwalk.viewer.drawn_map import EXACT, SURFACES, DrawnMap
from jaxwalk.viewer.ground import COLOURS, draw_ground
from jaxwalk.viewer.replay import part
from maps.networks import island, turned

TOWN = "test-2000000003"
"""Two junctions, an island, parking strips, crossings with and without stripes."""


@pytest.fixture(scope="module", params=["paper", TOWN])
def network(request):
    return load_network(request.param)


@pytest.fixture(scope="module")
def drawn(network):
    return DrawnMap.of(network)


def shape(outlines):
    """Outlines as one surface; those of holes go the other way round."""
    rings = [shapely.LinearRing(np.reshape(outline, (-1, 2))) for outline in outlines]
    solid = shapely.union_all([shapely.Polygon(ring) for ring in rings if ring.is_ccw])
    return solid.difference(shapely.union_all([shapely.Polygon(ring) for ring in rings if not ring.is_ccw]))


def lines(each):
    return [np.reshape(line, (-1, 2)) for line in each]


def test_surfaces_are_those_of_the_street(drawn, network):
    assert (drawn.width, drawn.height) == network.size
    assert tuple(drawn.surfaces) == SURFACES
    for kind in SURFACES[:-1]:
        assert shape(drawn.surfaces[kind]).hausdorff_distance(network.surface(kind)) < 2 * EXACT or not network.surface(
            kind
        )


def test_stripes_cover_half_of_the_crosswalks_and_lie_along_the_lanes(drawn, network):
    painted = [n for crossing in network.crossings if crossing.kind != "unmarked" for n in crossing.areas]
    crosswalks = shapely.union_all([network.areas[n].shape() for n in painted])
    stripes = [shapely.Polygon(outline) for outline in lines(drawn.stripes)]
    assert shapely.union_all(stripes).difference(crosswalks.buffer(2 * EXACT)).is_empty
    assert sum(stripe.area for stripe in stripes) / crosswalks.area == pytest.approx(0.5, abs=0.07)
    long = [stripe for stripe in stripes if stripe.area > 1.5]
    assert len(long) > len(stripes) / 2
    for stripe in long:
        corners = np.array(stripe.minimum_rotated_rectangle.exterior.coords)[:3]
        one, two = np.diff(corners, axis=0)
        longer = max(one, two, key=np.linalg.norm)
        lane = min(network.lanes, key=lambda x: shapely.LineString(x.line).distance(stripe.centroid))
        way = shapely.LineString(lane.line)
        at = way.project(stripe.centroid)
        ahead = np.subtract(*(way.interpolate(at + by).coords[0] for by in (0.2, -0.2)))
        assert abs(longer @ ahead) / np.linalg.norm(longer) / np.linalg.norm(ahead) > 0.97


def test_lines_lie_between_lanes_off_kerbs_and_crosswalks(drawn, network):
    middles = shapely.union_all([shapely.LineString(lane.line) for lane in network.lanes])
    apart = network.surface("crosswalk", "sidewalk", "island", "parking")
    assert len(drawn.dashed) >= 4
    for line in lines(drawn.dashed):
        whole = shapely.LineString(line)
        assert network.surface("roadway").covers(whole)
        assert whole.distance(apart) > 0.5
        assert shapely.distance(shapely.points(line), middles).min() > 1.2


def test_the_papers_centre_lines_lie_in_the_middle(drawn):
    middle = shapely.MultiLineString([[(0, 56), (120, 56)], [(56, 0), (56, 120)], [(60, 86), (120, 86)]])
    for line in lines(DrawnMap.of(load_network("paper")).dashed):
        assert shapely.LineString(line).distance(middle) < EXACT and len(line) == 2


def test_crossings_without_stripes_are_dotted():
    network = load_network(TOWN)
    unmarked = sum(len(crossing.areas) for crossing in network.crossings if crossing.kind == "unmarked")
    assert unmarked and len(DrawnMap.of(network).dotted) == 2 * unmarked


def test_a_turned_street_is_drawn_turned():
    other, turn = turned(island(), 0.7)
    one, two = DrawnMap.of(island()), DrawnMap.of(other)
    assert len(one.stripes) == len(two.stripes) > 4
    places = [turn(shapely.get_coordinates(shapely.Polygon(x).centroid))[0] for x in lines(one.stripes)]
    centres = shapely.MultiPoint([shapely.Polygon(x).centroid for x in lines(two.stripes)])
    assert max(centres.distance(shapely.Point(place)) for place in places) < 3 * EXACT


def test_a_picture_has_the_colours_of_all_surfaces(network, drawn):
    figure = Figure(figsize=(8, 8))
    canvas = FigureCanvasAgg(figure)
    draw_ground(figure.add_subplot(), network)
    canvas.draw()
    seen = np.array(canvas.buffer_rgba())[..., :3]
    for kind, colour in COLOURS.items():
        there = (seen == np.array(to_rgb(colour)) * 255).all(axis=-1).any()
        assert there == bool(drawn.surfaces[kind]), kind


def test_pages_have_a_colour_for_each_surface():
    style = part("player.css")
    assert all(style.count(f"--{kind}:") == 2 for kind in SURFACES), "light and dark"
    assert tuple(COLOURS) == SURFACES
    assert 'const SURFACES = ["' + '", "'.join(SURFACES) + '"];' in part("drawing.js")
