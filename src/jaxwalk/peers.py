"""Several processes that train together (`jax.distributed`): who writes, what they agree on, and whole arrays.

Every process runs the same program on its own devices. Only process 0 writes files, and what depends on time, signals
or files is decided once for all of them. Functions here are called by all processes in the same order, as a program of
one that the others don't run would wait for ever. With one process they cost nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from typing import Any

import equinox as eqx
import jax
import numpy as np
from jax.sharding import Mesh, NamedSharding, PartitionSpec
from jaxtyping import Array

DEVICES = "device"
"""Name of the axis of all devices of all processes."""


def several() -> bool:
    """Return whether several processes train together."""
    return jax.process_count() > 1


def is_first() -> bool:
    """Return whether this process is the one that writes: process 0, or the only one."""
    return jax.process_index() == 0


def ask(answer: Callable[[], Sequence[int]]) -> Callable[[], list[int]]:
    """Return a function that returns the largest answer of all processes, number by number.

    Several processes answer now, and their answers travel while they compute: ask before starting an update, and look
    at the answers after it. A process that is alone answers when it looks.
    """
    if not several():
        return lambda: list(answer())
    numbers = np.array(answer(), np.int32)
    mesh = Mesh(np.array(jax.devices()), (DEVICES,))
    sharding = NamedSharding(mesh, PartitionSpec(DEVICES))
    own = jax.make_array_from_callback((mesh.size, *numbers.shape), sharding, lambda _: numbers[None])
    largest = _largest_on(mesh)(own)
    return lambda: np.asarray(largest).tolist()


@lru_cache
def _largest_on(mesh: Mesh) -> Callable[[Array], Array]:
    """Return what finds the largest row on a mesh; training asks in every update, and compiles it once."""
    return jax.jit(lambda rows: rows.max(axis=0), out_shardings=NamedSharding(mesh, PartitionSpec()))


def wait_for_all() -> None:
    """Wait until every process has come to this place."""
    ask(lambda: [0])()


def leave_together() -> None:
    """Wait until every process has come to its end and end their connection: JAX aborts those that process 0 leaves."""
    if several():
        with suppress(RuntimeError):  # the work is done
            jax.distributed.shutdown()


def gathered(tree: Any) -> Any:
    """Return the tree with each of its arrays whole, on this process's own device if there are several processes."""
    if not several():
        return tree
    arrays, rest = eqx.partition(tree, eqx.is_array)
    copies = _whole_on(jax.tree.leaves(arrays)[0].sharding.mesh)(arrays)
    return eqx.combine(jax.tree.map(lambda x: x.addressable_data(0), copies), rest)


@lru_cache
def _whole_on(mesh: Mesh) -> Callable[[Any], Any]:
    """Return what makes arrays whole on every device of a mesh; training does so at each checkpoint."""
    return jax.jit(lambda arrays: arrays, out_shardings=NamedSharding(mesh, PartitionSpec()))
