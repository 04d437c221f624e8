"""Handling of Ctrl-C during work that should end cleanly."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


class Stop:
    """Lets the update in progress finish on the first Ctrl-C; a second one interrupts at once."""

    requested = False

    @contextmanager
    def listening(self) -> Iterator[Stop]:
        """Handle Ctrl-C inside the ``with``."""
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
