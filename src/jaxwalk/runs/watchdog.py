"""Ends a training of several processes in which one hangs: the others would wait for it for ever.

JAX ends the processes if one of them has died, or doesn't run at all any more. One that runs but doesn't come to its
next update, for example because a disk doesn't answer, is noticed only here: then no process finishes an update.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable

LEAST, TIMES = 300.0, 20.0
"""An update may take this long [s], or this many times the longest one before; the first two compile, any time."""
HUNG = 4
"""Exit code of a process that ends because one of them hangs."""
LAUNCHED = "JAXWALK_LAUNCHED"
"""Environment variable of a process whose launcher says what has happened to it: the file descriptor for messages."""


def end_process(seconds: float) -> None:
    """End this process at once, though it waits in a library for another one."""
    if LAUNCHED not in os.environ:
        said = f"jaxwalk: no update was finished for {seconds:.0f} s, as a process hangs; resume the training"
        print(said, file=sys.stderr, flush=True)
    os._exit(HUNG)


class Watchdog:
    """Calls a function if no update is finished for long. Use it in a ``with``."""

    def __init__(self, end: Callable[[float], None] = end_process, least: float = LEAST) -> None:
        """Call ``end`` with the seconds without an update, if these are above ``least`` and `TIMES` the longest."""
        self._end, self._least = end, least
        self._finished, self._longest, self._since = 0, 0.0, time.monotonic()
        self._news, self._over = threading.Event(), False
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> Watchdog:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over = True
        self._news.set()

    def finished(self) -> None:
        """Say that an update is finished."""
        now = time.monotonic()
        if self._finished:
            self._longest = max(self._longest, now - self._since)
        self._finished, self._since = self._finished + 1, now
        self._news.set()

    def _watch(self) -> None:
        while not self._over:
            limit = max(self._least, TIMES * self._longest) if self._finished > 1 else None
            if not self._news.wait(limit):
                self._end(limit or 0.0)
                return
            self._news.clear()
