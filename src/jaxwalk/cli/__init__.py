"""The command ``jaxwalk``: options are read here; what they ask for is loaded and done only then.

Bad input ends in one message on standard error and exit code 2, with nothing written.
"""

from __future__ import annotations

import errno
import gc
import os
import sys
from collections.abc import Sequence
from pathlib import Path

BAD_INPUT, INTERRUPTED = 2, 130
"""Exit codes: something given can't be used; Ctrl-C."""
GARBAGE = 100_000
"""Objects that may come before Python looks for cycles among them (its own number: 700, later 2,000)."""
MENDS = {
    errno.ENOSPC: "make room on the disk, or name another place",
    errno.EDQUOT: "make room on the disk, or name another place",
    errno.EFBIG: "files may not be so large here; raise the limit, or name another place",
    errno.EROFS: "name another place",
}
"""What to do about errors of the operating system."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code. ``arguments``: without the command's name (default: the process's)."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if arguments[:1] == ["--version"]:
        from importlib.metadata import version

        print(f"jaxwalk {version('jaxwalk')}")
        return 0
    try:
        options = _parse(arguments)
        gc.set_threshold(GARBAGE)  # what is imported and traced stays: looking it through again and again takes 0.4 s
        _keep_compiled_code()
        _make_devices_of_cores()
        code = options.run()
        _flush()
        return code
    except SystemExit as end:  # --help, or an option that does not exist
        return int(end.code or 0) if not isinstance(end.code, str) else BAD_INPUT
    except KeyboardInterrupt:
        print("jaxwalk: interrupted", file=sys.stderr)
        return INTERRUPTED
    except (ValueError, OSError, MemoryError, RuntimeError) as error:
        if isinstance(error, BrokenPipeError) and error.filename is None:
            sys.stderr.close()  # somebody read only the beginning of what was printed
            return 1
        message = _message(error)
        if message is None:
            raise
        print(f"jaxwalk: {message}", file=sys.stderr)
        return BAD_INPUT


def _parse(arguments: list[str]):
    import tyro

    from jaxwalk.cli.options import Command

    return tyro.cli(
        Command,
        args=arguments,
        prog="jaxwalk",
        description="How does a self-driving car behave among people who may jaywalk? Train, evaluate, look, report.",
        config=(tyro.conf.OmitArgPrefixes,),
    )


def _message(error: Exception) -> str | None:
    """What to tell about bad input; None for an error of the program itself."""
    if isinstance(error, OSError):
        where = f"{error.filename}: " if error.filename else ""
        what = " ".join(str(error.strerror or error).split())
        return f"{where}{what}; {MENDS.get(error.errno or 0, 'check the path and its permissions')}"
    if isinstance(error, MemoryError) or "RESOURCE_EXHAUSTED" in str(error):  # (the latter is JAX's word for it)
        return "not enough memory; ask for fewer environments or pedestrians, smaller networks or smaller files"
    ours = type(error).__module__.startswith("jaxwalk")
    return " ".join(str(error).split("\n")) if ours else None


def _flush() -> None:
    """Print what waits, now that a full disk can still be told of."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what waits can go nowhere
        raise


def _keep_compiled_code() -> None:
    """Let JAX keep what it compiles in the user's cache folder, unless JAX's own variables say otherwise."""
    if "JAX_COMPILATION_CACHE_DIR" in os.environ or "JAX_ENABLE_COMPILATION_CACHE" in os.environ:
        return
    os.environ["JAX_COMPILATION_CACHE_DIR"] = str(_cache_folder())
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")


def _make_devices_of_cores() -> None:
    """Let each core be a device of JAX, so that environments can be shared out, unless somebody chose a number."""
    if "host_platform_device_count" not in os.environ.get("XLA_FLAGS", ""):
        from jaxwalk.runs.provenance import cores

        os.environ.setdefault("JAX_NUM_CPU_DEVICES", str(cores()))


def _cache_folder() -> Path:
    """The user's cache folder, as the platform has it."""
    given = os.environ.get("XDG_CACHE_HOME")
    if given:
        return Path(given) / "jaxwalk"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "jaxwalk" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "jaxwalk"
    return Path.home() / ".cache" / "jaxwalk"
