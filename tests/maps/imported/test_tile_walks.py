"""Jaywalk zones of imported streets: as long as there is room for, beside straight roads and around bends."""

import numpy as np
import pytest
import shapely

from jaxwalk.maps.imported.crossing_places import CrossingPlaces, RoadLines
from jaxwalk.maps.imported.kerb_ground import KerbGround
from jaxwalk.maps.imported.source_map import SourceCrossing, SourceMap
from jaxwalk.maps.imported.street_parts import street_areas
from jaxwalk.maps.imported.tile_walks import LENGTHS, ZoneFinder
from jaxwalk.maps.network import Network, WalkGraph
from jaxwalk.maps.network_scene import NetworkScene

STRAIGHT = np.array([(-100.0, 0.0), (100.0, 0.0)])
HALF, WIDTH = 4.0, 4.0
"""Half the width of the roadway, and the width of crossings [m]; people walk 1.25 m beside the roadway."""


def bend(radius, degrees=120.0):
    """The middle of a road around (0, 0), half of it to each side of the crossing in the east."""
    angle = np.radians(np.linspace(-degrees / 2, degrees / 2, 241))
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def finder(middle, points, *, lane=None, walks=None, pavement=None):
    """The zones of crossings at some points of a road, which has a lane along its middle unless another one is named.

    ``walks`` changes the lines of people, and ``pavement`` is the only ground that is sidewalk.
    """
    road = shapely.LineString(middle).buffer(HALF, cap_style="flat")
    region = road.buffer(8.0)
    ground = KerbGround.along(road).within(region.difference(shapely.MultiPoint(middle[[0, -1]]).buffer(8)))
    ground = ground if walks is None else ground._replace(walks=tuple(walks))
    places = CrossingPlaces(ground, region, RoadLines([middle]))
    for number, point in enumerate(points):
        assert places.place(SourceCrossing(f"{number}", "zebra", np.array(point, float), width=WIDTH)).placed
    ground = ground if pavement is None else ground._replace(pavement=ground.pavement.intersection(pavement))
    source = SourceMap("", "", region.bounds, (), np.zeros(0, bool), road, (), (), (), ())
    areas, _ = street_areas(source, region, ground, places.placed)
    network = Network((1, 1), (), tuple(areas), WalkGraph(np.zeros((0, 2)), np.zeros((0, 2), int), 0), (), ())
    lines = [shapely.LineString(middle if lane is None else lane)]
    return ZoneFinder(ground.walks, places.placed, NetworkScene.of(network), lines), places.placed


def zones(*args, **about):
    """How far each crossing's zone reaches from it [m], None without one."""
    found, placed = finder(*args, **about)
    made = [found.find(crossing) for crossing in placed]
    assert all(zone is None or (zone.begin == WIDTH / 2 + 1 and zone.end in LENGTHS) for zone in made)
    return [None if zone is None else zone.end for zone in made]


def walk(*points):
    return shapely.LineString(points)


def test_a_zone_is_as_long_as_there_is_room_between_crossings():
    """The middle one has 21 m to both sides, the others more to one side: zones of 24 m need 25 m."""
    assert zones(STRAIGHT, [(0, 0), (21, 0), (-21, 0)]) == [18, 24, 24]


def test_a_crossing_with_no_lane_near_it_has_no_zone():
    assert zones(STRAIGHT, [(0, 0)]) == [24]
    assert zones(STRAIGHT, [(0, 0)], lane=STRAIGHT + np.array((0, 30))) == [None]


@pytest.mark.parametrize(
    "north, length",
    [
        (walk((-10, 5.25), (25.2, 5.25)), 24),
        (walk((-10, 5.25), (24.7, 5.25)), 18),
        (walk((-10, 5.25), (24.3, 5.25)), 18),
        (walk((-10, 5.25), (10, 5.25), (10, 30)), 8),
    ],
    ids=["0.5 m beyond its end", "too little beyond its end", "ends within it", "bends away"],
)
def test_people_can_walk_along_both_sides_of_a_zone(north, length):
    """A zone's sides reach 0.5 m beyond it, and the lines of people 0.5 m more; to the west there are only 10 m."""
    assert zones(STRAIGHT, [(0, 0)], walks=[walk((-89, -5.25), (89, -5.25)), north]) == [length]


def test_a_zone_has_pavement_along_both_sides():
    """Which reaches 5 m to the west, and 15 m to the east."""
    assert zones(STRAIGHT, [(0, 0)], pavement=shapely.box(-5, -20, 15, 20)) == [12]


@pytest.mark.parametrize("radius, beside, length", [(60, 0, 24), (60, 1, 24), (45, 0, 24), (45, 1, 18), (30, 1, 12)])
def test_a_zone_goes_around_a_bend_with_its_road(radius, beside, length):
    """Its sides are measured along the lane, which may lie a metre outside the road's middle, and 0.5 m longer.

    In the road's middle they are shorter by radius / (radius + 1): (24 + 0.5) * 45 / 46 m are less than 24 m.
    """
    assert (length + 0.5) * radius / (radius + beside) > length
    found, (crossing,) = finder(bend(radius), [(radius, 0)], lane=bend(radius + beside))
    zone = found.find(crossing)
    assert zone.end == length
    sides = [
        shapely.get_coordinates(shapely.line_interpolate_point(found.walks[n], places))
        for n, places in zip(crossing.chord.walks, zone.places, strict=True)
    ]
    directions = [np.arctan2(side[:, 1], side[:, 0]) for side in sides]
    np.testing.assert_allclose(*directions, atol=2e-3, err_msg="places of both sides face each other")
    for side in sides:
        np.testing.assert_allclose(np.hypot(*side.T), np.hypot(*side[0]), atol=0.06)
