"""Requirements with messages in words, and comparisons that checks share."""

from __future__ import annotations

from typing import Any

import equinox as eqx
import jax
import numpy as np

from jaxwalk.acting import is_weak, part_of


class ContractError(AssertionError):
    """A part doesn't do what others rely on; the message says what it does and what it should do."""


def require(holds: Any, message: str) -> None:
    """Raise ContractError with the message unless the requirement holds."""
    if not holds:
        raise ContractError(message)


def same(a: Any, b: Any, *, tolerance: float = 0.0) -> bool:
    """Return whether two pytrees have equal structures, shapes, types and numbers (NaN equals NaN)."""
    if jax.tree.structure(a) != jax.tree.structure(b):
        return False
    pairs = zip(map(plain, jax.tree.leaves(a)), map(plain, jax.tree.leaves(b)), strict=True)
    return all(x.shape == y.shape and x.dtype == y.dtype and _close(x, y, tolerance) for x, y in pairs)


def form(tree: Any) -> Any:
    """Return a pytree's structure, and the shape and type of each array."""
    return jax.tree.structure(tree), [(x.shape, x.dtype) for x in map(plain, jax.tree.leaves(tree))]


def weak(tree: Any) -> list[str]:
    """Return the names of arrays whose type isn't their own: such as ``jnp.full(shape, 2.0)``, made of a number."""
    leaves = jax.tree_util.tree_leaves_with_path(tree)
    return [jax.tree_util.keystr(path) for path, x in leaves if is_weak(x)]


def plain(x: Any) -> np.ndarray:
    """Return an array as a NumPy array; a random key as its words."""
    is_key = eqx.is_array(x) and jax.numpy.issubdtype(x.dtype, jax.dtypes.prng_key)
    return np.asarray(jax.random.key_data(x) if is_key else x)


def finite(tree: Any) -> bool:
    """Return whether no number of a pytree is NaN or infinite."""
    leaves = map(plain, jax.tree.leaves(tree))
    return all(np.isfinite(x).all() for x in leaves if np.issubdtype(x.dtype, np.inexact))


def episode(tree: Any, number: int) -> Any:
    """Return one episode, as a batch of one, of arrays ``(..., episode)``."""
    return part_of(tree, slice(number, number + 1))


def _close(x: np.ndarray, y: np.ndarray, tolerance: float) -> bool:
    if not np.issubdtype(x.dtype, np.inexact):
        return bool((x == y).all())
    return np.allclose(x, y, rtol=tolerance, atol=tolerance, equal_nan=True)
