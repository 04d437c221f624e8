"""Slots of parking strips: by hand on straight and bent strips, and as they must be on every street."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from jaxwalk.maps import load_map, stack_maps
from jaxwalk.maps.generated import UNSEEN, Refusal, Town, make_street
from jaxwalk.maps.layout import lay_out
from jaxwalk.maps.network import Area, corners
from jaxwalk.maps.parking_slots import box_corners, parking_slots
from maps.networks import arc, bend, moved, ring


def straight(strips):
    """Areas and a lane along y = 2, to the east, with these strips: all that slots depend on."""
    street = bend()
    lane = replace(street.lanes[0], line=np.array([[0.0, 2.0], [100.0, 2.0]]))
    crosswalk = Area(kind="crosswalk", outline=corners([60.0, 0.0, 64.0, 8.0]))
    areas = [Area(kind="parking", outline=corners([float(at) for at in strip])) for strip in strips]
    return replace(street, lanes=(lane,), areas=(crosswalk, *areas))


def test_slots_of_six_metres_stand_in_the_middle_of_a_strip():
    slots = parking_slots(straight([[10, -2, 23, 0]]))  # 13 m: two slots, and half a metre at either end
    expected = [[13.5, -1, 1, 0, 2.2, 0.9], [19.5, -1, 1, 0, 2.2, 0.9]]
    np.testing.assert_allclose(slots, expected, atol=1e-9)


def test_a_narrow_strip_has_narrow_vehicles_and_a_very_narrow_one_none():
    np.testing.assert_allclose(parking_slots(straight([[10, -1.5, 16, 0]]))[:, 5], [0.75])
    assert not len(parking_slots(straight([[10, -1.3, 16, 0], [30, -2, 35.9, 0]])))  # the other is too short


def test_nobody_parks_within_five_metres_of_a_crosswalk():
    at = parking_slots(straight([[40, -2, 100, 0]]))[:, 0]  # boxes end 2.2 m from their middle; the crosswalk is 60-64
    np.testing.assert_allclose(at, [43, 49, 73, 79, 85, 91, 97])


def test_strips_on_strips_hold_no_two_vehicles_in_one_place():
    assert len(parking_slots(straight([[10, -2, 22, 0], [10, -2, 22, 0]]))) == 2


def test_slots_follow_a_bend():
    strip = Area(kind="parking", outline=ring(52, 54, -0.2, 0.3))
    slots = parking_slots(replace(bend(), areas=(strip,)))
    assert len(slots) == 4  # 26 m along the lane in the middle of the nearer lane, of 52 m radius
    middle = arc(53, 0, 0)[0] - [53, 0]
    away = slots[:, :2] - middle
    np.testing.assert_allclose(np.hypot(*away.T), 53, atol=0.05)
    np.testing.assert_allclose((away * slots[:, 2:4]).sum(axis=1), 0, atol=0.05)  # along the bend


def test_a_turned_street_has_turned_slots():
    network = replace(bend(), areas=(*bend().areas, Area(kind="parking", outline=ring(52, 54, -0.2, 0.3))))
    turned = parking_slots(moved(network, lambda points: np.stack([90 - points[:, 1], points[:, 0]], 1), (90.0, 30.0)))
    x, y, cos, sin, *sizes = parking_slots(network).T
    np.testing.assert_allclose(turned, np.stack([90 - y, x, -sin, cos, *sizes], 1), atol=1e-6)


@given(st.integers(0, 10**6), st.booleans())
@settings(max_examples=15, deadline=None)
def test_vehicles_of_every_street_stand_in_strips_apart_and_clear_of_crosswalks(number, unseen):
    try:
        network = make_street(replace(UNSEEN if unseen else Town(), parking=1.0), number).network
    except Refusal:
        assume(False)
        raise
    slots = parking_slots(network)
    boxes = shapely.polygons(box_corners(slots))
    strips = [area.shape() for area in network.areas if area.kind == "parking"]
    assert len(slots) >= sum(strip.area / 2.6 / 6 - 2 for strip in strips)  # few places are left out
    assert all(any(strip.buffer(0.021).covers(box) for strip in strips) for box in boxes)
    crosswalks = network.surface("crosswalk")
    assert crosswalks.is_empty or (shapely.distance(boxes, crosswalks) > 4.97).all()
    pairs = shapely.STRtree(boxes).query(boxes, predicate="intersects")
    assert (pairs[0] == pairs[1]).all()
    np.testing.assert_allclose(np.hypot(slots[:, 2], slots[:, 3]), 1)


@pytest.fixture(scope="module")
def parked_street():
    return replace(bend(), areas=(*bend().areas, Area(kind="parking", outline=ring(52, 54, 0.2, 0.6))))


def test_a_packed_map_has_the_slots_of_its_network(parked_street):
    packed = lay_out(parked_street, goal_spacing=20.0, start_clearance=10.0)
    np.testing.assert_allclose(packed.slots, parking_slots(parked_street), atol=1e-5)
    assert packed.slot_count == len(packed.slots) > 1
    stacked = stack_maps([packed, load_map("paper")])
    assert stacked.slot_count.tolist() == [len(packed.slots), 0]  # the paper's street has no strips
    assert not stacked.slots[1].any()
