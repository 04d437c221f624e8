"""Look up entries of tables inside a step, with as few gathers as possible."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array

from jaxwalk.platforms import few_launches

IN_BOUNDS: Any = {"mode": "promise_in_bounds", "wrap_negative_indices": False}
"""Options for indices that are known to be valid. One below 0 or beyond the last entry gives an undefined result."""


def look_up(table: Array, *index: Array) -> Array:
    """Return ``table[index]`` for index arrays that broadcast against each other: one flat gather, no bounds checks."""
    return look_up_each((table,), *index)[0]


def look_up_each(tables: Sequence[Array], *index: Array) -> list[Array]:
    """Return `look_up` of each table; all tables have one shape.

    On a CPU a barrier makes XLA compute the places once instead of in every gather. A list of tables gathers faster
    than one stacked array.
    """
    flat = jnp.zeros((), jnp.int32)
    for size, i in zip(tables[0].shape, index, strict=True):
        flat = flat * size + i
    places = _once(flat.reshape(-1))
    return [table.reshape(-1).at[places].get(**IN_BOUNDS).reshape(flat.shape) for table in tables]


def look_up_row(table: Array, *index: Array) -> Array:
    """Return ``table[index]`` for a table with one axis more than there are indices; that axis leads in the result."""
    rows = _rows(table, *index)
    return _once(rows.reshape(-1, table.shape[-1]).T).reshape(-1, *rows.shape[:-1])  # not transposed by every reader


def look_up_rows(tables: Sequence[Array], *index: Array) -> list[Array]:
    """Return ``table[index]`` of each such table, with that axis last; all tables have one shape."""
    return _once([_rows(table, *index) for table in tables])


def _rows(table: Array, *index: Array) -> Array:
    flat = jnp.zeros((), jnp.int32)
    for size, i in zip(table.shape[:-1], index, strict=True):
        flat = flat * size + i
    return table.reshape(-1, table.shape[-1]).at[flat.reshape(-1)].get(**IN_BOUNDS).reshape(*flat.shape, -1)


def _once(x: Any) -> Any:
    """Return arrays that a CPU computes once, not in every reader; on a GPU that would be a launch of its own."""
    return x if few_launches() else jax.lax.optimization_barrier(x)


def of_map(table: Array, map_index: Array) -> Array:
    """Return each episode's entry of a small table: ``(map, ...)`` to ``(..., *batch)``."""
    if table.shape[0] == 1:
        return jnp.reshape(table[0], table.shape[1:] + (1,) * map_index.ndim)
    return jnp.moveaxis(table[map_index], tuple(range(map_index.ndim)), tuple(range(-map_index.ndim, 0)))
