"""Ctrl-C while something goes on that should come to a good end."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


class Stop:
    """Ctrl-C asks politely: the update in flight is finished first. A second one interrupts at once."""

    requested = False

    @contextmanager
    def listening(self) -> Iterator[Stop]:
        """Take Ctrl-C while inside."""
        if threading.current_thread() is not threading.main_thread():
            yield self
            return
        before = signal.signal(signal.SIGINT, self._hear)
        try:
            yield self
        finally:
            signal.signal(signal.SIGINT, before)

    def _hear(self, *_: object) -> None:
        if self.requested:
            raise KeyboardInterrupt
        self.requested = True
