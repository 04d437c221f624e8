"""Atomic writing of files: a file appears whole or not at all, whatever happens while it is written."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_own_unfinished: set[Path] = set()
"""The temporary files that this process is writing."""


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """Yield the path of a temporary file, which replaces ``path`` at the end. It is removed if anything fails.

    An OSError, such as for a full disk, names ``path``.
    """
    path = Path(path)
    unfinished = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    _own_unfinished.add(unfinished)
    try:
        with naming(path):
            yield unfinished
            _to_disk(unfinished)
            unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
        _own_unfinished.discard(unfinished)


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


def _to_disk(path: Path) -> None:
    """Wait until the content is on the disk. Without this, a renamed file could be empty after a power failure."""
    with path.open("rb+") as file:
        os.fsync(file.fileno())
