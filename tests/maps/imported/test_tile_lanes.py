"""Lanes and routes of imported streets."""

import numpy as np
import pytest
import shapely

from jaxwalk.maps.imported.source_map import SourceMap
from jaxwalk.maps.imported.tile_lanes import (
    LONGEST_DRIVE,
    LONGEST_ROUTE,
    ORACLE_LEVEL,
    RouteFinder,
    lanes_within,
    without_lanes,
)
from jaxwalk.maps.network import Lane
from jaxwalk.policies.oracle import LEVEL


def lane(begin, end, limit, *after):
    """A lane to the east, with its speed limit [km/h]."""
    return Lane(np.array([(begin, 0.0), (end, 0.0)]), 3.5, limit / 3.6, after)


def ends(route, lanes):
    """Where a route begins and ends [m]."""
    first, last = (lanes[route.lanes[n]].line[0, 0] for n in (0, -1))
    return first + route.start, last + route.goal


@pytest.mark.parametrize(
    "limit, longest", [(50, LONGEST_ROUTE), (30, LONGEST_ROUTE), (20, 200), (15, 400 / 3), (10, 200 / 3)]
)
def test_a_long_road_is_cut_by_metres_and_by_time(limit, longest):
    """40 s at the largest multiple of 6 km/h within the limit: 18, 12 and 6 km/h."""
    lanes = [lane(0, 500, limit)]
    routes, _ = RouteFinder(lanes).routes([])
    places = np.array([ends(route, lanes) for route in routes])
    np.testing.assert_allclose(places[:, 1] - places[:, 0], longest)
    assert (places[1:, 0] < places[:-1, 1]).all() and places[0, 0] < 10 and places[-1, 1] > 490


def test_a_slow_part_of_a_road_makes_routes_shorter_there_only():
    """Two lanes of 500 m: each route takes at most 40 s and 220 m."""
    lanes = [lane(0, 500, 50, 1), lane(500, 1000, 10)]
    routes, _ = RouteFinder(lanes).routes([])
    for begin, end in (ends(route, lanes) for route in routes):
        fast, slow = max(min(end, 500) - begin, 0), max(end - max(begin, 500), 0)
        assert fast + slow <= LONGEST_ROUTE + 1e-6 and fast / (50 / 3.6) + slow / (6 / 3.6) <= LONGEST_DRIVE + 1e-6
    assert max(end - begin for begin, end in (ends(route, lanes) for route in routes)) == pytest.approx(LONGEST_ROUTE)


def test_routes_are_planned_in_the_levels_of_the_oracle():
    np.testing.assert_allclose(ORACLE_LEVEL, LEVEL, rtol=1e-3)


def loop(side):
    """Four lanes around a square, each of which leads to the next: none begins or ends at a street's edge."""
    corners = side * np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)], float)
    return [Lane(corners[n : n + 2], 3.5, 30 / 3.6, ((n + 1) % 4,)) for n in range(4)]


def test_a_crossing_of_a_closed_road_has_a_route_from_and_to_some_way_around_it():
    """Half-way along the third of four lanes of 50 m, which is 125 m from the begin of the first one.

    The route begins with the first lane that begins at least 80 m before the third one, but at most 110 m before the
    crossing; it ends 1 m before the end of the road, where it would meet itself.
    """
    (route,), met = RouteFinder(loop(50.0)).routes([[shapely.box(20, 45, 30, 55)]])
    assert met == [True] and route.lanes == (0, 1, 2, 3)
    assert (route.start, route.goal) == pytest.approx((125 - 110, 50 - 1))


@pytest.mark.parametrize(
    "lanes, crosswalk",
    [(loop(9.0), shapely.box(3, 8, 6, 10)), ([lane(0, 500, 30)], shapely.box(3, -2, 5, 2))],
    ids=["on a closed road of 36 m", "3 m after the begin of its only road"],
)
def test_a_crossing_may_have_no_route(lanes, crosswalk):
    """Routes are at least 40 m long, and meet a crossing at least 8 m after their start."""
    assert RouteFinder(lanes).routes([[crosswalk]])[1] == [False]


def test_of_two_ways_to_a_lane_the_shorter_one_is_taken():
    """From the first lane to the last by the second one, half a circle, or straight on by the third one."""
    angle = np.linspace(np.pi, 0, 31)
    half_circle = np.stack([60 + 10 * np.cos(angle), 10 * np.sin(angle)], axis=1)
    lanes = [lane(0, 50, 30, 1, 2), Lane(half_circle, 3.5, 8.0, (3,)), lane(50, 70, 30, 3), lane(70, 120, 30)]
    (route,), _ = RouteFinder(lanes).routes([])
    assert route.lanes == (0, 2, 3)


def source(lanes, in_junction):
    """A source map of lanes, of which some lead through junctions."""
    ground = shapely.box(0, -3, 300, 3)
    return SourceMap("", "", (0, -3, 300, 3), tuple(lanes), np.array(in_junction), ground, (), (), (), ())


def test_a_lane_through_a_junction_is_wholly_in_a_street_or_left_out_with_what_leads_to_it():
    """Lanes from 0 to 100 m, from there over a junction to 120 m, and on to 300 m."""
    whole = source([lane(0, 100, 30, 1), lane(100, 120, 30, 2), lane(120, 300, 30)], [False, True, False])
    lengths = {}
    for edge in (200, 110):
        region = shapely.box(0, -3, edge, 3)
        lanes, inside = lanes_within(whole, region, region)
        lengths[edge] = [(x.length(), bool(y)) for x, y in zip(lanes, inside, strict=True)]
    assert lengths == {200: [(100, False), (20, True), (80, False)], 110: []}


@pytest.mark.parametrize(
    "bad, left, inside",
    [
        ({3}, [(1,), (2,), ()], [False, True, False]),
        ({2}, [()], [False]),
        ({0}, [(1,), (), ()], [True, False, False]),
    ],
)
def test_without_a_lane_those_that_then_lead_nowhere_are_left_out_too(bad, left, inside):
    """The first lane leads over the second one to the third one, which ends at the edge; the last is by itself."""
    lanes = [lane(0, 100, 30, 1), lane(100, 120, 30, 2), lane(120, 300, 30), lane(250, 300, 30)]
    found, kept = without_lanes(lanes, np.array([False, True, False, False]), bad, shapely.box(0, -3, 300, 3))
    assert [x.successors for x in found] == left and kept.tolist() == inside
