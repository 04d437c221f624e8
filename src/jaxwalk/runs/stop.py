"""Handling of Ctrl-C, and of other signals that end a process, during work that should end cleanly."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

HANGUP = getattr(signal, "SIGHUP", None)
"""Signal of a terminal that is closed; Windows has none. It often arrives twice, so a second one says nothing new."""
ENDING = tuple(number for number in (signal.SIGINT, signal.SIGTERM, HANGUP) if number is not None)
"""Signals that ask a process to end."""


class Stop:
    """Lets the update in progress finish on the first Ctrl-C, SIGTERM or SIGHUP; a second one interrupts at once."""

    requested = False
    """Whether the work should end; `jaxwalk.runs.session` may ask for that too."""
    heard = False
    """Whether a signal asked for it, even if the work was done by then."""

    @contextmanager
    def listening(self) -> Iterator[Stop]:
        """Handle the signals inside the ``with``, except those that the process ignores."""
        if threading.current_thread() is not threading.main_thread():
            yield self
            return
        before = {number: signal.getsignal(number) for number in ENDING}
        before = {number: handler for number, handler in before.items() if handler is not signal.SIG_IGN}
        for number in before:
            signal.signal(number, self._hear)
        try:
            yield self
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def _hear(self, number: int, _: object) -> None:
        if self.requested and number != HANGUP:
            raise KeyboardInterrupt
        self.requested = self.heard = True
