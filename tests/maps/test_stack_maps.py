"""Stacked maps are the single ones, and padding holds nothing."""

import numpy as np
import pytest

from jaxwalk.maps import ROUTE_SPACING, load_map, stack_maps


@pytest.fixture
def maps(small, write):
    return [load_map(write(small)), load_map("paper")]


def test_a_single_map_gets_a_leading_axis(maps):
    stacked = stack_maps(maps[:1])
    for name, value in vars(maps[0]).items():
        assert np.array_equal(getattr(stacked, name), value[None]), name


def test_each_map_stands_unchanged_at_the_beginning(maps):
    stacked = stack_maps(maps)
    for number, road_map in enumerate(maps):
        for name, value in vars(road_map).items():
            part = getattr(stacked, name)[number]
            assert part.dtype == value.dtype, name
            assert np.array_equal(part[tuple(map(slice, value.shape))], value), name


def test_padding_is_empty(maps):
    stacked = stack_maps(maps)
    nodes, routes = len(maps[0].node_x), int(maps[0].route_count)
    assert np.isinf(stacked.distance[0, nodes:]).all()
    assert np.isinf(stacked.distance[0, :, nodes:]).all()
    assert np.array_equal(stacked.next_hop[0, nodes:], np.tile(np.arange(nodes, 40)[:, None], 40))
    assert (stacked.edges[0, len(maps[0].edges) :] == -1).all()
    assert (stacked.side_landing[0, 2:] == -1).all()
    assert (stacked.zone_node[0, 2:] == -1).all()
    assert (stacked.node_side[0, nodes:] == -1).all()
    assert not stacked.goal_count[0, nodes:].any()
    assert not stacked.start_count[0, routes:].any()


def test_the_order_of_maps_changes_nothing(maps):
    one, other = stack_maps(maps), stack_maps(maps[::-1])
    for name, value in vars(one).items():
        assert np.array_equal(value, getattr(other, name)[::-1]), name


def test_padded_routes_go_straight_on(maps):
    stacked = stack_maps(maps)
    along = np.arange(stacked.route_x.shape[-1]) * ROUTE_SPACING
    assert np.array_equal(stacked.route_x[0, 0], (5 + along).astype(np.float32))
    assert np.array_equal(stacked.route_x[0, 1], (40 - along).astype(np.float32))
    assert np.array_equal(stacked.route_y[0, :2], np.repeat([[8], [12]], len(along), axis=1).astype(np.float32))
    assert np.array_equal(stacked.route_cos[0, :2], np.repeat([[1], [-1]], len(along), axis=1).astype(np.float32))


def test_no_maps_cannot_be_stacked():
    with pytest.raises(ValueError, match="at least one map"):
        stack_maps([])
