"""The packed tables say what the map's arrays say, and keys keep the order of what they were made of."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxwalk.sim.everybody import for_everybody, for_nearest, index_of, with_index
from jaxwalk.sim.lookup import look_up_row
from jaxwalk.sim.map_tables import POINT_SPACING, POINTS
from sim.play import compiled


def test_the_course_is_the_route_and_the_points_ahead(street):
    maps, course = street.world.maps, np.asarray(street.world.tables.course)[0]
    last = maps.route_x.shape[-1] - 1
    for column, field in enumerate((maps.route_x, maps.route_y, maps.route_cos, maps.route_sin)):
        np.testing.assert_array_equal(course[..., column], np.asarray(field)[0])
    for k, point in enumerate(POINTS):
        there = np.minimum(np.arange(last + 1) + round(point * POINT_SPACING / 0.5), last)
        np.testing.assert_array_equal(course[..., 5 + k], np.asarray(maps.route_x)[0][:, there])
        np.testing.assert_array_equal(course[..., 5 + len(POINTS) + k], np.asarray(maps.route_y)[0][:, there])


def test_a_row_leads_in_the_result():
    table = np.arange(2 * 3 * 4, dtype=np.int32).reshape(2, 3, 4)
    first, second = np.array([[0, 1], [1, 1], [0, 0]]), np.array([[2, 0], [1, 2], [0, 1]])
    found = compiled(look_up_row)(table, first, second)
    np.testing.assert_array_equal(found, np.moveaxis(table[first, second], -1, 0))


@compiled
def keys_and_back(squared):
    """Keys of everybody, and the index that each of them holds."""
    people = len(squared)
    keys = with_index(squared, jnp.arange(people), people)
    return keys, index_of(keys, people)


@given(st.lists(st.floats(0, 4e4, width=32), min_size=1, max_size=200))
@settings(max_examples=50, deadline=None)
def test_keys_hold_their_index_and_the_order(squared):
    people = len(squared)
    keys, index = keys_and_back(np.asarray(squared, np.float32))
    np.testing.assert_array_equal(index, np.arange(people))
    assert len(np.unique(keys)) == people
    in_order = np.asarray(squared, float)[np.argsort(keys, kind="stable")]
    resolution = 2.0 ** (people.bit_length() - 23)
    assert (in_order[1:] >= in_order[:-1] * (1 - resolution) - 1e-37).all()


@pytest.mark.parametrize("people", [1, 2, 3, 7, 12, 96])
def test_everybody_is_met_once_in_order(people):
    def body(person, found):
        (value, number), (total, last) = person, found
        return total + value, jnp.where(number > last, number, -99)

    @compiled
    def met(values, numbers):
        return for_everybody((values, numbers), body, (jnp.zeros(1), jnp.full(1, -1)))

    numbers = np.arange(people, dtype=np.int32)
    total, last = met(np.float32(numbers + 1), numbers)
    assert (total.item(), last.item()) == (people * (people + 1) / 2, people - 1)


def test_the_nearest_are_met_first_until_nobody_is_near_in_any_episode():
    away = np.array([[5.0, 9.0], [1.0, 8.0], [3.0, 7.0], [9.0, 9.0]], np.float32)

    def body(person, found):
        return jnp.roll(found, 1, axis=0).at[0].set(person[0])

    found = compiled(lambda away: for_nearest(away, away, 6.0, body, jnp.zeros((4, 2))))(away)
    np.testing.assert_array_equal(found, [[5, 9], [3, 8], [1, 7], [0, 0]])  # three are near in the first episode
