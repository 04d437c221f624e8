"""What the car saw of people before the episode: drawn by their own tendency, and where beliefs start."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import SimConfig, Street
from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.sim import belief, scenario
from jaxwalk.sim.observation import BELIEF, Observation, part
from jaxwalk.sim.person_kind import in_shares
from jaxwalk.sim.scenario import Scenario, dimensions
from sim.passersby import drawn
from sim.play import compiled

EARLIER, BATCH = 10, 64
RULES = SimConfig(horizon=20, earlier_decisions=EARLIER)
from_uniforms, expected_after = eqx.filter_jit(scenario.from_uniforms), compiled(belief.expected_after)
tendency, earlier_jaywalks = compiled(Scenario.jaywalking_tendency), compiled(Scenario.earlier_jaywalks)


@pytest.fixture(scope="module")
def met():
    return Street.create(config=RULES, jaywalk_multiplier=1.0)


@pytest.fixture(scope="module")
def scenarios(met):
    return drawn(met, BATCH)


def test_the_last_numbers_of_a_scenario_are_the_earlier_decisions(met):
    numbers = np.random.default_rng(0).random(dimensions(met.world)).astype(np.float32)
    stranger = Street.create(config=replace(RULES, earlier_decisions=0)).world
    assert dimensions(met.world) == dimensions(stranger) + EARLIER * 12
    found, plain = from_uniforms(met.world, numbers), from_uniforms(stranger, numbers[: -EARLIER * 12])
    np.testing.assert_array_equal(np.ravel(found.earlier_draw), numbers[-EARLIER * 12 :])
    assert plain.earlier_draw is None and not earlier_jaywalks(plain, stranger).any()
    for one, other in zip(*map(jax.tree.leaves, (replace(found, earlier_draw=None), plain)), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("multiplier", [0.25, 1.0])
def test_people_did_as_their_tendency_and_the_multiplier_say(met, scenarios, multiplier):
    world = with_jaywalk_multiplier(met, multiplier).world
    did = earlier_jaywalks(scenarios, world)
    chance = multiplier * tendency(scenarios, world)
    assert did.min() >= 0 and did.max() <= EARLIER
    off = (did - EARLIER * chance).sum() / (EARLIER * chance * (1 - chance)).sum() ** 0.5
    assert abs(off) < 4
    by_chance = EARLIER * (chance * (1 - chance)).mean()
    expected = EARLIER * chance.std() / (by_chance + EARLIER**2 * chance.var()) ** 0.5
    assert np.corrcoef(did.ravel(), chance.ravel())[0, 1] == pytest.approx(expected, abs=0.1)


def test_beliefs_start_from_what_was_seen_earlier(met, scenarios):
    """Laplace's rule of succession, as the multiplier is 1: (k + 1) / (n + 2)."""
    did = earlier_jaywalks(scenarios, met.world)
    none = np.zeros(scenarios.start.shape, np.int32)
    found = expected_after(met.world, scenarios, none, none)
    np.testing.assert_allclose(found, (did + 1) / (EARLIER + 2), rtol=1e-4)
    found = expected_after(met.world, scenarios, none + 1, none + 2)
    np.testing.assert_allclose(found, (did + 2) / (EARLIER + 5), rtol=1e-4)


@compiled
def first_shown(street, scenarios):
    """How far away people are at the start, and what the car sees then."""
    state = street.reset(scenarios)
    away = jnp.hypot(state.pedestrian.x - state.vehicle.x, state.pedestrian.y - state.vehicle.y)
    return away, street.observe(scenarios, state, Observation("driver", BELIEF))


def test_the_view_shows_them_from_the_start(met, scenarios):
    away, seen = first_shown(met, scenarios)
    seen = seen[part("driver", BELIEF, "tendencies")]
    expected = (earlier_jaywalks(scenarios, met.world) + 1) / (EARLIER + 2)
    nearest = np.argsort(away, axis=0, kind="stable")[:6]
    np.testing.assert_allclose(seen, np.take_along_axis(expected, nearest, axis=0), rtol=1e-4)


def test_where_people_hurry_ten_decisions_tell_who_does(met):
    street = Street.create(config=replace(RULES, kinds=in_shares(calm=0.7, hurried=0.3)), jaywalk_multiplier=1.0)
    scenarios = drawn(street, BATCH)
    none = np.zeros(scenarios.start.shape, np.int32)
    found = expected_after(street.world, scenarios, none, none)
    np.testing.assert_allclose(found, tendency(scenarios, street.world), atol=0.01)


@pytest.mark.parametrize("number", [-1, 31])
def test_an_impossible_number_is_refused(number):
    with pytest.raises(ValueError, match="earlier_decisions must be"):
        SimConfig(earlier_decisions=number)
