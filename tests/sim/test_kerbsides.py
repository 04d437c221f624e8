"""The table of what lies beside a route, found again with shapely on a generated street."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from jaxwalk.maps import load_map, read_map, stack_maps
from jaxwalk.maps.network_file import parse_network
from jaxwalk.maps.routes import ROUTE_SPACING
from jaxwalk.sim.kerbsides import ASIDE, FARTHEST, REACH, pack_kerbsides

STREET = "parked-test-5000000001"


@pytest.fixture(scope="module")
def street():
    return load_map(STREET)


@pytest.fixture(scope="module")
def network():
    return parse_network(read_map(STREET).text, STREET)


@pytest.fixture(scope="module")
def beside(street):
    return pack_kerbsides(stack_maps([street]))[0]


def test_places_are_just_beyond_the_kerb(street, network, beside):
    roadway = network.surface("roadway")
    outlines = roadway.boundary
    checked = 0
    for route in range(int(street.route_count)):
        for point in range(0, int(street.route_length[route] / ROUTE_SPACING), 7):
            x, y, cos, sin = (
                float(getattr(street, f"route_{name}")[route, point]) for name in ("x", "y", "cos", "sin")
            )
            for side, (out_x, out_y) in enumerate(((sin, -cos), (-sin, cos))):
                ray = shapely.LineString([(x, y), (x + REACH * out_x, y + REACH * out_y)])
                met = shapely.intersection(ray, outlines)
                kerb = min(shapely.distance(shapely.Point(x, y), met), REACH) if not met.is_empty else REACH
                place = beside[route, point, 2 * side : 2 * side + 2]
                assert np.hypot(place[0] - x, place[1] - y) == pytest.approx(kerb + ASIDE, abs=0.15)
                checked += kerb < REACH
    assert checked > 100


def test_the_next_crosswalk_is_on_the_route(street, network, beside):
    crosswalks, met = network.surface("crosswalk"), 0
    for route in range(int(street.route_count)):
        points = shapely.points(np.asarray(street.route_x)[route], np.asarray(street.route_y)[route])
        metres, inside = beside[route, :, 4], shapely.distance(points, crosswalks) < ROUTE_SPACING
        for point in np.flatnonzero(metres == 0):
            assert inside[point]
            met += 1
        before = np.flatnonzero((metres > 0) & (metres < FARTHEST))
        np.testing.assert_allclose(metres[before] - metres[before + 1], ROUTE_SPACING, atol=1e-4)
        crossings = np.diff(inside[: int(street.route_length[route] / ROUTE_SPACING)].astype(int)) == 1
        assert (metres == 0).sum() >= crossings.sum()
    assert met > 3
