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
    """Keep other processes from writing into the folder, which is made if it doesn't exist.

    The operating system lets go of it however the process ends: after a crash nothing has to be tidied up. Raises
    InUseError if another process, or another thread of this one, has it, at once or after a wait of some ``seconds``.
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
