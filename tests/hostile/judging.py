"""Bad input ends in one message: what every generated case is held to."""

from __future__ import annotations

import io
import time
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

from jaxwalk.cli import main
from jaxwalk.writing import is_unfinished

SECONDS = 60.0
"""Nothing that is wrong may take longer to be refused, on however busy a machine."""
LONGEST = 5_000
"""Characters of a message that anybody would read."""


def refused(load: Callable[[], Any]) -> str | None:
    """The message with which something was refused; None if it was taken. Whatever else is raised passes through.

    As on the command line, a path that can't be read is told by the system's own words.
    """
    begun = time.monotonic()
    try:
        load()
        message = None
    except OSError as error:
        message = str(error)
    except ValueError as error:
        if not type(error).__module__.startswith("jaxwalk"):
            raise
        message = str(error)
        assert message.strip(), type(error)
    assert time.monotonic() - begun < SECONDS
    return message


def command(arguments: list[str]) -> tuple[int, str]:
    """Exit code and standard error of a command line; no traceback, and a message if it fails."""
    out, err, begun = io.StringIO(), io.StringIO(), time.monotonic()
    with redirect_stdout(out), redirect_stderr(err):
        code = main(arguments)
    said = err.getvalue()
    assert code in (0, 2), (arguments, code)
    assert "Traceback" not in said, arguments
    assert code == 0 or said.strip() or out.getvalue().strip(), arguments
    assert time.monotonic() - begun < SECONDS, arguments
    return code, said


def unfinished(folder: Path) -> list[str]:
    """Names of half-written files in a folder."""
    return [path.name for path in folder.rglob("*") if is_unfinished(path)]
