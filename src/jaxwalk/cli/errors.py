"""Errors of the command line: errors about options, the messages of all errors, and the exit codes."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager

from jaxwalk.wording import plain

DIFFERS, BAD_INPUT, LOST, INTERRUPTED = 1, 2, 3, 130
"""Exit codes: for results that don't come out again or fall short of what is required, for input that can't be used,
for a training that lost one of its processes, and for Ctrl-C."""
ADVICE = {
    errno.ENOSPC: "make room on the disk, or name another place",
    errno.EDQUOT: "make room on the disk, or name another place",
    errno.EFBIG: "files may not be so large here; raise the limit, or name another place",
    errno.EROFS: "name another place",
}
"""Advice for errors of the operating system."""
LONGEST_LINE = 2000
"""Longest line of a message [characters]. Parts of it may be a stranger's: names, and what a driver raised."""


class UsageError(ValueError):
    """Options that make no sense. The message says why and what to do, in one line."""


@contextmanager
def bad_values() -> Iterator[None]:
    """Turn any ValueError that is not jaxwalk's own into a UsageError. Use it around what is built from options."""
    try:
        yield
    except ValueError as error:
        if type(error).__module__.startswith("jaxwalk"):
            raise
        raise UsageError(f"{error}; see the command's --help") from error


def message(error: Exception) -> str | None:
    """Return the message about bad input; None for an error in the program itself."""
    if isinstance(error, OSError):
        where = f"{error.filename}: " if error.filename else ""
        what = " ".join(str(error.strerror or error).split())
        advice = ADVICE.get(error.errno or 0, "check the path and its permissions")
        return plain(f"{where}{what}; {advice}", LONGEST_LINE)
    if isinstance(error, MemoryError) or "RESOURCE_EXHAUSTED" in str(error):  # (the latter is JAX's word for it)
        return "not enough memory; ask for fewer environments or pedestrians, smaller networks, files or archives"
    if not type(error).__module__.startswith("jaxwalk"):
        return None
    in_lines = hasattr(error, "faults")  # a MapError has a line for each
    lines = [plain(line, LONGEST_LINE) for line in str(error).split("\n")]
    return ("\n" if in_lines else " ").join(lines)
