"""Commands that can be interrupted and continued by running them again."""

from __future__ import annotations

import sys
from collections.abc import Callable

from jaxwalk.cli.errors import INTERRUPTED
from jaxwalk.runs.study import Interrupted


def until_interrupted(make: Callable[[], str]) -> int:
    """Call ``make``, print what it returns, and return the exit code: 0, or 130 if Ctrl-C ended it."""
    try:
        print(make())
    except (Interrupted, KeyboardInterrupt):
        print("Interrupted. The same command goes on where this one stopped.", file=sys.stderr)
        return INTERRUPTED
    return 0
