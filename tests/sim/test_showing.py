"""How far a person's jaywalking tendency shows: in its pace, by a Gaussian copula."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from jaxwalk import SimConfig, Street
from jaxwalk.rollout import draw_batch
from jaxwalk.sim import scenario
from jaxwalk.sim.scenario import dimensions

MANY = 40_000
random = np.random.default_rng(0)
correlated, from_uniforms = eqx.filter_jit(scenario.correlated), eqx.filter_jit(scenario.from_uniforms)
ONE, OTHER = (jnp.asarray(random.random(MANY), jnp.float32) for _ in range(2))


@pytest.mark.parametrize("r", [-0.8, 0.3, 0.5, 0.95])
def test_the_rank_correlation_is_the_stated_one_and_both_stay_uniform(r):
    found = np.asarray(correlated(ONE, OTHER, r))
    expected = 6 / np.pi * np.arcsin(r / 2)
    assert stats.spearmanr(ONE, found).statistic == pytest.approx(expected, abs=4 / MANY**0.5)
    assert np.corrcoef(ONE, found)[0, 1] == pytest.approx(expected, abs=4 / MANY**0.5)
    assert stats.kstest(found, "uniform").pvalue > 1e-4
    assert stats.spearmanr(OTHER, found).statistic > 0


def test_the_numbers_of_the_page():
    assert [round(6 / np.pi * np.arcsin(r / 2), 2) for r in (0.5, 0.9, 1.0)] == [0.48, 0.89, 1.0]


def test_fully_correlated_is_equal_and_the_opposite_is_the_opposite():
    np.testing.assert_allclose(correlated(ONE, OTHER, 1.0), np.clip(ONE, 2**-17, 1 - 2**-17), atol=2e-6)
    np.testing.assert_allclose(correlated(ONE, OTHER, -1.0), 1 - np.clip(ONE, 2**-17, 1 - 2**-17), atol=2e-6)


def test_corners_of_the_unit_cube_are_numbers():
    corners = jnp.array([0.0, 0.0, 1.0, 1.0]), jnp.array([0.0, 1.0, 0.0, 1.0])
    found = np.asarray(correlated(*corners, 0.9))
    assert ((found >= 0) & (found <= 1)).all() and (np.diff(found) > 0).all()


@pytest.fixture(scope="module")
def telling():
    return Street.create(config=SimConfig(horizon=20, pace_correlation=0.9))


def test_only_the_pace_of_a_scenario_depends_on_it(telling):
    silent = replace(telling.world, rules=replace(telling.world.rules, pace_correlation=0.0))
    numbers = jnp.asarray(random.random(dimensions(silent)), jnp.float32)
    plain, shown = from_uniforms(silent, numbers), from_uniforms(telling.world, numbers)
    expected = plain.traits.at[1].set(correlated(plain.traits[0], plain.traits[1], 0.9))
    np.testing.assert_array_equal(shown.traits, expected)
    for one, other in zip(*(jax.tree.leaves(replace(x, traits=plain.traits)) for x in (plain, shown)), strict=True):
        np.testing.assert_array_equal(one, other)


def test_who_jaywalks_more_walks_faster(telling):
    keys = jax.random.split(jax.random.key(77), 200)

    @eqx.filter_jit
    def traits(street):
        drawn = draw_batch(street, keys)
        return drawn.jaywalking_tendency(street.world), drawn.walking_speed(street.world)

    tau, pace = traits(telling)
    found = stats.spearmanr(np.ravel(tau), np.ravel(pace)).statistic
    assert found == pytest.approx(6 / np.pi * np.arcsin(0.45), abs=0.03)


@pytest.mark.parametrize("r", [-1.1, 1.5, float("nan")])
def test_an_impossible_correlation_is_refused(r):
    with pytest.raises(ValueError, match=r"pace_correlation must lie in \[-1, 1\]"):
        SimConfig(pace_correlation=r)
