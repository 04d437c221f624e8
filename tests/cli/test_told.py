"""Progress of long commands, in a terminal and without one."""

from __future__ import annotations

import io

import pytest
from rich.console import Console
from rich.progress import Progress

from jaxwalk.cli.told import Bar, Lines
from jaxwalk.runs.progress import PLAIN_EVERY


def test_without_a_terminal_each_stage_has_a_line_and_a_long_one_several(monkeypatch):
    now, lines = [0.0], []
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    tell = Lines(lines.append, "searching")
    tell("searching: 0 kinds", 0, 2000)
    tell("searching: 3 kinds", 1000, 2000)  # at once
    now[0] = PLAIN_EVERY
    tell("searching: 5 kinds", 1500, 2000)
    tell("minimising", 0, 0)
    now[0] = 2 * PLAIN_EVERY
    tell("minimising", 640, 0)
    tell("writing", 0, 0)
    assert lines == [
        "searching", "searching: 0 kinds: 0 of 2,000", "searching: 5 kinds: 1,500 of 2,000", "minimising",
        "minimising: 640", "writing",
    ]  # fmt: skip


@pytest.mark.parametrize("total", [0, 50])
def test_a_new_stage_forgets_the_total_of_the_last_one(total):
    with Progress(console=Console(file=io.StringIO()), transient=True) as bar:
        tell = Bar(bar, "[b]")
        tell("searching: 1 kind", 10, 10)
        tell("searching: 2 kinds", 10, 10)
        tell("writing [it]", 0, total)
        (task,) = bar.tasks
        assert (task.description, task.completed, task.total) == (r"writing \[it]", 0, total or None)
