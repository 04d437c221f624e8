"""What tests spend on tracing and compiling, and how large their processes grow.

Nearly all of the time of these tests goes into making programs, so every run ends with a line about them;
`--compile-report` also lists the files and tests that cost most.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import gc
import resource
import sys
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, astuple, dataclass
from pathlib import Path

import jax
import jax.monitoring
import pytest

_DURATIONS = {
    "/jax/core/compile/jaxpr_trace_duration": "trace",
    "/jax/core/compile/jaxpr_to_mlir_module_duration": "lower",
    "/jax/core/compile/backend_compile_duration": "compile",
}
_CACHE_HIT = "/jax/compilation_cache/cache_hits"
_PROPERTY = "compiling"


@dataclass
class Cost:
    """What one or more tests cost; times in seconds."""

    trace: float = 0.0
    lower: float = 0.0
    compile: float = 0.0
    """Compiling, or reading what an earlier run compiled."""
    programs: int = 0
    """Programs compiled or read from the cache."""
    hits: int = 0
    """How many of these were read from the cache."""
    cpu: float = 0.0
    """Processor time, of all threads of this process."""
    wall: float = 0.0
    grown: float = 0.0
    """What the process grew by, in MB."""
    size: float = 0.0
    """Size of the process at the end of the test, in MB."""
    peak: float = 0.0
    """Largest size of the process until then, in MB."""

    def add(self, other: Cost) -> None:
        """Add another cost; of sizes, keep the larger one."""
        for name, value in asdict(other).items():
            mine = getattr(self, name)
            setattr(self, name, max(mine, value) if name in ("size", "peak") else mine + value)


class Recorder:
    """Records the cost of each test where it runs, and collects the costs where the run is reported."""

    def __init__(self, worst: int) -> None:
        self.worst = worst
        self.tests: dict[str, Cost] = defaultdict(Cost)
        self.workers: dict[str, float] = defaultdict(float)
        self.current = Cost()
        self.cpu, self.wall, self.size = time.process_time(), time.perf_counter(), memory()
        jax.monitoring.register_event_duration_secs_listener(self._took)
        jax.monitoring.register_event_listener(self._happened)

    def _took(self, event: str, seconds: float, **_: str | int) -> None:
        if name := _DURATIONS.get(event):
            setattr(self.current, name, getattr(self.current, name) + seconds)
            self.current.programs += name == "compile"

    def _happened(self, event: str, **_: str | int) -> None:
        self.current.hits += event == _CACHE_HIT

    def _since_last(self) -> Cost:
        cost, self.current = self.current, Cost()
        cpu, wall = time.process_time(), time.perf_counter()
        cost.cpu, cost.wall = cpu - self.cpu, wall - self.wall
        cost.size, cost.peak = memory(), peak_memory()
        cost.grown = cost.size - self.size
        self.cpu, self.wall, self.size = cpu, wall, cost.size
        return cost

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item, call: pytest.CallInfo[None]):
        report = yield
        report.user_properties = [(_PROPERTY, astuple(self._since_last()))]  # also sent to the main process by xdist
        return report

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        for name, values in report.user_properties:
            if name == _PROPERTY:
                cost = Cost(*values)
                self.tests[report.nodeid].add(cost)
                worker = getattr(report, "worker_id", "main")
                self.workers[worker] = max(self.workers[worker], cost.peak)

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        if not self.tests:
            return
        total = _sum(self.tests.values())
        terminalreporter.write_line(
            f"programs: {total.programs}, of them {total.hits} read from the cache; "
            f"traced {total.trace:.0f} s, lowered {total.lower:.0f} s, compiled or read {total.compile:.0f} s; "
            f"processor {total.cpu:.0f} s; largest process {max(self.workers.values()):.0f} MB"
        )
        if self.worst:
            files: dict[str, Cost] = defaultdict(Cost)
            for test, cost in self.tests.items():
                files[test.partition("::")[0]].add(cost)
            _table(terminalreporter, "files", files, self.worst)
            _table(terminalreporter, "tests", self.tests, self.worst)


@contextmanager
def counted_programs() -> Iterator[list[float]]:
    """Collect how long each program that is compiled, or read from the cache, takes [s]."""
    found: list[float] = []

    def took(event: str, seconds: float, **_: str | int) -> None:
        if _DURATIONS.get(event) == "compile":
            found.append(seconds)

    jax.monitoring.register_event_duration_secs_listener(took)
    try:
        yield found
    finally:
        jax.monitoring.unregister_event_duration_listener(took)


ARENAS, _M_ARENA_MAX = 2, -8
"""Threads share so many heaps (of glibc's), so that one that compiles takes memory that another one has freed."""


class Relief:
    """Keeps a process small: gives freed memory back, and forgets compiled programs when they take too much.

    Rather at the end of a file than within it: the next file needs fewer of the programs, and the file's own fixtures
    are gone.
    """

    TRIM = 75
    """Growth after which freed memory is given back, in MB."""
    FILE_ENDS, WITHIN_FILE = (900, 120), (1050, 250)
    """Size above which programs are forgotten, in MB, if the process has grown by that much since it last forgot them
    at the end of a file, or (within one) since it last forgot any. What stays then are libraries and fixtures."""

    def __init__(self) -> None:
        self.trimmed, self.forgot, self.file_ended = memory(), 0.0, 0.0
        name = ctypes.util.find_library("c") if sys.platform == "linux" else None
        library = ctypes.CDLL(name) if name else None
        self.trim = getattr(library, "malloc_trim", None)
        if library is not None and hasattr(library, "mallopt"):
            library.mallopt(_M_ARENA_MAX, ARENAS)
        jax.monitoring.register_event_duration_secs_listener(self._took)

    def _took(self, event: str, seconds: float, **_: str | int) -> None:
        if _DURATIONS.get(event) == "compile":
            self._shrink()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None):
        done = yield
        self._shrink()
        if nextitem is None or nextitem.path != item.path:
            if self._grew(self.file_ended, *self.FILE_ENDS):
                self._forget()
                self.file_ended = self.forgot
        elif self._grew(self.forgot, *self.WITHIN_FILE):
            self._forget()
        return done

    def pytest_collection_finish(self) -> None:
        _settle()

    def _grew(self, last: float, size: float, growth: float) -> bool:
        if memory() > max(size, last + growth):
            self._give_back()
        return memory() > max(size, last + growth)

    def _forget(self) -> None:
        FORGOTTEN.append(memory())
        jax.clear_caches()
        _settle()
        self._give_back()
        self.forgot = self.trimmed

    def _shrink(self) -> None:
        self.trimmed = min(self.trimmed, memory())
        if memory() > self.trimmed + self.TRIM:
            self._give_back()

    def _give_back(self) -> None:
        if self.trim is not None:
            self.trim(0)
        self.trimmed = memory()


def _settle() -> None:
    """Collect garbage. What stays (modules, types, fixtures) is never looked at again: that took seconds each time."""
    gc.collect()
    gc.freeze()


FORGOTTEN: list[float] = []
"""The sizes at which this process forgot its programs: whatever was traced before is traced again."""


def peak_memory() -> float:
    """Return the largest size that this process ever had, in MB."""
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size * (1 if sys.platform == "darwin" else 1024) / 1e6


def memory() -> float:
    """Return the size of this process now, in MB; on systems without /proc its largest size."""
    about = Path("/proc/self/statm")
    return int(about.read_text().split()[1]) * resource.getpagesize() / 1e6 if about.exists() else peak_memory()


def _sum(costs: Iterable[Cost]) -> Cost:
    total = Cost()
    for cost in costs:
        total.add(cost)
    return total


def _table(out: pytest.TerminalReporter, what: str, costs: dict[str, Cost], count: int) -> None:
    out.section(f"{what} that cost most processor time (s)")
    out.write_line("  cpu  wall trace lower  comp  programs  hits  grown   MB  peak")
    for name, x in sorted(costs.items(), key=lambda item: -item[1].cpu)[:count]:
        out.write_line(
            f"{x.cpu:5.1f} {x.wall:5.1f} {x.trace:5.1f} {x.lower:5.1f} {x.compile:5.1f} {x.programs:9d} {x.hits:5d} "
            f"{x.grown:6.0f} {x.size:5.0f} {x.peak:5.0f}  {name}"
        )
