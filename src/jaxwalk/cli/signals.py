"""How signals end a command: in order within seconds, and at once if a second one comes.

Python handles signals between its own instructions, and a program may compile for a minute in one of them. So a thread
of its own hears them too, and ends a process that doesn't end by itself.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import sys
import threading
from contextlib import suppress
from typing import Any

from jaxwalk.cli.errors import INTERRUPTED
from jaxwalk.runs.stop import ENDING, HANGUP, Stop
from jaxwalk.writing import remove_own_unfinished

TERMINATED = 143
"""Exit code after SIGTERM, and after SIGHUP."""
PATIENCE = 4.0
"""Time that a command has to end in order [s]."""


class Signals:
    """The first signal that asked this process to end."""

    number: int | None = None
    """The signal; None if there was none."""
    _heard: threading.Event | None = None

    @property
    def code(self) -> int:
        """The exit code of a command that the signal ended."""
        if self._heard is not None:
            self._heard.wait(1.0)  # the command may be quicker than the thread
        return INTERRUPTED if self.number in (None, signal.SIGINT) else TERMINATED

    def listen(self) -> None:
        """Hear signals until the process ends. Those that the caller has it ignore, as `nohup` does, stay ignored."""
        heard = [number for number in ENDING if signal.getsignal(number) is not signal.SIG_IGN]
        for number in heard:
            signal.signal(number, signal.default_int_handler)
        sys.unraisablehook = _tell_unraisable
        self._heard = threading.Event()
        ours, pythons = socket.socketpair()
        pythons.setblocking(False)
        signal.set_wakeup_fd(pythons.fileno(), warn_on_full_buffer=False)
        threading.Thread(target=self._watch, args=(ours, pythons, heard, self._heard), daemon=True).start()

    def ignore(self) -> None:
        """Ignore signals: the command has ended, and Python would die of one while it leaves."""
        for number in ENDING:
            signal.signal(number, signal.SIG_IGN)

    def _watch(self, ours: socket.socket, _pythons: socket.socket, heard: list[int], first: threading.Event) -> None:
        """End the process if it doesn't end in time. (The other socket is a parameter so that it stays open.)"""
        while self.number is None:
            self.number = next((number for number in ours.recv(1) if number in heard), None)
        first.set()
        while _wait(ours, None if _ends_in_order(self.number) else PATIENCE):
            again = ours.recv(1)[0]
            if again in heard and again != HANGUP:
                break
        self.end_now()

    def end_now(self) -> None:
        """End the process without waiting for its threads. Nothing that it was writing stays."""
        remove_own_unfinished()
        shown = "\x1b[?25h" if os.isatty(2) else ""  # a progress bar hides the cursor
        with suppress(OSError):
            os.write(2, f"{shown}jaxwalk: interrupted\n".encode())
        os._exit(self.code)


def leave(code: int) -> None:
    """End the process without waiting for threads, after everything is written."""
    with suppress(OSError):
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(code)


def _tell_unraisable(found: Any) -> None:
    """Print an error that Python can't raise, unless a signal caused it: the thread ends the process then."""
    if not issubclass(found.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(found)


def _ends_in_order(number: int) -> bool:
    """Return whether a training listens, which ends after the update in flight."""
    return isinstance(getattr(signal.getsignal(number), "__self__", None), Stop)


def _wait(heard: Any, seconds: float | None) -> bool:
    """Return whether a signal arrives in time."""
    return bool(select.select([heard], [], [], seconds)[0])
