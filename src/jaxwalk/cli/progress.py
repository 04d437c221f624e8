"""The progress bar of commands."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress

from jaxwalk.experiments.evaluating import Tell

T = TypeVar("T")


def with_progress(what: str, work: Callable[[Tell], T]) -> T:
    """Return the result of some work, with a progress bar meanwhile; ``what`` it begins with."""
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=None)

        def tell(what: str, done: int, total: int) -> None:
            bar.update(task, description=escape(what), completed=done, total=total)

        return work(tell)
