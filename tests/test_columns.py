"""A function of some columns gives there what it gives for all, and nothing elsewhere."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.columns import apply_where

SHAPE, PART = (12, 16), 16
COLUMNS = 12 * 16


def both(arguments):
    """Two results of two arrays with other axes, or none, before those of the columns."""
    wide, flat = arguments
    return jnp.sin(wide).sum(axis=0) + flat, (jnp.stack([flat, 2 * flat]), flat > 0)


@pytest.mark.parametrize("asked", [0, 1, COLUMNS // PART, COLUMNS // PART + 1, 100, COLUMNS])
def test_it_is_computed_where_it_is_asked_for_and_nowhere_else(asked):
    random = np.random.default_rng(asked)
    arguments = jnp.asarray(random.normal(size=(5, *SHAPE)), jnp.float32), jnp.asarray(random.normal(size=SHAPE))
    which = np.zeros(COLUMNS, bool)
    which[random.choice(COLUMNS, asked, replace=False)] = True
    which = which.reshape(SHAPE)
    quick = jax.jit(lambda given, where: apply_where(both, given, where, PART))(arguments, jnp.asarray(which))
    for some, everywhere in zip(jax.tree.leaves(quick), jax.tree.leaves(both(arguments)), strict=True):
        assert some.shape == everywhere.shape
        np.testing.assert_allclose(some[..., which], everywhere[..., which], atol=1e-6)
        assert not some[..., ~which].any()


def test_a_single_column_needs_no_axis():
    found = [apply_where(jnp.exp, jnp.float32(1), jnp.bool_(which), PART) for which in (True, False)]
    np.testing.assert_allclose(found, [np.e, 0], rtol=1e-6)


def test_no_other_column_is_computed_beside_the_chosen_ones():
    """A loop of the function that runs until all of its columns are done waits for nobody else."""
    values = -jnp.arange(1, COLUMNS + 1, dtype=jnp.float32)
    which = jnp.arange(COLUMNS) == 7
    found = apply_where(lambda column: jnp.full_like(column, column.max()), values, which, PART)
    assert found[7] == values[7]
