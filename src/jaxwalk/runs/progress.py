"""Progress of a training on the terminal: a live line if there is a terminal, else a line from time to time."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

PLAIN_EVERY = 15.0
"""Seconds between two lines if output isn't a terminal."""
MEMORY = 0.9
"""Weight of the earlier updates in the running means of rates."""


@dataclass(frozen=True)
class Display:
    """How the progress of a training is shown."""

    console: Console = field(default_factory=lambda: Console(stderr=True))
    name: str = "training"
    """Name of the training in the output."""
    watch: bool = False
    """Whether to write a progress page into the run folder. A page that already exists is always continued."""

    def say(self, line: str) -> None:
        """Print a line unchanged."""
        self.console.print(line, soft_wrap=True, markup=False)


@dataclass
class Pace:
    """How far a training is and how fast it goes.

    Updates are counted when they begin, as that is even: on a CPU, one is recorded only when the next one has been
    made, too, and the last two are recorded at once. The first doesn't count, as it may compile.
    """

    made: int
    """Updates made by all sessions."""
    planned: int
    steps_per_update: int
    _begun: tuple[float, int] | None = None
    """Time [s] at which the newest update began, and number of those before it."""
    _since: tuple[float, int] | None = None
    """The same of the second one that began."""

    def restart(self, planned: int) -> None:
        """Take a new plan, and restart the count."""
        self.planned, self._begun, self._since = planned, None, None

    @property
    def running(self) -> bool:
        """Whether an update has begun since the plan was made."""
        return self._begun is not None

    def begin(self, updates: int) -> None:
        """Record that an update begins after that many."""
        now = time.monotonic(), updates
        if self._since is None and self._begun is not None:
            self._since = now
        self._begun = now

    @property
    def _each(self) -> float | None:
        """Return the time of an update [s]; None before it is known."""
        if self._begun is None or self._since is None or self._begun[1] <= self._since[1]:
            return None
        return max(self._begun[0] - self._since[0], 1e-9) / (self._begun[1] - self._since[1])

    @property
    def rate(self) -> float | None:
        """Return the environment steps per second; None before it is known."""
        return None if self._each is None else self.steps_per_update / self._each

    @property
    def left(self) -> float | None:
        """Return the time to the last update [s]; None before it is known."""
        return None if self._each is None else (self.planned - self.made) * self._each


class TrainingProgress:
    """Shows updates, rate, time left, goal rate and collision rate. Use it in a ``with``."""

    def __init__(self, display: Display, pace: Pace) -> None:
        """Show the ``pace``, and keep it up to date."""
        self._display, self._pace = display, pace
        self._said = -PLAIN_EVERY
        self._means: dict[str, float] = {}
        columns = (
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            TaskProgressColumn(),
            TimeRemainingColumn(True),
        )
        self._bar = Progress(*columns, TextColumn("{task.fields[news]}"), console=display.console, transient=True)
        self._live = display.console.is_terminal
        self._task = self._bar.add_task(display.name, total=pace.planned, completed=pace.made, news="compiling")

    def __enter__(self) -> TrainingProgress:
        if self._live:
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live:
            self._bar.stop()

    def restart(self, planned: int) -> None:
        """Take a new plan, and restart the count of time and updates. Say so if the plan changes on the way."""
        before = self._pace.planned
        if self._pace.running and planned != before:
            why = "to end in time" if planned < before else "as there is time for them"
            self._display.say(f"{self._display.name}: {planned:,} updates planned, not {before:,}, {why}")
        self._pace.restart(planned)
        self._bar.reset(self._task, total=planned, completed=self._pace.made, news="")

    def begin(self, updates: int) -> None:
        """Record that an update begins after that many."""
        self._pace.begin(updates)

    def show(self, updates: int, metrics: Mapping[str, float]) -> None:
        """Show the number of updates made, and the metrics of the last one."""
        for name in ("goal_rate", "collision_rate"):
            if name in metrics and metrics.get("episodes", 1):
                last = self._means.get(name, metrics[name])
                self._means[name] = MEMORY * last + (1 - MEMORY) * metrics[name]
        self._pace.made = updates
        planned, rate, left = self._pace.planned, self._pace.rate, self._pace.left
        news = (f"{rate / 1000:,.1f} k steps/s, " if rate else "") + self._rates()
        self._bar.update(self._task, completed=updates, total=planned, news=news)
        now = time.monotonic()
        if not self._live and (now - self._said >= PLAIN_EVERY or updates >= planned):
            self._said = now
            soon = "" if left is None else f", {clock(left)} left"
            self._display.say(f"{self._display.name}: update {updates:,} of {planned:,}, {news}{soon}")

    def _rates(self) -> str:
        shown = {name: f"{100 * value:.0f} %" for name, value in self._means.items()}
        return f"goals {shown.get('goal_rate', '-')}, collisions {shown.get('collision_rate', '-')}"


def clock(seconds: float) -> str:
    """Return minutes and seconds, as in 3:07."""
    whole = round(seconds)
    return f"{whole // 60}:{whole % 60:02d}"
