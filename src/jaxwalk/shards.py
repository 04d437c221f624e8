"""Division of the environments among devices: each device plays and learns on its shard; sums go over all shards.

A CPU's cores are devices too, if ``JAX_NUM_CPU_DEVICES`` says so before JAX starts; the command line sets it. Two
cores that each work on half of the environments are much faster than two that share every small matrix product.
"""

from __future__ import annotations

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.sharding import Mesh, NamedSharding, PartitionSpec
from jaxtyping import Array

SHARDS = "env"
"""Name of the mesh axis of the shards: ``jax.lax.psum(x, SHARDS)`` sums over all of them."""
Axis = str | tuple[()]
"""SHARDS, or () if there is only one shard."""
EVERYWHERE = PartitionSpec()
"""The partition of an array that every device holds in full."""


class ShardsError(ValueError):
    """There are fewer devices than shards, or processes without one. The message says what to do, in one line."""


def mesh_of(shards: int) -> Mesh:
    """Return a mesh of this many devices, in the order of their processes.

    Raises ShardsError if there are fewer, or if several processes have more: each needs a part of the work.
    """
    devices = jax.devices()
    if jax.process_count() > 1 and len(devices) != shards:
        raise ShardsError(
            f"shards: {jax.process_count()} processes have {len(devices)} devices, and the training has {shards} "
            "shards; start a number of processes that divides the shards evenly"
        )
    if len(devices) < shards:
        raise ShardsError(
            f"shards: {shards} devices are needed, and JAX has {len(devices)} ({devices[0].platform}); ask for fewer, "
            f"or set JAX_NUM_CPU_DEVICES={shards} and JAX_PLATFORMS=cpu to have as many on a CPU"
        )
    return Mesh(np.array(devices[:shards]), (SHARDS,))


def by_environment(tree: Any) -> Any:
    """Return partitions that divide arrays ``(..., env)`` by environment; arrays without axes are whole everywhere."""
    return jax.tree.map(lambda x: PartitionSpec(*(None,) * (x.ndim - 1), SHARDS) if x.ndim else EVERYWHERE, tree)


def place(tree: Any, specs: Any, mesh: Mesh) -> Any:
    """Return a tree with its arrays placed on the mesh's devices. Other leaves stay as they are."""

    def put(x: Array, spec: PartitionSpec) -> Array:
        if jnp.issubdtype(x.dtype, jax.dtypes.prng_key):
            return jax.random.wrap_key_data(put(jax.random.key_data(x), spec), impl=jax.random.key_impl(x))
        values = np.asarray(x)  # of a NumPy array: JAX would compile a program for each shape
        return jax.make_array_from_callback(values.shape, NamedSharding(mesh, spec), values.__getitem__)

    arrays, rest = eqx.partition(tree, eqx.is_array)
    return eqx.combine(jax.tree.map(put, arrays, specs), rest)


def everywhere(tree: Any, mesh: Mesh) -> Any:
    """Return a tree with its arrays in full on each of the mesh's devices, so that no call must copy them there."""
    return place(tree, jax.tree.map(lambda _: EVERYWHERE, eqx.filter(tree, eqx.is_array)), mesh)
