"""The first minute: the time until the command line answers, and until a first training has made its first update.

This process uses no device, so that the commands it starts can have it.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from jaxwalk.bench.processes import BenchmarkError, tell

REPEATS = 5
"""Number of times that a short command is timed; the median counts."""
WARM_STARTS = 3
"""Number of times that a training is started with its code already compiled."""
CACHE_VARIABLES = ("JAX_COMPILATION_CACHE_DIR", "JAX_ENABLE_COMPILATION_CACHE")
"""Environment variables that would override the command's own cache of compiled code."""


def starts(*, recipe: str = "fast", options: tuple[str, ...] = ()) -> dict[str, float]:
    """Return the seconds of each start, by name. ``options``: those of `jaxwalk train`, besides the recipe's values."""
    found = {
        "import_s": _median([sys.executable, "-c", "import jaxwalk"]),
        "help_s": _median([sys.executable, "-m", "jaxwalk", "--help"]),
    }
    tell(f"import jaxwalk: {found['import_s']:.2f} s; jaxwalk --help: {found['help_s']:.2f} s")
    with tempfile.TemporaryDirectory(prefix="jaxwalk-bench-") as scratch:
        learned, ended = first_update(Path(scratch), "cold", recipe, options)
        found |= {"first_update_cold_s": learned, "train_command_cold_s": ended}
        warm = [first_update(Path(scratch), f"warm-{number}", recipe, options) for number in range(WARM_STARTS)]
        learned, ended = zip(*warm, strict=True)
        found |= {
            "first_update_warm_s": statistics.median(learned),
            "best_first_update_warm_s": min(learned),
            "train_command_warm_s": statistics.median(ended),
        }
    return found


def first_update(scratch: Path, name: str, recipe: str, options: tuple[str, ...]) -> tuple[float, float]:
    """Return the seconds from `jaxwalk train` until the first update's metrics are on disk, and until the command ends.

    The command's cache of compiled code is in ``scratch``, which is empty when it runs for the first time.
    """
    command = [sys.executable, "-m", "jaxwalk", "train", "--recipe", recipe, "--updates", "1"]
    command += ["--run", str(scratch / name), *options]
    environment = {name: value for name, value in os.environ.items() if name not in CACHE_VARIABLES}
    environment["XDG_CACHE_HOME"] = str(scratch / "cache")
    learned, ended = watch(command, scratch / name / "metrics.jsonl", scratch / f"{name}.txt", environment)
    tell(f"jaxwalk train --updates 1, {name}: first update after {learned:.1f} s, ended after {ended:.1f} s")
    return learned, ended


def watch(command: list[str], metrics: Path, said: Path, environment: dict[str, str]) -> tuple[float, float]:
    """Return the seconds until the command has written the metrics, and until it ends; its output goes into a file."""
    learned = None
    with said.open("wb") as out:
        begun = time.perf_counter()
        process = subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL, stdout=out, stderr=out)
        try:
            while process.poll() is None:
                if learned is None and metrics.is_file() and metrics.stat().st_size:
                    learned = time.perf_counter() - begun
                time.sleep(0.005)
        finally:
            process.kill()
            process.wait()
        ended = time.perf_counter() - begun
    if process.returncode:
        text = said.read_text(encoding="utf-8", errors="replace").strip()
        raise BenchmarkError(f"{' '.join(command[1:])}: exit code {process.returncode}: {text}")
    return ended if learned is None else learned, ended


def _median(command: list[str]) -> float:
    """Return the median seconds of a command, after a first run, which may still write compiled Python."""
    times = []
    for _ in range(1 + REPEATS):
        begun = time.perf_counter()
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        times.append(time.perf_counter() - begun)
        if done.returncode:
            raise BenchmarkError(f"{' '.join(command[1:])}: exit code {done.returncode}: {done.stderr.strip()[-500:]}")
    return statistics.median(times[1:])
