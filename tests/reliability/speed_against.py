"""Compare the speed of this checkout with that of another one, such as of an earlier commit.

    .venv/bin/python tests/reliability/speed_against.py OLD_CHECKOUT                       # everything: half an hour
    .venv/bin/python tests/reliability/speed_against.py OLD_CHECKOUT simulator --turns 5   # some parts, fewer turns

OLD_CHECKOUT has its own environment in .venv, as `make install` makes it. The parts:

- simulator: steps of 1,024 environments with every view of 0.1 and every reward term;
- evaluation: 1,024 scenarios, played and measured;
- fast, paper: updates of 0.1's two recipes at their own sizes;
- cold, warm: seconds from `jaxwalk train --recipe paper` (512 x 16 steps) until its first update is on disk, with an
  empty cache of compiled code and with one that the same command has filled.

Old and new take turns of at least a second (at least one update, one start), first the one and then the other, so that
a noisy machine treats them alike. A ratio is new speed / old speed of one turn: above 1, this checkout is faster. The
bound is a one-sided 95 % confidence bound of the median ratio, an order statistic: no distribution is assumed. Nothing
else should run meanwhile.
"""

from __future__ import annotations

import argparse
import math
import os
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

HERE = Path(__file__).resolve().parents[2]
WORKER = Path(__file__).with_name("speed_worker.py")
STEADY, STARTS = ("simulator", "evaluation", "fast", "paper"), ("cold", "warm")
UNITS = {"evaluation": "scen./s", "cold": "s", "warm": "s"}
SAME_SINCE_0_1 = ("--recipe", "paper", "--environments", "512", "--steps", "16", "--updates", "1")
"""The training of which the first update is timed: the same work in every checkout, and little of it."""
CONFIDENCE = 0.95
CACHE_VARIABLES = ("JAX_COMPILATION_CACHE_DIR", "JAX_ENABLE_COMPILATION_CACHE")

Turn = Callable[[], float]
"""Run a program for one turn and return its speed: something per second."""


def lower_bound(values: list[float], confidence: float = CONFIDENCE) -> float | None:
    """The one-sided lower confidence bound of the median of the values' distribution; None if there are too few.

    The k-th smallest of n values lies above the median with probability P(Binomial(n, 1/2) < k).
    """
    count, below, bound = len(values), 0.0, None
    for k, value in enumerate(sorted(values)):
        below += math.comb(count, k) / 2**count
        if below > 1 - confidence:
            break
        bound = value
    return bound


def take_turns(old: Turn, new: Turn, turns: int) -> list[tuple[float, float]]:
    """Speeds of old and new of each turn. Who is first alternates."""
    speeds = []
    for turn in range(turns):
        if turn % 2:
            after = new()
            speeds.append((old(), after))
        else:
            before = old()
            speeds.append((before, new()))
    return speeds


def python_of(checkout: Path) -> Path:
    """The Python of the checkout's environment."""
    python = checkout / ".venv" / "bin" / "python"
    if not python.exists():
        raise SystemExit(f"{python} is missing: run `make install` in {checkout}")
    return python


def environment_of(checkout: Path) -> dict[str, str]:
    """Variables with which a process imports jaxwalk from the checkout and uses every core as a device."""
    cores = str(os.environ.get("JAX_NUM_CPU_DEVICES", os.cpu_count() or 1))
    return {**os.environ, "PYTHONPATH": str(checkout / "src"), "JAX_NUM_CPU_DEVICES": cores}


@contextmanager
def steady(checkout: Path, part: str) -> Iterator[Turn]:
    """Start a worker, which compiles and warms up, and give its turns."""
    command = [str(python_of(checkout)), str(WORKER), part]
    worker = subprocess.Popen(
        command, env=environment_of(checkout), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert worker.stdin and worker.stdout
    source, sink = worker.stdout, worker.stdin

    def said() -> str:
        line = source.readline().strip()
        if not line:
            raise SystemExit(f"the worker of {checkout} ended; see above")
        return line

    def turn() -> float:
        sink.write("go\n")
        sink.flush()
        return float(said())

    try:
        if said() != "ready":
            raise SystemExit(f"the worker of {checkout} is not one of speed_worker.py")
        yield turn
    finally:
        worker.kill()
        worker.wait()


@contextmanager
def starts(checkout: Path, part: str) -> Iterator[Turn]:
    """First updates of `jaxwalk train` in fresh processes: 1 / seconds."""
    with tempfile.TemporaryDirectory(prefix="jaxwalk-speed-") as scratch:
        folder = Path(scratch)
        if part == "warm":
            first_update(checkout, folder / "filling", folder / "cache")

        def turn() -> float:
            with tempfile.TemporaryDirectory(dir=folder) as own:
                cache = folder / "cache" if part == "warm" else Path(own) / "cache"
                return 1 / first_update(checkout, Path(own) / "run", cache)

        yield turn


def first_update(checkout: Path, run: Path, cache: Path) -> float:
    """Seconds from the command until the first update's metrics are on disk; then let it end."""
    command = [
        str(python_of(checkout)),
        "-m",
        "jaxwalk",
        "train",
        *SAME_SINCE_0_1,
        "--run",
        str(run),
    ]
    variables = {x: y for x, y in environment_of(checkout).items() if x not in CACHE_VARIABLES}
    metrics, begun, learned = run / "metrics.jsonl", time.perf_counter(), None
    with subprocess.Popen(command, env={**variables, "XDG_CACHE_HOME": str(cache)}, stderr=subprocess.PIPE) as process:
        while process.poll() is None:
            if learned is None and metrics.is_file() and metrics.stat().st_size:
                learned = time.perf_counter() - begun
            time.sleep(0.005)
        if process.returncode or learned is None:
            said = process.stderr.read().decode() if process.stderr else ""
            raise SystemExit(f"{' '.join(command)}: exit code {process.returncode}: {said.strip()[-500:]}")
    return learned


def line(part: str, speeds: list[tuple[float, float]]) -> str:
    """A row of the table."""
    ratios = [new / old for old, new in speeds]
    old, new = (statistics.median(x) for x in zip(*speeds, strict=True))
    bound = lower_bound(ratios)
    low = "   -" if bound is None else f"{bound:.3f}"
    unit = UNITS.get(part, "steps/s")
    before, after = (f"{1 / x:.2f}" if part in STARTS else f"{x:,.0f}" for x in (old, new))
    spread = f"{min(ratios):.3f} to {max(ratios):.3f}, {len(ratios)} turns"
    return f"{part:<10}{before:>12}{after:>12} {unit:<8}{statistics.median(ratios):>7.3f}{low:>8}   {spread}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path, metavar="OLD_CHECKOUT")
    parser.add_argument("parts", nargs="*", default=[], help=", ".join((*STEADY, *STARTS)))
    parser.add_argument("--turns", type=int, default=20)
    parser.add_argument("--starts", type=int, default=8, help="turns of cold and warm")
    options = parser.parse_args()
    unknown = set(options.parts) - {*STEADY, *STARTS}
    if unknown:
        parser.error(f"no such part: {', '.join(sorted(unknown))}")
    print(f"{'':<10}{'old':>12}{'new':>12} {'':<8}{'ratio':>7}{'bound':>8}   smallest to largest", flush=True)
    for part in options.parts or (*STEADY, *STARTS):
        program, turns = (starts, options.starts) if part in STARTS else (steady, options.turns)
        with ExitStack() as stack:
            old, new = (stack.enter_context(program(x, part)) for x in (options.old.resolve(), HERE))
            print(line(part, take_turns(old, new, turns)), flush=True)


if __name__ == "__main__":
    main()
