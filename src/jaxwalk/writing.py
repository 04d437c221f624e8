"""Atomic writing of files: a file appears whole or not at all, whatever happens while it is written."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

_own_unfinished: set[Path] = set()
"""The temporary files that this process is writing."""
_waiting: ContextVar[dict[Path, Path] | None] = ContextVar("waiting", default=None)
"""Inside `together`: the files to be replaced, and the temporary file of each."""


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """Yield the path of a temporary file, which replaces ``path`` at the end. It is removed if anything fails.

    Inside `together`, it replaces ``path`` when all others do. An OSError, such as for a full disk, names ``path``.
    """
    path = Path(path)
    unfinished = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    _own_unfinished.add(unfinished)
    try:
        with naming(path):
            yield unfinished
            _to_disk(unfinished)
            _put(unfinished, path)
    except BaseException:
        _remove(unfinished)
        raise


@contextmanager
def together() -> Iterator[None]:
    """Let all files that are written inside appear at the end, or none: then older ones stay as they are.

    Each is written beside its place, so a full disk shows before the first one is replaced. `current` finds them.
    """
    if _waiting.get() is not None:  # then these files appear with those of the caller
        yield
        return
    waiting: dict[Path, Path] = {}
    token = _waiting.set(waiting)
    try:
        yield
        for path in filter(Path.is_dir, waiting):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        _waiting.set(None)
        for path, unfinished in waiting.items():
            _put(unfinished, path)
    finally:
        _waiting.reset(token)
        for unfinished in waiting.values():
            _remove(unfinished)


def current(path: Path) -> Path:
    """Return where the content of a file is that has been written: inside `together`, not yet in its place."""
    return (_waiting.get() or {}).get(path, path)


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Make an OSError inside name the file, because an error from writing doesn't."""
    try:
        yield
    except OSError as error:
        if error.errno is None:  # some libraries set only the message
            raise OSError(errno.EIO, str(error), str(path)) from error
        if error.filename is None or is_unfinished(Path(str(error.filename))):  # not a file being read
            error.filename = str(path)
        raise


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file atomically, as `whole` does."""
    with whole(path) as unfinished:
        unfinished.write_bytes(content.encode() if isinstance(content, str) else content)


def mark(path: Path) -> None:
    """Make an empty file for `unmark` or `remove_own_unfinished`: a process that fails or is killed leaves it."""
    path.touch()
    _own_unfinished.add(path)


def unmark(path: Path) -> None:
    """Remove a file that `mark` made."""
    _remove(path)


def is_unfinished(path: Path) -> bool:
    """Return whether a file is the temporary file of a killed process."""
    return path.name.startswith(".") and ".part" in path.suffixes[-2:]


def remove_unfinished(folder: Path) -> None:
    """Remove the temporary files of killed processes from a folder into which nobody else writes."""
    for path in filter(is_unfinished, folder.iterdir()):
        path.unlink()


def remove_own_unfinished() -> None:
    """Remove the temporary files of this process, which is about to end."""
    for path in list(_own_unfinished):
        with suppress(OSError):
            path.unlink(missing_ok=True)


def _put(unfinished: Path, path: Path) -> None:
    """Let a complete file replace ``path``, inside `together` at its end."""
    waiting = _waiting.get()
    if waiting is not None:
        waiting[path] = unfinished
        return
    with naming(path):
        unfinished.replace(path)
    _own_unfinished.discard(unfinished)


def _remove(unfinished: Path) -> None:
    """Remove a temporary file of this process."""
    unfinished.unlink(missing_ok=True)
    _own_unfinished.discard(unfinished)


def _to_disk(path: Path) -> None:
    """Wait until the content is on the disk. Without this, a renamed file could be empty after a power failure."""
    with path.open("rb+") as file:
        os.fsync(file.fileno())
