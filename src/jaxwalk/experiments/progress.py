"""How training goes, on the terminal: a live line where there is one, else a line every so often."""

from __future__ import annotations

import time
from collections.abc import Mapping

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

PLAIN_EVERY = 15.0
"""Where output is no terminal, a line every so many seconds."""
MEMORY = 0.9
"""Share of the last value in the running means of rates."""


class TrainingProgress:
    """Shows updates, rate, time left, goal and collision rate. Use it in a ``with``."""

    def __init__(self, console: Console, name: str, *, done: int, planned: int, steps_per_update: int) -> None:
        """For updates ``done`` + 1 to ``planned``."""
        self._console, self._name = console, name
        self._begun, self._first, self._made, self._planned = time.monotonic(), done, done, planned
        self._steps_per_update = steps_per_update
        self._said = -PLAIN_EVERY
        self._means: dict[str, float] = {}
        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn(True))
        self._bar = Progress(*columns, TextColumn("{task.fields[news]}"), console=console, transient=True)
        self._live = console.is_terminal
        self._task = self._bar.add_task(name, total=planned, completed=done, news="compiling")

    def __enter__(self) -> TrainingProgress:
        if self._live:
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live:
            self._bar.stop()

    def restart(self, planned: int) -> None:
        """A new plan: count time and updates from now."""
        self._begun, self._planned, self._first = time.monotonic(), planned, self._made
        self._bar.reset(self._task, total=planned, completed=self._made, news="")

    def show(self, updates: int, metrics: Mapping[str, float]) -> None:
        """So many updates are made, and these were the last one's metrics."""
        for name in ("goal_rate", "collision_rate"):
            if name in metrics and metrics.get("episodes", 1):
                last = self._means.get(name, metrics[name])
                self._means[name] = MEMORY * last + (1 - MEMORY) * metrics[name]
        self._made = updates
        passed = max(time.monotonic() - self._begun, 1e-9)
        rate = (updates - self._first) * self._steps_per_update / passed
        news = f"{rate / 1000:,.1f} k steps/s, " + self._rates()
        self._bar.update(self._task, completed=updates, total=self._planned, news=news)
        now = time.monotonic()
        if not self._live and (now - self._said >= PLAIN_EVERY or updates >= self._planned):
            self._said = now
            left = (self._planned - updates) * passed / max(updates - self._first, 1)
            self._console.print(
                f"{self._name}: update {updates:,} of {self._planned:,}, {news}, {clock(left)} left", soft_wrap=True
            )

    def _rates(self) -> str:
        shown = {name: f"{100 * value:.0f} %" for name, value in self._means.items()}
        return f"goals {shown.get('goal_rate', '-')}, collisions {shown.get('collision_rate', '-')}"


def clock(seconds: float) -> str:
    """Minutes and seconds, as in 3:07."""
    whole = round(seconds)
    return f"{whole // 60}:{whole % 60:02d}"
