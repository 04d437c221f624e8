"""Files that are there whole or not at all, whatever happens while they are written."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """A file beside ``path`` to be written, which becomes it at the end and vanishes if anything goes wrong.

    An OSError, as of a full disk, names ``path``.
    """
    path = Path(path)
    unfinished = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        with naming(path):
            yield unfinished
            _to_disk(unfinished)
            unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """While inside, an OSError is about that file: one from writing doesn't say so itself."""
    try:
        yield
    except OSError as error:
        if error.errno is None:  # some libraries give a text alone
            raise OSError(errno.EIO, str(error), str(path)) from error
        if error.filename is None or is_unfinished(Path(str(error.filename))):  # (not another file, which is read)
            error.filename = str(path)
        raise


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file as `whole` does."""
    with whole(path) as unfinished:
        unfinished.write_bytes(content.encode() if isinstance(content, str) else content)


def is_unfinished(path: Path) -> bool:
    """Whether it is what a process that was killed left of a file."""
    return path.name.startswith(".") and ".part" in path.suffixes[-2:]


def remove_unfinished(folder: Path) -> None:
    """Remove what processes that were killed left of files, from a folder into which nobody else writes."""
    for path in filter(is_unfinished, folder.iterdir()):
        path.unlink()


def _to_disk(path: Path) -> None:
    """Wait until the content is on the disk: renamed before, a file could be empty after a power failure."""
    with path.open("rb+") as file:
        os.fsync(file.fileno())
