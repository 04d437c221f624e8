"""Save training, so that it can resume as if it had never stopped.

Orbax writes a checkpoint under a temporary name and renames it when it is complete, so an interrupted save leaves the
previous one intact. A checkpoint is a folder inside the given folder, named after its number of updates. The newest may
still be damaged, for instance by a power failure; so two are kept, and `restore_newest` falls back to the older one.
Orbax takes a second to import, so it is imported where needed: the first update of a training does not wait for it.
"""

from __future__ import annotations

import errno
import os
import re
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array

KEPT = 2
"""Number of checkpoints kept; older ones are deleted."""
LISTS = 1_000_000
"""Largest size of what a checkpoint holds besides its arrays [bytes]."""
RENAMED = {
    r"^\.stream\.memory\.(driver|pedestrian)": r".stream.memory['\1']",
    r"^(\.stream\.memory\b.*)\.left$": r"\1.steps_left",
    r"^(\.stream\.state\.pedestrian\.(?:leg|following))\.kerb$": r"\1.kerb_past_end",
}
"""What version 0.1 called an array (a pattern), and what it is called now."""
UNFINISHED = "*.orbax-checkpoint-tmp*"
"""Names of incomplete checkpoints."""

T = TypeVar("T")


class CheckpointError(ValueError):
    """Raised for a checkpoint from which training cannot resume; one line says why and what to do."""


class DamagedError(CheckpointError):
    """Raised for a checkpoint that cannot be read."""


def save(path: str | Path, learner: Any, *, updates: int, about: Mapping[str, Any] | None = None) -> None:
    """Write all arrays of the learner (of random keys their data) into folder ``path`` under the number ``updates``.

    ``about`` is JSON to keep with them, which `kept_with` returns. Raise OSError if that fails, for instance on a full
    disk; earlier checkpoints remain.
    """
    # NumPy arrays: orbax would split arrays that several devices hold, by a program for each shape, and doesn't let one
    # of several processes write JAX's.
    _write(path, jax.device_get({name: _data(x) for name, x in _named_arrays(learner).items()}), updates, about)


def copy(path: str | Path, to: str | Path, *, updates: int, changes: Mapping[str, Any]) -> None:
    """Copy a checkpoint of folder ``path`` into folder ``to``, with changes of the JSON that is kept with it.

    The copy appears whole or not at all. Raise DamagedError if the checkpoint is missing or can't be read, and OSError
    if the copy can't be written.
    """
    from orbax.checkpoint.args import StandardRestore

    kept = kept_with(path, updates)
    if not kept:
        raise _no_beginning(path, updates, "nothing is kept with it")
    with _manager(path) as manager:
        try:
            arrays = jax.device_get(manager.restore(updates, args=StandardRestore()))
        except Exception as error:  # orbax raises many kinds
            raise _no_beginning(path, updates, type(error).__name__) from error
    _write(to, arrays, updates, kept | dict(changes))


def _no_beginning(path: str | Path, updates: int, why: str) -> DamagedError:
    """Return the error of a training that was to begin at a checkpoint of another one."""
    return DamagedError(
        f"{path}: checkpoint {updates} is missing or can't be read ({why}), and another training was to begin there; "
        "restore it from a copy, or start again in another folder"
    )


def _write(path: str | Path, arrays: dict[str, Any], updates: int, about: Mapping[str, Any] | None) -> None:
    """Do the work of `save` and `copy`."""
    _check_room(Path(path), sum(x.nbytes for x in arrays.values()))
    try:
        _put(path, arrays, updates, dict(about or {}))
    except Exception as error:  # orbax raises many kinds
        for unfinished in Path(path).glob(UNFINISHED):
            shutil.rmtree(unfinished, ignore_errors=True)
        raise _as_os_error(error, Path(path) / str(updates)) from error


def _put(path: str | Path, arrays: dict[str, Any], updates: int, about: dict[str, Any]) -> None:
    """Let orbax write a checkpoint."""
    from orbax.checkpoint.args import StandardSave

    with _manager(path, writes=True) as manager:  # this also removes what a killed process left incomplete
        if not manager.save(updates, args=StandardSave(arrays), custom_metadata=about):
            raise OSError(errno.EEXIST, "a newer checkpoint is in the way", str(path))
        manager.wait_until_finished()


def _check_room(path: Path, size: int) -> None:
    """Raise OSError unless the disk has room for ``size`` bytes: orbax would print pages before it fails."""
    path.mkdir(parents=True, exist_ok=True)
    if shutil.disk_usage(path).free < size + LISTS:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))


def latest(path: str | Path) -> int | None:
    """Return the number of updates of the newest checkpoint in the folder; None if there is none."""
    if not Path(path).is_dir():
        return None
    with _manager(path) as manager:
        return manager.latest_step()


def kept_with(path: str | Path, updates: int) -> dict[str, Any]:
    """Return the JSON that was saved with a checkpoint; empty if it has none, or if that can't be read."""
    with _manager(path) as manager:
        try:
            return dict(manager.metadata(updates).custom_metadata or {})
        except Exception:  # orbax raises many kinds
            return {}


def restore_newest(path: str | Path, like: T, *, tell: Callable[[str], None]) -> T | None:
    """Return the learner of the newest readable checkpoint; None if there is no checkpoint at all.

    Damaged newer ones are renamed, so that they do not block later checkpoints, and ``tell`` is called with a line
    about each. Raise DamagedError if none is readable; then none is renamed. ``like``: see `restore`.
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
        raise DamagedError(f"{next(iter(damaged.values()))}; neither can an older one. Start again in another folder")
    return None


def _numbers(path: str | Path) -> list[int]:
    """Return the numbers of updates of all checkpoints, newest first."""
    if not Path(path).is_dir():
        return []
    with _manager(path) as manager:
        return sorted(manager.all_steps(), reverse=True)


def _put_aside(checkpoint: Path) -> Path:
    """Rename a checkpoint, so that it no longer counts as one; return its new path."""
    aside = checkpoint.with_name(f"{checkpoint.name}.damaged")
    shutil.rmtree(aside, ignore_errors=True)
    return checkpoint.rename(aside)


def restore(path: str | Path, like: T, *, updates: int | None = None) -> T:
    """Return the learner of the newest checkpoint in the folder, or of the one with this number.

    ``like`` is a learner for the same environment and configuration, for instance from `mappo.init`: it gives the
    structure of the arrays, and everything that is not an array.
    """
    from orbax.checkpoint.args import StandardRestore

    step = latest(path) if updates is None else updates
    if step is None:
        raise CheckpointError(f"{path}: holds no checkpoint; give the folder that training wrote, or start again")
    wanted = _named_arrays(like)
    with _manager(path) as manager:
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
    arrays = [_as_wanted(found[stored[name]], wanted[name]) for name in names]
    return eqx.combine(jax.tree.unflatten(structure, arrays), rest)


def _check_same(path: str | Path, wanted: dict[str, Array], stored: dict[str, tuple[int, ...]]) -> None:
    """Raise CheckpointError unless the checkpoint has exactly the wanted arrays."""
    advice = "resume it with the version and configuration that made it, or start again in another folder"
    for name in sorted(wanted.keys() ^ stored.keys()):
        lack = "lacks" if name in wanted else "has an unexpected"
        raise CheckpointError(f"{path}: the checkpoint {lack} {name}; {advice}")
    for name, x in wanted.items():
        shape = jax.eval_shape(_data, x).shape
        if stored[name] != shape:
            raise CheckpointError(f"{path}: {name} has shape {stored[name]} in the checkpoint, not {shape}; {advice}")


def _as_os_error(error: Exception, path: Path) -> OSError:
    """Return the operating system's error, if there was one: tensorstore hides it in a long message."""
    for number in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES):
        if os.strerror(number) in str(error):
            return OSError(number, os.strerror(number), str(path))
    return OSError(errno.EIO, " ".join(str(error).split())[:300], str(path))


def _is_key(x: Array) -> bool:
    return jnp.issubdtype(x.dtype, jax.dtypes.prng_key)


def _data(x: Array) -> Array:
    return jax.random.key_data(x) if _is_key(x) else x


def _manager(path: str | Path, *, writes: bool = False) -> Any:
    """Return orbax's checkpoint manager for the folder."""
    import orbax.checkpoint as ocp

    own = jax.process_index()  # each process reads by itself, and only the first one writes
    alone = ocp.options.MultiprocessingOptions(
        primary_host=own, active_processes={own}, barrier_sync_key_prefix=f"process-{own}"
    )
    options = ocp.CheckpointManagerOptions(
        max_to_keep=KEPT, create=False, enable_async_checkpointing=False, cleanup_tmp_directories=writes,
        multiprocessing_options=alone,
    )  # fmt: skip
    return ocp.CheckpointManager(Path(path).resolve(), options=options, item_handlers=ocp.StandardCheckpointHandler())


def _name_now(name: str) -> str:
    """Return the present name of an array in a checkpoint of version 0.1."""
    for before, now in RENAMED.items():
        name = re.sub(before, now, name)
    return name


def _names(arrays: Any) -> list[str]:
    return [jax.tree_util.keystr(where) for where, _ in jax.tree_util.tree_leaves_with_path(arrays)]


def _named_arrays(learner: Any) -> dict[str, Array]:
    arrays = eqx.filter(learner, eqx.is_array)
    return dict(zip(_names(arrays), jax.tree.leaves(arrays), strict=True))


def _abstract(x: Array) -> jax.ShapeDtypeStruct:
    data = jax.eval_shape(_data, x)
    return jax.ShapeDtypeStruct(data.shape, data.dtype, sharding=x.sharding)


def _as_wanted(found: Array, wanted: Array) -> Array:
    """Return a stored array, as a key if that is wanted. Checkpoints of version 0.1 hold keys as such."""
    bare = _is_key(wanted) and not _is_key(found)
    return jax.random.wrap_key_data(found, impl=jax.random.key_impl(wanted)) if bare else found
