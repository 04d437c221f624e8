"""Routes of imported streets."""

import numpy as np
import pytest

from jaxwalk.maps.imported.tile_lanes import LONGEST_DRIVE, LONGEST_ROUTE, ORACLE_LEVEL, RouteFinder
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
