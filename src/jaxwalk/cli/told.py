"""What a long command is doing: a bar in a terminal, else a line from time to time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, TaskID

from jaxwalk.runs.progress import PLAIN_EVERY

T = TypeVar("T")
Tell = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done, and the total; 0 if that is unknown."""


def told(what: str, work: Callable[[Tell], T]) -> T:
    """Do some work, show its progress on standard error meanwhile, and return its result.

    Args:
        what: the first stage of the work, in words; shown until the work itself says what it does.
        work: is called with a function that shows progress, a bar in a terminal and lines elsewhere.

    Raises:
        Whatever the work raises.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        return work(Lines(lambda line: console.print(line, soft_wrap=True, markup=False), what))
    with Progress(console=console, transient=True) as bar:
        return work(Bar(bar, what))


class Bar:
    """A bar for each stage of the work."""

    def __init__(self, bar: Progress, what: str) -> None:
        self._bar, self._stage = bar, _stage(what, 0)
        self._task: TaskID = bar.add_task(escape(what), total=None)

    def __call__(self, what: str, done: int, total: int) -> None:
        """Show how much is done. A new stage has a bar of its own, as a bar never forgets its total and its pace."""
        if _stage(what, total) != self._stage:
            self._stage = _stage(what, total)
            self._bar.remove_task(self._task)
            self._task = self._bar.add_task(escape(what), total=total or None)
        self._bar.update(self._task, description=escape(what), completed=done)


class Lines:
    """A line for each stage of the work, and others of the same stage from time to time."""

    def __init__(self, say: Callable[[str], None], what: str) -> None:
        self._say, self._stage, self._said = say, _stage(what, 0), time.monotonic()
        say(what)

    def __call__(self, what: str, done: int, total: int) -> None:
        """Print how much is done, if that is new."""
        stage, now = _stage(what, total), time.monotonic()
        if stage == self._stage and now - self._said < PLAIN_EVERY:
            return
        self._stage, self._said = stage, now
        of = f" of {total:,}" if total else ""
        self._say(f"{what}: {done:,}{of}" if done or total else what)


def _stage(what: str, total: int) -> tuple[str, int]:
    """Return what stays the same during a stage: the words before a colon, behind which are numbers, and the total."""
    return what.partition(":")[0], total
