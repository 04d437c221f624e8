"""Read learning curves from run folders."""

from __future__ import annotations

from jaxwalk.report import LearningCurve
from jaxwalk.runs.folder import METRICS, Run, RunError

NEEDED = ("steps", "episodes", "goal_rate", "collision_rate", "timeout_rate")
"""Metrics of each update from which a curve is drawn."""


def learning_curve(run: Run) -> LearningCurve:
    """Return the curve of a training. Raise RunError if it has no updates, or an update lacks a metric."""
    lines, file = run.metrics(), run.path / METRICS
    if not lines:
        raise RunError(f"{file}: has no update; restore it from a copy, or train again")
    for line in lines:
        lacking = [name for name in NEEDED if name not in line]
        if lacking:
            raise RunError(f"{file}: damaged (update {line['update']} has no {lacking[0]}); restore it from a copy")
    columns = {name: tuple(line[name] for line in lines) for name in NEEDED}
    return LearningCurve(seconds=lines[-1]["seconds"], **columns)
