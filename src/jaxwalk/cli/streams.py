"""Standard streams on which a command can always write: also if they are closed, unread, full or in ASCII."""

from __future__ import annotations

import os
import sys
from typing import Any

from jaxwalk.runs.watchdog import LAUNCHED


class ForgivingStream:
    """A stream that goes on, without a word, after certain errors; what is written afterwards is lost."""

    def __init__(self, stream: Any, forgives: type[OSError]) -> None:
        self._stream, self._forgives = stream, forgives

    def write(self, text: str) -> int:
        """Write the text."""
        try:
            return self._stream.write(text)
        except self._forgives:
            discard(self._stream)
            return len(text)

    def flush(self) -> None:
        """Write what is buffered."""
        try:
            self._stream.flush()
        except self._forgives:
            discard(self._stream)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def prepare_streams() -> None:
    """Make the process's standard streams writable, whatever the caller has connected them to.

    What is closed leads nowhere. A reader of the output who stops reading, such as `head`, ends nothing. Messages that
    can't be shown end nothing either. Characters that the stream's encoding lacks are written as escapes.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # takes the lowest free number, which is this one
    out: Any = sys.stdout or os.fdopen(1, "w", encoding="utf-8", closefd=False)
    err: Any = sys.stderr or os.fdopen(2, "w", encoding="utf-8", closefd=False)
    if LAUNCHED in os.environ:  # where people look; on the usual one are messages of libraries
        err = os.fdopen(int(os.environ[LAUNCHED]), "w", buffering=1, encoding="utf-8", errors="backslashreplace")
    for stream in (out, err):
        if stream.errors == "strict" or stream.encoding.lower() != "utf-8":  # surrogateescape writes names as they are
            stream.reconfigure(errors="backslashreplace")
    sys.stdout, sys.stderr = ForgivingStream(out, BrokenPipeError), ForgivingStream(err, OSError)


def discard(stream: Any) -> None:
    """Lead a stream nowhere, so that what is buffered causes no more errors, at the end of the process either."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
