"""Make values for tests, and read and compare them on the host, where a single number costs no program."""

from __future__ import annotations

import equinox as eqx
import jax
import numpy as np


def floats(*numbers):
    """An array of these numbers, or rows of numbers, on the device."""
    return jax.device_put(np.array(numbers, np.float32))


def as_numpy(tree):
    """Results as NumPy arrays: looking at a part of another array compiles a program."""
    return jax.tree.map(np.asarray, tree)


def the_same(one, other):
    """Whether two pytrees hold the same (for keys, little is compiled for it on the host)."""
    return eqx.tree_equal(*jax.device_get((one, other)))
