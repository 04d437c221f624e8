"""Parked vehicles are part of the scenario where somebody parks, and nothing elsewhere."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxwalk import Street
from jaxwalk.maps.map_text import MapText
from jaxwalk.maps.network import Area
from jaxwalk.maps.network_file import network_text
from jaxwalk.scenarios import Drawn
from jaxwalk.sim import scenario
from jaxwalk.sim.crossing_kind import JAYWALK
from jaxwalk.sim.scenario import dimensions
from jaxwalk.sim.sim_config import SimConfig
from maps.networks import bend, ring
from sim.passersby import drawn
from sim.play import compiled

PAPER_HASH = "29ddb80cc2761215"
"""Of 64 scenarios of seed 77, from before anybody parked."""
SHORT = SimConfig(horizon=20, pedestrians=2, parked=0.6)
from_uniforms = eqx.filter_jit(scenario.from_uniforms)


@pytest.fixture(scope="module")
def strip():
    """A street with a strip of three slots, and one of one."""
    strips = [Area(kind="parking", outline=ring(52, 54, *between)) for between in ((0.2, 0.6), (-0.1, 0.03))]
    return MapText.of("strip", network_text(replace(bend(), areas=(*bend().areas, *strips))))


@pytest.fixture(scope="module")
def parking(strip):
    return Street.create([strip], SHORT)


def leaves(tree):
    return [np.asarray(x) for x in jax.tree.leaves(tree)]


def who_parks(street):
    """Who parks in a scenario, or None; which of the two is settled before anything is compiled."""
    return eqx.filter_eval_shape(street.draw, jax.random.key(0)).parked


def test_the_papers_scenarios_are_what_they_were():
    street = Street.create()
    assert Drawn(street, seed=77, count=64).hash() == PAPER_HASH
    assert who_parks(street) is None
    assert who_parks(Street.create(config=SimConfig(parked=0.6))) is None  # no strips there


def test_nobody_parks_unless_the_rules_say_so(strip, parking):
    empty = Street.create([strip], replace(SHORT, parked=0.0))
    assert dimensions(parking.world) - dimensions(empty.world) == parking.world.slots == 4
    assert who_parks(empty) is None


@given(st.integers(0, 2**31), st.floats(0.0625, 1, width=32))
@settings(max_examples=20, deadline=None)
def test_the_last_uniform_numbers_decide_who_parks_and_nothing_else(strip, parking, seed, share):
    rules = replace(parking.world.rules, parked=jax.device_put(np.float32(share)))
    numbers = np.random.default_rng(seed).random(dimensions(parking.world), np.float32)
    found = from_uniforms(replace(parking.world, rules=rules), numbers)
    np.testing.assert_array_equal(found.parked, numbers[-4:] < share)
    others = from_uniforms(replace(parking.world, slots=0), numbers[:-4])
    for one, other in zip(leaves(replace(found, parked=None)), leaves(others), strict=True):
        np.testing.assert_array_equal(one, other)


def test_the_share_of_occupied_slots_is_the_rules(parking):
    parked = np.asarray(drawn(parking, 4000).parked)
    assert parked.shape == (4, 4000)
    spread = 3 * np.sqrt(0.6 * 0.4 / 4000)
    np.testing.assert_allclose(parked.mean(axis=1), 0.6, atol=spread)


def test_nobody_parks_in_the_padding_of_a_map(strip):
    street = Street.create([strip, "paper"], replace(SHORT, parked=1.0))
    found = drawn(street, 64)
    assert set(np.asarray(found.map)) == {0, 1}
    np.testing.assert_array_equal(np.asarray(found.parked).sum(axis=0), np.where(np.asarray(found.map) == 0, 4, 0))


def test_parked_vehicles_are_in_the_hash_of_a_set(parking, strip):
    hashes = {
        Drawn(Street.create([strip], replace(SHORT, parked=x)), seed=77, count=16).hash() for x in (0.0, 0.2, 0.6)
    }
    assert len(hashes) == 3


COLUMNS = ("x", "y", "to_kerb", "crossing", "on_roadway")


@compiled
def after_five_steps(street, scenario):
    """The car, and these columns of the people."""
    actions = {"driver": jnp.full((2, 8), 0.5), "pedestrian": jnp.ones((2, 8), int)}
    state = jax.lax.fori_loop(0, 5, lambda _, s: street.step(scenario, s, actions)[0], street.reset(scenario))
    return state.vehicle, {column: getattr(state.pedestrian, column) for column in COLUMNS}


def test_car_and_people_pass_through_unless_they_step_out(parking):
    some = drawn(parking, 8)
    (car, people), (other_car, other_people) = (
        after_five_steps(parking, eqx.tree_at(lambda s: s.parked, some, np.full(some.parked.shape, x)))
        for x in (True, False)
    )
    steps_out = other_people["crossing"] == JAYWALK
    assert not steps_out.all()
    for one, other in zip(leaves(car), leaves(other_car), strict=True):
        np.testing.assert_array_equal(one, other)
    for column in COLUMNS:
        np.testing.assert_array_equal(people[column][~steps_out], other_people[column][~steps_out])
