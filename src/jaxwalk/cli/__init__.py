"""The command ``jaxwalk``: reads the options, then imports and runs the command that they name.

Bad input gives one message on standard error and exit code 2, and nothing is written.
"""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from jaxwalk.cli.errors import BAD_INPUT, INTERRUPTED, message

GARBAGE = 100_000
"""Number of new objects after which Python collects garbage (Python's default: 700, later 2,000)."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code. ``arguments``: those after ``jaxwalk`` (default: the process's)."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if arguments[:1] == ["--version"]:
        from importlib.metadata import version

        print(f"jaxwalk {version('jaxwalk')}")
        return 0
    try:
        from jaxwalk.cli import commands

        options = commands.parse(arguments)
        gc.set_threshold(GARBAGE)  # modules and programs stay in memory: revisiting them takes 0.4 s
        _keep_compiled_code()
        _make_devices_of_cores()
        code = commands.run(options)
        _flush()
        return code
    except SystemExit as end:  # --help, or an option that does not exist
        return int(end.code or 0) if not isinstance(end.code, str) else BAD_INPUT
    except KeyboardInterrupt:
        print("jaxwalk: interrupted", file=sys.stderr)
        return INTERRUPTED
    except (ValueError, OSError, MemoryError, RuntimeError) as error:
        if isinstance(error, BrokenPipeError) and error.filename is None:
            sys.stderr.close()  # the reader of the output, such as `head`, closed it early
            return 1
        text = message(error)
        if text is None:
            raise
        print(f"jaxwalk: {text}", file=sys.stderr)
        return BAD_INPUT


def _flush() -> None:
    """Print buffered output, while a full disk can still be reported."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is buffered can't be written anywhere
        raise


def _keep_compiled_code() -> None:
    """Let JAX store compiled code in the user's cache folder, unless JAX's own variables say otherwise."""
    if "JAX_COMPILATION_CACHE_DIR" in os.environ or "JAX_ENABLE_COMPILATION_CACHE" in os.environ:
        return
    os.environ["JAX_COMPILATION_CACHE_DIR"] = str(_cache_folder())
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")


def _make_devices_of_cores() -> None:
    """Make each core a device of JAX, so that environments can be shared out, unless the user has set a number."""
    if "host_platform_device_count" not in os.environ.get("XLA_FLAGS", ""):
        from jaxwalk.runs.provenance import cores

        os.environ.setdefault("JAX_NUM_CPU_DEVICES", str(cores()))


def _cache_folder() -> Path:
    """Return the user's cache folder on this platform."""
    given = os.environ.get("XDG_CACHE_HOME")
    if given:
        return Path(given) / "jaxwalk"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "jaxwalk" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "jaxwalk"
    return Path.home() / ".cache" / "jaxwalk"
