"""What a command needs of a machine: a place for compiled code, cores, and a JAX that starts, or says why it can't."""

from __future__ import annotations

import logging
import os
import platform
import subprocess
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path

from jaxwalk.cli.group import Group, join, take_cores
from jaxwalk.provenance import commit, cores
from jaxwalk.runs.folder import RunError, check_writable
from jaxwalk.runs.peer_lost import explaining_lost_peers

OWN_ADDRESS = "gloo/transport/tcp/device.cc"
"""Where JAX looks up the address of the machine's own name, as an error of it says."""
START = "import jax; jax.devices()"
"""A program that fails if JAX can't start."""
READ_FLAGS = """
import contextlib
with contextlib.suppress(Exception):
    from jaxlib import xla_client
    xla_client.CompileOptions()
"""
"""A program that fails if XLA doesn't know a flag in XLA_FLAGS: XLA ends its process then."""
FOLDER, ENABLED, SECONDS, DEVICES, LOCATIONS = (
    "JAX_COMPILATION_CACHE_DIR", "JAX_ENABLE_COMPILATION_CACHE", "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS",
    "JAX_NUM_CPU_DEVICES", "JAX_TRACEBACK_IN_LOCATIONS_LIMIT",
)  # fmt: skip
"""Environment variables of JAX that are set here, unless the user has set them."""


class MachineError(ValueError):
    """JAX can't start. The message says why, and which environment variables to look at, in one line."""


def prepare_machine() -> set[str]:
    """Set environment variables for JAX and Matplotlib; return the names of those that the user had not set."""
    before = set(os.environ)
    os.environ["MPLBACKEND"] = "agg"  # figures go into files
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # without a home it says where it caches fonts
    warnings.filterwarnings("ignore", "Error (reading|writing) persistent compilation cache")  # said once, here:
    _keep_compiled_code()
    if "host_platform_device_count" not in os.environ.get("XLA_FLAGS", ""):
        os.environ.setdefault(DEVICES, str(cores()))
    os.environ.setdefault(LOCATIONS, "0")  # only profilers read the source line of each operation; tracing is quicker
    return set(os.environ) - before


def for_workers() -> tuple[tuple[str, str], ...]:
    """Return environment variables for the JAX of a worker, on any machine: a core each, and what the user has set.

    What `prepare_machine` chooses for a machine is left out, so that it chooses for the worker's.
    """
    chosen = {(DEVICES, str(cores()))}
    with suppress(RuntimeError):
        chosen.add((FOLDER, str(_cache_folder())))
    given = {pair for pair in os.environ.items() if pair[0].startswith(("JAX_", "XLA_"))} - chosen
    return tuple(sorted({"JAX_PLATFORMS": "cpu", DEVICES: "1", **dict(given)}.items()))


def start_jax(set_here: set[str], group: Group | None = None) -> None:
    """Start JAX, and join the group of processes if there is one.

    ``set_here``: environment variables that the user did not set. Raises MachineError if it can't start, and
    PeerLostError if another process of the group ended meanwhile.
    """
    if "jax" in sys.modules:
        if group is not None:
            raise MachineError("JAX has started already, and can't join other processes; use the command line")
        return
    if group is not None:
        os.environ[DEVICES] = str(group.devices)
    threading.Thread(target=commit, daemon=True).start()  # the one that results will name; git answers meanwhile
    with explaining_lost_peers() if group is not None else nullcontext(), _explained(set_here):
        with _flags_are_read():
            import jax
        if group is not None:
            join(group)
        jax.devices()
        if group is not None:
            take_cores(group)


def try_jax(set_here: set[str]) -> None:
    """Start JAX in another process, so that this one holds no accelerator. Raises MachineError as `start_jax` does."""
    with _explained(set_here), _begin(START) as trying:
        _end(trying)


@contextmanager
def _flags_are_read() -> Iterator[None]:
    """Let XLA read its flags in another process meanwhile. Raises RuntimeError at the end if it lacks one of them."""
    if not os.environ.get("XLA_FLAGS"):
        yield
        return
    with _begin(READ_FLAGS) as reading:
        yield
        _end(reading)


@contextmanager
def _explained(set_here: set[str]) -> Iterator[None]:
    """Turn an error of JAX's start into a MachineError. There are many kinds: of values, backends and libraries."""
    try:
        yield
    except Exception as error:
        names = [name for name in os.environ if name.startswith(("JAX_", "XLA_")) and name not in set_here]
        names = [name for name in names if name.lower() in str(error).lower()] or names
        advice = f"correct or unset {', '.join(names)}" if names else "check its installation"
        if OWN_ADDRESS in str(error):
            advice = f"its processes need an address for this machine's name, {platform.node()}, such as in /etc/hosts"
        raise MachineError(f"JAX can't start ({error}); {advice}") from error


def _begin(program: str) -> subprocess.Popen[str]:
    command, nothing = [sys.executable, "-c", program], subprocess.DEVNULL
    return subprocess.Popen(command, stdin=nothing, stdout=nothing, stderr=subprocess.PIPE, text=True)


def _end(process: subprocess.Popen[str]) -> None:
    """Wait for the process. Raise RuntimeError with its fatal line if it fails."""
    _, said = process.communicate()
    if process.returncode:
        lines = said.strip().splitlines() or [f"exit code {process.returncode}"]
        fatal = (line.partition("] ")[2] for line in lines if line.startswith("F"))  # F1122 10:00:00 file.cc:7] what
        raise RuntimeError(next(fatal, lines[-1].partition("Error: ")[2] or lines[-1]))


def _keep_compiled_code() -> None:
    """Let JAX store compiled code in the user's cache folder, unless JAX's own variables say otherwise.

    Where nothing can be written, it says so, and everything is compiled anew each time.
    """
    given = os.environ.get(FOLDER)
    if ENABLED in os.environ or given == "" or "://" in (given or ""):
        return
    try:
        folder = Path(given) if given else _cache_folder()
        check_writable(folder)
    except (OSError, RuntimeError, RunError) as error:  # RuntimeError: the user has no home
        advice = "set XDG_CACHE_HOME to one that can be written"
        print(f"jaxwalk: compiled code isn't kept, for want of a folder ({error}); {advice}", file=sys.stderr)
        os.environ[ENABLED] = "false"
        return
    os.environ[FOLDER] = str(folder)
    os.environ.setdefault(SECONDS, "0")


def _cache_folder() -> Path:
    """Return the user's cache folder on this platform. Raise RuntimeError if the user has no home."""
    given = os.environ.get("XDG_CACHE_HOME")
    if given:
        return Path(given) / "jaxwalk"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "jaxwalk" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "jaxwalk"
    return Path.home() / ".cache" / "jaxwalk"
