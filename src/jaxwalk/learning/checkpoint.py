"""Saving training in the middle, so that it goes on as if it had never stopped.

Orbax writes a checkpoint under another name and renames it when it is whole, so an interrupted save leaves the one
before it. A checkpoint is a folder per number of updates inside the folder given. The newest may still be damaged, as
by a power failure; so two are kept, and `restore_newest` goes back to the older one. Orbax, which takes a second to
import, is imported where it is needed: the first update of a training doesn't wait for it.
"""

from __future__ import annotations

import errno
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array

KEPT = 2
"""Older checkpoints than the last so many are deleted."""
LISTS = 1_000_000
"""What a checkpoint holds besides its arrays has at most so many bytes."""
UNFINISHED = "*.orbax-checkpoint-tmp*"
"""Names of checkpoints that are not whole."""

T = TypeVar("T")


class CheckpointError(ValueError):
    """A checkpoint that can't be continued from; one line says why and what to do."""


class DamagedError(CheckpointError):
    """A checkpoint that can't be read."""


def save(path: str | Path, learner: Any, *, updates: int) -> None:
    """Write all arrays of the learner (random keys too) into folder ``path`` under the number ``updates``.

    Raises OSError if that fails, as on a full disk; the checkpoints before are there still.
    """
    from orbax.checkpoint.args import StandardSave

    arrays = _named_arrays(learner)
    _check_room(Path(path), sum(_data(x).nbytes for x in arrays.values()))
    # Arrays that several devices hold orbax would cut up, by a program for each shape; a numpy array can't be a key.
    arrays |= jax.device_get({name: x for name, x in arrays.items() if not _is_key(x)})
    try:
        with _manager(path, create=True) as manager:  # which also removes what a killed process left unfinished
            if not manager.save(updates, args=StandardSave(arrays)):
                raise OSError(errno.EEXIST, "a newer checkpoint is in the way", str(path))
            manager.wait_until_finished()
    except Exception as error:  # orbax raises many kinds
        for unfinished in Path(path).glob(UNFINISHED):
            shutil.rmtree(unfinished, ignore_errors=True)
        raise _as_os_error(error, Path(path) / str(updates)) from error


def _check_room(path: Path, size: int) -> None:
    """Raise OSError unless the disk has room for arrays of so many bytes: orbax would print pages before it fails."""
    path.mkdir(parents=True, exist_ok=True)
    if shutil.disk_usage(path).free < size + LISTS:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))


def latest(path: str | Path) -> int | None:
    """The number of updates of the newest checkpoint in the folder; None if there is none."""
    if not Path(path).is_dir():
        return None
    with _manager(path, create=False) as manager:
        return manager.latest_step()


def restore_newest(path: str | Path, like: T, *, tell: Callable[[str], None]) -> T | None:
    """The learner of the newest checkpoint that can be read; None if there is no checkpoint at all.

    Damaged ones that are newer are renamed, since they would be in the way of those to come, and ``tell`` is called
    with a line about each. DamagedError if none can be read; then they stay as they are. ``like``: see `restore`.
    """
    damaged: dict[int, DamagedError] = {}
    for updates in _numbers(path):
        try:
            learner = restore(path, like, updates=updates)
        except DamagedError as error:
            damaged[updates] = error
            continue
        for number, error in damaged.items():
            aside = _put_aside(Path(path) / str(number))
            tell(f"{error}; it is now {aside.name}, and training goes on from checkpoint {updates}")
        return learner
    if damaged:
        raise DamagedError(f"{next(iter(damaged.values()))}; nor can an older one. Start anew in another folder")
    return None


def _numbers(path: str | Path) -> list[int]:
    """The updates of all checkpoints, newest first."""
    if not Path(path).is_dir():
        return []
    with _manager(path, create=False) as manager:
        return sorted(manager.all_steps(), reverse=True)


def _put_aside(checkpoint: Path) -> Path:
    """Rename a checkpoint so that it is none any more."""
    aside = checkpoint.with_name(f"{checkpoint.name}.damaged")
    shutil.rmtree(aside, ignore_errors=True)
    return checkpoint.rename(aside)


def restore(path: str | Path, like: T, *, updates: int | None = None) -> T:
    """The learner of the newest checkpoint in the folder, or of that number.

    ``like`` is a learner for the same environment and configuration, such as `mappo.init` makes: it says how the
    arrays are put together, and everything that is no array is taken from it.
    """
    from orbax.checkpoint.args import StandardRestore

    step = latest(path) if updates is None else updates
    if step is None:
        raise CheckpointError(f"{path}: holds no checkpoint; give the folder that training wrote, or start anew")
    wanted = _named_arrays(like)
    with _manager(path, create=False) as manager:
        try:
            metadata = manager.item_metadata(step)
            stored = {_name_now(name): name for name in metadata}
            _check_same(path, wanted, {name: tuple(metadata[old].shape) for name, old in stored.items()})
            asked = {stored[name]: _abstract(x) for name, x in wanted.items()}
            found = manager.restore(step, args=StandardRestore(asked))
        except CheckpointError:
            raise
        except Exception as error:  # orbax raises many kinds
            raise DamagedError(f"{path}: checkpoint {step} can't be read ({type(error).__name__})") from error
    arrays, rest = eqx.partition(like, eqx.is_array)
    names, structure = _names(arrays), jax.tree.structure(arrays)
    return eqx.combine(jax.tree.unflatten(structure, [found[stored[name]] for name in names]), rest)


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


def _as_os_error(error: Exception, path: Path) -> OSError:
    """The operating system's reason, if it was it that refused: tensorstore tells it in the midst of pages."""
    for number in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES):
        if os.strerror(number) in str(error):
            return OSError(number, os.strerror(number), str(path))
    return OSError(errno.EIO, " ".join(str(error).split())[:300], str(path))


def _is_key(x: Array) -> bool:
    return jnp.issubdtype(x.dtype, jax.dtypes.prng_key)


def _data(x: Array) -> Array:
    return jax.random.key_data(x) if _is_key(x) else x


def _manager(path: str | Path, *, create: bool) -> Any:
    """Orbax's, of that folder."""
    import orbax.checkpoint as ocp

    options = ocp.CheckpointManagerOptions(
        max_to_keep=KEPT, create=create, enable_async_checkpointing=False, cleanup_tmp_directories=create
    )
    return ocp.CheckpointManager(Path(path).resolve(), options=options, item_handlers=ocp.StandardCheckpointHandler())


def _name_now(name: str) -> str:
    """Return today's name of an array; 0.1 had an attribute for each role where there is a mapping now."""
    return re.sub(r"^\.stream\.memory\.(driver|pedestrian)", r".stream.memory['\1']", name)


def _names(arrays: Any) -> list[str]:
    return [jax.tree_util.keystr(where) for where, _ in jax.tree_util.tree_leaves_with_path(arrays)]


def _named_arrays(learner: Any) -> dict[str, Array]:
    arrays = eqx.filter(learner, eqx.is_array)
    return dict(zip(_names(arrays), jax.tree.leaves(arrays), strict=True))


def _abstract(x: Array) -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct(x.shape, x.dtype, sharding=x.sharding)
