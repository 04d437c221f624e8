"""A lock that lets one process at a time write into a folder."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

LOCK = ".lock"
"""Name of the lock file inside the folder. The file stays; what counts is whether a process holds it."""


class InUseError(ValueError):
    """Another process writes into the folder."""


@contextmanager
def held(folder: Path, *, seconds: float = 0.0) -> Iterator[None]:
    """Lock a folder while the block runs, so that no other process writes into it.

    The operating system frees the lock however the process ends: after a crash nothing has to be tidied up.

    Args:
        folder: the folder; it is made if it doesn't exist.
        seconds: how long to wait for the lock if another process has it [s].

    Raises:
        InUseError: another process, or another thread of this one, still has the lock then.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / LOCK)
    try:
        lock.acquire(timeout=seconds)
    except Timeout:
        raise InUseError(
            f"{folder}: another process is writing into it; wait until that has ended, or name another folder"
        ) from None
    try:
        yield
    finally:
        lock.release()
