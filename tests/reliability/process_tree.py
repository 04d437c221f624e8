"""What a process and all below it take: the most memory of each, processor time, and which of them play. Linux only."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

TICKS = os.sysconf("SC_CLK_TCK")
PROC = Path("/proc")


@dataclass
class Tree:
    """A process and its descendants, those that have ended included."""

    process: subprocess.Popen[bytes]
    names: dict[int, str] = field(default_factory=dict)
    peaks: dict[int, float] = field(default_factory=dict)
    """Most memory of each process [MB]."""
    seconds: dict[int, float] = field(default_factory=dict)
    """Processor time of each process [s]."""

    def look(self) -> list[int]:
        """Look at all processes that are there now, and return their numbers."""
        parents = {int(path.name): found for path in PROC.glob("[0-9]*") if (found := _parent(path)) is not None}
        there, last = [], [self.process.pid]
        while last:
            there += last
            last = [pid for pid, parent in parents.items() if parent in last]
        return [pid for pid in there if self._measure(pid)]

    def _measure(self, pid: int) -> bool:
        try:
            status = (PROC / str(pid) / "status").read_text()
            times = (PROC / str(pid) / "stat").read_text().rpartition(")")[2].split()
            words = (PROC / str(pid) / "cmdline").read_bytes().replace(b"\0", b" ").decode()
        except OSError:
            return False
        peak = next((line for line in status.splitlines() if line.startswith("VmHWM")), None)
        if peak is None:  # it has ended, and nobody has asked how
            return False
        self.names[pid] = words
        self.peaks[pid] = int(peak.split()[1]) / 1024
        self.seconds[pid] = (int(times[11]) + int(times[12])) / TICKS
        return True


def _parent(path: Path) -> int | None:
    try:
        return int((path / "stat").read_text().rpartition(")")[2].split()[1])
    except OSError:
        return None


def watched(command: Sequence[str], at: Callable[[Tree, list[int]], None] | None = None) -> tuple[Tree, int]:
    """Run a command, and return what it took and its exit code; ``at`` is called twice a second, with all processes."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        tree = Tree(process)
        while process.poll() is None:
            there = tree.look()
            if at is not None:
                at(tree, there)
            time.sleep(0.5)
        return tree, process.returncode
