"""The rate shown is that since the first update, or since the plan was changed."""

import io
import re

from rich.console import Console

from jaxwalk.runs import progress
from jaxwalk.runs.progress import Display, Pace, TrainingProgress


def test_a_new_plan_counts_from_there(monkeypatch):
    clock, out = [0.0], io.StringIO()
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    shown = TrainingProgress(Display(Console(file=out, width=200)), Pace(0, 100, 1000))
    for second in range(1, 31):
        clock[0] = float(second)
        shown.show(second, {})
    shown.restart(50)
    clock[0] = 46.0
    shown.show(46, {})
    rates = [float(rate) for rate in re.findall(r"([\d.]+) k steps/s", out.getvalue())]
    assert "50 updates planned, not 100, to end in time" in out.getvalue()
    assert len(rates) == 2
    assert set(rates) == {1.0}


def test_a_terminal_shows_a_bar_that_leaves_when_it_is_done():
    out = io.StringIO()
    console = Console(file=out, width=100, force_terminal=True)
    with TrainingProgress(Display(console), Pace(0, 2, 1000)) as shown:
        assert "compiling" in out.getvalue()
        shown.show(1, {"goal_rate": 0.5, "collision_rate": 0.25})
        shown.show(2, {"goal_rate": 0.5, "collision_rate": 0.25})
    assert "goals 50 %, collisions 25 %" in out.getvalue()
    assert "update 2 of 2" not in out.getvalue()


def test_what_the_first_update_compiles_counts_for_nothing(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    pace = Pace(10, 50, 1000)
    assert (pace.rate, pace.left) == (None, None)
    for second, updates in ((60.0, 11), (64.0, 13)):
        clock[0] = second
        pace.tell(updates)
    assert (pace.rate, pace.left) == (500.0, 74.0)
