"""Lines of sight: by hand, and as shapely's geometry finds them, on thousands of lines of generated streets."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from jax import device_put

from jaxwalk import Street
from jaxwalk.maps import load_network
from jaxwalk.maps.network import Area
from jaxwalk.maps.parking_slots import box_corners, parking_slots
from jaxwalk.maps.walls import walls
from jaxwalk.sim import occluders, sight, vehicle
from jaxwalk.sim.sim_config import SimConfig
from maps.networks import bend
from pytrees import as_numpy
from sim.passersby import drawn
from sim.play import columns, compiled

STREETS = ("validation-1000000004", "validation-1000000001")
"""One with many parked vehicles, one with many rounded buildings."""
LINES, AT_ONCE = 5_000, 50
EDGE = 0.06
"""A line that comes this near to a building's outline may count as either [m]; the walls are exact to 0.05 m."""
ROUNDING = 1e-3
"""A step computes in single precision: who is this near to the edge of a vehicle's shadow may be either [m]."""
BOX = np.array([10.0, 0.0, 1.0, 0.0, 2.2, 0.9])
place, in_sight = eqx.filter_jit(vehicle.place), compiled(sight.in_sight)


def at(x, y):
    return np.array([x, y], float)


@pytest.mark.parametrize(
    ("eye", "to", "hidden"),
    [
        (at(0, 0), at(20, 0), True),  # through the middle
        (at(0, 0), at(7.7, 0), False),  # ends before it
        (at(0, 0), at(7.9, 0), True),  # ends in it
        (at(0, 1), at(20, 1), False),  # passes beside it
        (at(0, 0.8), at(20, 0.8), True),
        (at(0, 3), at(20, 0.3), False),  # passes its corner (12.2, 0.9) 0.45 m above
        (at(0, 3), at(20, -1), True),
        (at(13, 0), at(20, 0), False),  # begins behind it
    ],
)
def test_a_box_by_hand(eye, to, hidden):
    assert occluders.blocked(BOX[None], eye[None], to[None]).tolist() == [hidden]


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_boxes_block_what_polygons_block(seed):
    random = np.random.default_rng(seed)
    angle = random.uniform(-np.pi, np.pi, 200)
    boxes = np.column_stack([
        random.uniform(-10, 10, (200, 2)), np.cos(angle), np.sin(angle), random.uniform(0, 4, (200, 2))
    ])  # fmt: skip
    eye, to = random.uniform(-15, 15, (2, 200, 2))
    lines = shapely.linestrings(np.stack([eye, to], axis=1))
    expected = shapely.intersects(shapely.polygons(box_corners(boxes)), lines)
    near = shapely.distance(shapely.boundary(shapely.polygons(box_corners(boxes))), lines) < 1e-9
    touches = near & (shapely.length(shapely.intersection(shapely.polygons(box_corners(boxes)), lines)) < 1e-9)
    found = occluders.blocked(boxes, eye, to)
    np.testing.assert_array_equal(found[~touches], expected[~touches])


@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.integers(0, 4))
@settings(max_examples=50, deadline=None)
def test_boxes_that_matter_are_those_on_some_line(seed, eyes, people):
    """Looked for box by box and eye by eye. A box that a line only touches may count as either."""
    random, sight = np.random.default_rng(seed), 30.0
    eyes, people = random.uniform(-6, 6, (eyes, 2)), random.uniform(-50, 50, (people, 2))
    angle = random.uniform(-np.pi, np.pi, 100)
    boxes = np.column_stack([
        random.uniform(-60, 60, (100, 2)), np.cos(angle), np.sin(angle), random.uniform(0, 3, (100, 2)), np.zeros(100)
    ])  # fmt: skip
    middle, most = eyes.mean(axis=0), sight + 2 * occluders.CELL  # farther than any line from one of the eyes
    near = people[np.hypot(*(people - middle).T) <= most]

    def lies_on_a_line(box, widened):
        if np.hypot(*(box[:2] - middle)) - np.hypot(box[4], box[5]) > most:
            return False
        wide = box[:6] + widened * np.array([0, 0, 0, 0, 1, 1])
        return any(occluders.blocked(wide[None], eye, near).any() for eye in eyes)

    found = occluders._matter(boxes, eyes, people, sight)
    less, more = ([lies_on_a_line(box, occluders.WIDENED + by) for box in boxes] for by in (-ROUNDING, ROUNDING))
    assert (np.array(less) <= found).all() and (found <= np.array(more)).all()


@pytest.fixture(scope="module", params=STREETS)
def hiding(request):
    rules = SimConfig(horizon=20, pedestrians=AT_ONCE, parked=0.6, perception=True)
    return load_network(request.param), Street.create([request.param], rules)


def lines_of(street, random, count):
    """Cars on their routes, as far to their sides as 1.5 m, and places where people walk."""
    maps = as_numpy(street.world.maps)
    route = random.integers(maps.route_count[0], size=count)
    point = (2 * maps.route_length[0, route] * random.random(count)).astype(int)  # one each half metre
    tables = (maps.route_x, maps.route_y, maps.route_cos, maps.route_sin)
    x, y, cos, sin = (table[0, route, point] for table in tables)
    aside = random.uniform(-1.5, 1.5, count)
    turn = random.uniform(-0.3, 0.3, count)
    heading = np.arctan2(sin, cos) + turn
    edges = maps.edges[0]
    edges = edges[edges[:, 0] >= 0]
    nodes = np.stack([maps.node_x[0], maps.node_y[0]], 1)
    begin, end = np.moveaxis(nodes[edges[random.integers(len(edges), size=(AT_ONCE, count))]], 2, 0)
    places = begin + random.random((AT_ONCE, count, 1)) * (end - begin)
    return (x - aside * sin, y + aside * cos, np.cos(heading), np.sin(heading)), places


def test_who_is_in_sight_is_whom_a_straight_line_reaches(hiding):
    """10,000 lines on two streets: for vehicles exactly, for buildings but within `EDGE` of their outlines."""
    network, street = hiding
    random, cars = np.random.default_rng(77), LINES // AT_ONCE
    scenarios = drawn(street, cars)
    (x, y, cos, sin), places = lines_of(street, random, cars)
    pose = {name: device_put(np.float32(at)) for name, at in {"x": x, "y": y, "cos": cos, "sin": sin}.items()}
    car = replace(place(street.world, scenarios), **pose)
    found = in_sight(street.world, scenarios, car, *np.moveaxis(places.astype(np.float32), -1, 0))
    eyes = np.stack([x + 1.25 * cos, y + 1.25 * sin], -1)
    lines = shapely.linestrings(np.stack([np.broadcast_to(eyes, places.shape), places], axis=2))
    parked, slots = np.asarray(scenarios.parked), parking_slots(network)
    buildings, length = network.surface("building"), shapely.length(lines)

    def behind_vehicles(wider):
        boxes = shapely.polygons(box_corners(slots + np.array([0, 0, 0, 0, wider, wider])))
        here = [boxes[parked[: len(boxes), n]] for n in range(cars)]
        return np.stack([shapely.intersects(here[n][:, None], lines[:, n]).any(axis=0) for n in range(cars)], 1)

    def behind_buildings(wider):
        shape = buildings.buffer(wider, join_style="mitre")
        shapely.prepare(shape)
        return shapely.intersects(shape, lines)

    by_vehicle, by_building = behind_vehicles(0.0), behind_buildings(0.0)
    expected = ~by_vehicle & ~by_building & (length <= 60)
    rounding = (behind_vehicles(ROUNDING) != behind_vehicles(-ROUNDING)) | (np.abs(length - 60) < ROUNDING)
    open_to_doubt = rounding | (behind_buildings(EDGE) != behind_buildings(-EDGE))
    np.testing.assert_array_equal(found[~open_to_doubt], expected[~open_to_doubt])
    assert rounding.mean() < 0.002
    assert open_to_doubt.mean() < 0.02
    assert (by_vehicle & ~by_building & (length < 60)).sum() > 50
    assert (by_building & ~by_vehicle & (length < 60)).sum() > 50
    assert expected.sum() > 300


def test_a_batch_may_have_any_number_of_axes(hiding):
    _, street = hiding
    scenarios = drawn(street, 6)
    (x, y, cos, sin), places = lines_of(street, np.random.default_rng(77), 6)
    pose = {name: device_put(np.float32(at)) for name, at in {"x": x, "y": y, "cos": cos, "sin": sin}.items()}
    car = replace(place(street.world, scenarios), **pose)
    batch = (scenarios, car, *np.moveaxis(places.astype(np.float32), -1, 0))
    found = in_sight(street.world, *batch)
    assert 0 < found.sum() < found.size
    two = jax.tree.map(lambda leaf: leaf.reshape(*leaf.shape[:-1], 2, 3), as_numpy(batch))
    np.testing.assert_array_equal(in_sight(street.world, *two).reshape(found.shape), found)
    np.testing.assert_array_equal(in_sight(street.world, *columns(batch, 4)), found[:, 4])


def test_copies_of_the_first_map_are_not_worked_out_again(hiding, monkeypatch):
    """A stack is filled up with them, and another map is told apart by any of its numbers."""
    one, asked, work_out = as_numpy(hiding[1].world.maps), [], occluders._of_map
    bare = replace(one, slot_count=0 * one.slot_count)
    maps = jax.tree.map(lambda *parts: np.concatenate(parts), one, bare, one)
    monkeypatch.setattr(occluders, "_of_map", lambda maps, n, *rest: asked.append(n) or work_out(maps, n, *rest))
    tables = occluders.pack_occluders(maps, 20.0)
    assert sorted(asked) == [0, 1]
    for table in tables:
        np.testing.assert_array_equal(table[2], table[0])
    assert (tables[-1][0] >= 0).any() and not (tables[-1][1] >= 0).any(), "slots are in the first, none in the second"


def test_a_rectangular_building_is_a_box_and_others_are_walls():
    rectangle = Area(kind="building", outline=np.array([[0.0, 0], [10, 0], [10, 4], [0, 4]]))
    corner = Area(kind="building", outline=np.array([[20.0, 0], [30, 0], [30, 4], [24, 4], [24, 8], [20, 8]]))
    box, *six = walls(replace(bend(), areas=(rectangle, corner)))
    np.testing.assert_allclose(box[:2], [5, 2])
    assert sorted(np.round(box[4:], 6)) == [2, 5]
    assert len(six) == 6
    assert not np.array(six)[:, 5].any()
    np.testing.assert_allclose(sorted(np.array(six)[:, 4] * 2), [4, 4, 4, 6, 8, 10], atol=1e-9)
