"""A function of some columns gives there what it gives for all, and nothing elsewhere."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.columns import apply_where

SHAPE, PART = (12, 16), 16
COLUMNS = 12 * 16


@jax.jit
def both(arguments):
    """Two results of two arrays with other axes, or none, before those of the columns."""
    wide, flat = arguments
    return jnp.sin(wide).sum(axis=0) + flat, (jnp.stack([flat, 2 * flat]), flat > 0)


@partial(jax.jit, static_argnums=0)
def where_asked(function, arguments, which):
    return apply_where(function, arguments, which, PART)


@pytest.mark.parametrize("asked", [0, 1, COLUMNS // PART, COLUMNS // PART + 1, 100, COLUMNS])
def test_it_is_computed_where_it_is_asked_for_and_nowhere_else(asked):
    random = np.random.default_rng(asked)
    arguments = [random.normal(size=shape).astype(np.float32) for shape in ((5, *SHAPE), SHAPE)]
    which = np.zeros(COLUMNS, bool)
    which[random.choice(COLUMNS, asked, replace=False)] = True
    which = which.reshape(SHAPE)
    found = jax.device_get((where_asked(both, arguments, which), both(arguments)))
    for some, everywhere in zip(*map(jax.tree.leaves, found), strict=True):
        assert some.shape == everywhere.shape
        np.testing.assert_allclose(some[..., which], everywhere[..., which], atol=1e-6)
        assert not some[..., ~which].any()


def test_a_single_column_needs_no_axis():
    found = [where_asked(jnp.exp, np.float32(1), np.bool_(which)) for which in (True, False)]
    np.testing.assert_allclose(found, [np.e, 0], rtol=1e-6)


def test_no_other_column_is_computed_beside_the_chosen_ones():
    """A loop of the function that runs until all of its columns are done waits for nobody else."""
    values = -np.arange(1, COLUMNS + 1, dtype=np.float32)
    which = np.arange(COLUMNS) == 7
    found = where_asked(lambda column: jnp.full_like(column, column.max()), values, which)
    assert np.asarray(found)[7] == values[7]
