"""The rate shown is that since the second update began, or the second one after the plan was changed."""

import io
import math
import re
from types import SimpleNamespace

import pytest
from rich.console import Console

from jaxwalk.runs import progress, session, training
from jaxwalk.runs.folder import NoLog
from jaxwalk.runs.progress import Display, Pace, TrainingProgress
from jaxwalk.runs.session import Routine, Session
from jaxwalk.runs.stop import Stop
from jaxwalk.runs.training import _loop


def test_a_new_plan_counts_from_there(monkeypatch):
    clock, out = [0.0], io.StringIO()
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    shown = TrainingProgress(Display(Console(file=out, width=200)), Pace(0, 100, 1000))
    for second in range(1, 31):
        clock[0] = float(second)
        shown.begin(second)
        shown.show(second, {})
    shown.restart(40)
    shown.begin(31)
    shown.restart(50)
    for second, updates in ((40, 44), (42, 45), (50, 49)):
        clock[0] = float(second)
        shown.begin(updates)
    shown.show(50, {})
    rates = [float(rate) for rate in re.findall(r"([\d.]+) k steps/s", out.getvalue())]
    assert "40 updates planned, not 100, to end in time" in out.getvalue()
    assert "50 updates planned, not 40, as there is time for them" in out.getvalue()
    assert rates == [1.0, 0.5]


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
    for second, updates in ((0.0, 10), (60.0, 11)):
        clock[0] = second
        pace.begin(updates)
        assert (pace.rate, pace.left) == (None, None)
    clock[0] = 64.0
    pace.begin(13)
    pace.made = 13
    assert (pace.rate, pace.left) == (500.0, 74.0)


def replanned(session, learner, updates):
    session.progress.restart(updates)
    return learner


@pytest.fixture
def loop(monkeypatch):
    """Makes updates of 1000 steps that keep a CPU busy for ``seconds(made, clock)``; gives what the terminal says."""

    def run(updates, seconds, limit=math.inf):
        clock, out = [0.0], io.StringIO()

        def make(_turns, _config, learner, made):
            clock[0] += seconds(made, clock[0])
            return learner, {"finite": 1.0}

        monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
        monkeypatch.setattr(session, "update_in_turns", make)
        monkeypatch.setattr(session, "on_devices", lambda *_: (None,))
        monkeypatch.setattr(Session, "save", lambda *_: None)
        monkeypatch.setattr(training, "replan", replanned)
        experiment = SimpleNamespace(train=SimpleNamespace(roles=()), steps_per_update=1000)
        shown = TrainingProgress(Display(Console(file=out, width=200)), Pace(0, updates, 1000))
        folder, routine = SimpleNamespace(experiment=experiment), Routine(math.inf)
        fresh = Session(folder, None, NoLog(), shown, Stop(), routine=routine, begun=0.0, saved=0.0)
        _loop(fresh, SimpleNamespace(updates=0, planned=updates), limit)
        return out.getvalue()

    return run


@pytest.mark.parametrize(("updates", "rates"), [(2, []), (3, ["0.2"]), (9, ["0.2", "0.2", "0.2"])])
def test_few_updates_are_not_told_as_too_fast(updates, rates, loop):
    """60 s of compiling come before the first."""
    said = loop(updates, lambda made, _: 5.0 if made else 65.0)
    assert re.findall(r"([\d.]+) k steps/s", said) == rates


def test_a_plan_follows_the_machine(loop):
    """100 updates in 100 s; for half a minute other work takes half of the machine: 85 are possible."""
    said = loop(100, lambda _, now: 2.0 if now < 30 else 1.0, 100.0)
    plans = [int(number) for number in re.findall(r"(\d+) updates planned", said)]
    assert plans[0] < 70 < 80 < plans[-1] <= 86
    assert f"update {plans[-1]} of {plans[-1]}" in said


def test_a_change_of_the_shortest_plan_is_told_too(loop):
    assert "2 updates planned, not 5, to end in time" in loop(5, lambda *_: 2.0, 5.0)
