"""Sharing out environments among devices: each plays and learns on its part, and sums go over all of them.

A processor's cores are devices too, if ``JAX_NUM_CPU_DEVICES`` says so before JAX starts, as the command line does. Two
cores that each work on half of the environments are far quicker than two that share every small product.
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
"""Name of the axis over which a sum of all shards goes: `jax.lax.psum` (x, SHARDS)."""
Axis = str | tuple[()]
"""SHARDS, or () where an array holds everything already: the sum of one shard."""
EVERYWHERE = PartitionSpec()
"""Every device has the whole array."""


class ShardsError(ValueError):
    """There are fewer devices than shards; one line says what to do."""


def mesh_of(shards: int) -> Mesh:
    """So many devices in a row. Raises ShardsError if there are fewer."""
    devices = jax.devices()
    if len(devices) < shards:
        raise ShardsError(
            f"shards: {shards} devices are needed, and JAX has {len(devices)} ({devices[0].platform}); ask for fewer, "
            f"or set JAX_NUM_CPU_DEVICES={shards} and JAX_PLATFORMS=cpu, for so many on a processor"
        )
    return Mesh(np.array(devices[:shards]), (SHARDS,))


def by_environment(tree: Any) -> Any:
    """Of arrays ``(..., env)``, that each device has its environments; of those without an axis, that each has all."""
    return jax.tree.map(lambda x: PartitionSpec(*(None,) * (x.ndim - 1), SHARDS) if x.ndim else EVERYWHERE, tree)


def place(tree: Any, specs: Any, mesh: Mesh) -> Any:
    """The same arrays, on those devices; what is no array stays as it is."""

    def put(x: Array, spec: PartitionSpec) -> Array:
        if jnp.issubdtype(x.dtype, jax.dtypes.prng_key):
            return jax.random.wrap_key_data(put(jax.random.key_data(x), spec), impl=jax.random.key_impl(x))
        return jax.device_put(np.asarray(x), NamedSharding(mesh, spec))  # JAX would compile how to cut each shape

    arrays, rest = eqx.partition(tree, eqx.is_array)
    return eqx.combine(jax.tree.map(put, arrays, specs), rest)
