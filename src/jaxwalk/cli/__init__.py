"""The command ``jaxwalk``: reads the options, then imports and runs the command that they name.

This is the one boundary for errors: whatever can't be used gives one message on standard error and exit code 2, and
nothing is written. An error that isn't caught here is a fault of jaxwalk, and gives a traceback.
"""

from __future__ import annotations

import atexit
import gc
import sys
from collections.abc import Sequence
from functools import cache

from jaxwalk.cli.errors import BAD_INPUT, INTERRUPTED, message
from jaxwalk.cli.signals import Signals, leave
from jaxwalk.cli.streams import discard, prepare_streams

GARBAGE = 1_000_000
"""Number of new objects after which Python collects garbage (its own default: 700, later 2,000)."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code.

    Args:
        arguments: the words after ``jaxwalk``; default: those of the process, which is then prepared for closed
            streams and for signals, and ended here if a signal arrives.
    """
    if arguments is not None:
        return _run(list(arguments), Signals())
    signals = Signals()
    prepare_streams()
    signals.listen()
    code = _run(sys.argv[1:], signals)
    signals.ignore()
    if signals.number is not None or (code and _has_peers()):
        leave(code)
    return code


def _has_peers() -> bool:
    """Return whether other processes train with this one: JAX would wait for them at the end, though one has failed."""
    return "jax" in sys.modules and sys.modules["jax"].distributed.is_initialized()


def _run(arguments: list[str], signals: Signals) -> int:
    """Run the command and return its exit code; print the message of an error."""
    try:
        code = _command(arguments)
        sys.stdout.flush()
        return signals.code if code == INTERRUPTED else code
    except (KeyboardInterrupt, Exception) as error:
        if isinstance(error, KeyboardInterrupt) or signals.number is not None:  # other errors may follow from a signal
            print("jaxwalk: interrupted", file=sys.stderr)
            return signals.code
        text = message(error)
        if text is None:
            raise
        _drop_output()
        print(f"jaxwalk: {text}", file=sys.stderr)
        return BAD_INPUT


def _command(arguments: list[str]) -> int:
    """Run the command that the arguments name."""
    if arguments[:1] == ["--version"]:
        from importlib.metadata import version

        print(f"jaxwalk {version('jaxwalk')}")
        return 0
    _seldom_collect_garbage()
    from jaxwalk.cli import commands
    from jaxwalk.cli.group import launches

    try:
        options = commands.parse(arguments)
        if launches(options):
            from jaxwalk.cli.launcher import launch

            return launch(options, arguments)
        return commands.run(options)
    except SystemExit as end:  # --help, or an option that does not exist
        return int(end.code or 0) if not isinstance(end.code, str) else BAD_INPUT


@cache
def _seldom_collect_garbage() -> None:
    """Let Python look for garbage seldom, and not at the process's end.

    What imports and tracing make stays. To revisit it took 0.2 s until a first update, and 0.5 s at the end.
    """
    gc.set_threshold(GARBAGE)
    atexit.register(gc.freeze)


def _drop_output() -> None:
    """Write what is buffered; drop it if that fails, so that the error doesn't come again at the end."""
    try:
        sys.stdout.flush()
    except OSError:
        discard(sys.stdout)
