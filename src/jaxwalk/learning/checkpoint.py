"""Saving training in the middle, so that it goes on as if it had never stopped.

Orbax writes a checkpoint under another name and renames it when it is whole, so an interrupted save leaves the one
before it. A checkpoint is a folder per number of updates inside the folder given.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import orbax.checkpoint as ocp
from jaxtyping import Array

KEPT = 2
"""Older checkpoints than the last so many are deleted."""

T = TypeVar("T")


class CheckpointError(ValueError):
    """A checkpoint that can't be continued from; one line says why and what to do."""


def save(path: str | Path, learner: Any, *, updates: int) -> None:
    """Write all arrays of the learner (random keys too) into folder ``path`` under the number ``updates``."""
    with _manager(path, create=True) as manager:
        manager.save(updates, args=ocp.args.StandardSave(_named_arrays(learner)))
        manager.wait_until_finished()


def latest(path: str | Path) -> int | None:
    """The number of updates of the newest checkpoint in the folder; None if there is none."""
    if not Path(path).is_dir():
        return None
    with _manager(path, create=False) as manager:
        return manager.latest_step()


def restore(path: str | Path, like: T, *, updates: int | None = None) -> T:
    """The learner of the newest checkpoint in the folder, or of that number.

    ``like`` is a learner for the same environment and configuration, such as `mappo.init` makes: it says how the
    arrays are put together, and everything that is no array is taken from it.
    """
    step = latest(path) if updates is None else updates
    if step is None:
        raise CheckpointError(f"{path}: holds no checkpoint; give the folder that training wrote, or start anew")
    wanted = _named_arrays(like)
    with _manager(path, create=False) as manager:
        try:
            stored = {name: tuple(x.shape) for name, x in manager.item_metadata(step).items()}
            _check_same(path, wanted, stored)
            found = manager.restore(step, args=ocp.args.StandardRestore(jax.tree.map(_abstract, wanted)))
        except CheckpointError:
            raise
        except Exception as error:  # orbax raises many kinds
            kind = type(error).__name__
            raise CheckpointError(
                f"{path}: checkpoint {step} can't be read ({kind}); delete its folder to use an older one"
            ) from error
    arrays, rest = eqx.partition(like, eqx.is_array)
    names, structure = _names(arrays), jax.tree.structure(arrays)
    return eqx.combine(jax.tree.unflatten(structure, [found[name] for name in names]), rest)


def _check_same(path: str | Path, wanted: dict[str, Array], stored: dict[str, tuple[int, ...]]) -> None:
    """Raise unless the checkpoint has exactly the wanted arrays."""
    mend = "train with the configuration that it was made with, or start anew in another folder"
    for name in sorted(wanted.keys() ^ stored.keys()):
        lack = "lacks" if name in wanted else "has an unexpected"
        raise CheckpointError(f"{path}: the checkpoint {lack} {name}; {mend}")
    for name, x in wanted.items():
        shape = jax.eval_shape(_data, x).shape
        if stored[name] != shape:
            raise CheckpointError(f"{path}: {name} has shape {stored[name]} in the checkpoint, not {shape}; {mend}")


def _data(x: Array) -> Array:
    return jax.random.key_data(x) if jnp.issubdtype(x.dtype, jax.dtypes.prng_key) else x


def _manager(path: str | Path, *, create: bool) -> ocp.CheckpointManager:
    options = ocp.CheckpointManagerOptions(max_to_keep=KEPT, create=create, enable_async_checkpointing=False)
    return ocp.CheckpointManager(Path(path).resolve(), options=options, item_handlers=ocp.StandardCheckpointHandler())


def _names(arrays: Any) -> list[str]:
    return [jax.tree_util.keystr(where) for where, _ in jax.tree_util.tree_leaves_with_path(arrays)]


def _named_arrays(learner: Any) -> dict[str, Array]:
    arrays = eqx.filter(learner, eqx.is_array)
    return dict(zip(_names(arrays), jax.tree.leaves(arrays), strict=True))


def _abstract(x: Array) -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct(x.shape, x.dtype, sharding=x.sharding)
