"""The rate shown is that since the plan was made or changed."""

import io
import re

from rich.console import Console

from jaxwalk.experiments import progress
from jaxwalk.experiments.progress import TrainingProgress


def test_a_new_plan_counts_from_there(monkeypatch):
    clock, out = [0.0], io.StringIO()
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    shown = TrainingProgress(Console(file=out, width=200), "training", done=0, planned=100, steps_per_update=1000)
    for second in range(1, 31):
        clock[0] = float(second)
        shown.show(second, {})
    shown.restart(50)
    clock[0] = 46.0
    shown.show(46, {})
    rates = [float(rate) for rate in re.findall(r"([\d.]+) k steps/s", out.getvalue())]
    assert len(rates) >= 3
    assert set(rates) == {1.0}
