"""The number of a trial by an evaluation: the trained car among people, on scenarios that no training has seen."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from difflib import get_close_matches
from typing import Any, get_type_hints

from jaxwalk.evaluation import evaluate
from jaxwalk.metrics import METRICS, Summary, summarise
from jaxwalk.metrics.statistics import Estimate, Rate
from jaxwalk.runs.contestant_names import check_name
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.runs.folder import Run
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.suites import SUITES, Where
from jaxwalk.sweeps.study_file import SweepFileError, SweepObjective, SweepPlan

INTERVALS = (Estimate, Rate)
"""Numbers with an interval: what counts is their value."""

EXAMPLES = ("outcomes.goal", "outcomes.moving.per_episode", "delay.mean")


def evaluated(run: Run, objective: SweepObjective) -> float | None:
    """Return the number of a trained car; None if it doesn't exist."""
    where = Where() if objective.suite is None else SUITES[objective.suite]
    street = world_of([str(run.path)], where)
    policies = {
        "driver": contestant(street, "driver", str(run.path)),
        "pedestrian": contestant(street, "pedestrian", objective.pedestrians),
    }
    rows = evaluate(street, policies, Drawn(street, seed=objective.seed, count=objective.episodes))
    return number_named(summarise(rows), objective.metric)


def number_named(summary: Summary, name: str) -> float | None:
    """Return a number of a summary by its name with dots; of one with an interval, its value."""
    metric, *names = name.split(".")
    found: Any = summary.numbers[metric]
    for each in names:
        found = getattr(found, each)
    return getattr(found, "value", found)


def check_objective(plan: SweepPlan) -> None:
    """Raise an error unless the objective of an evaluation is a number of its summary, and its people are known.

    Raises SweepFileError or ContestantError.
    """
    objective = plan.objective
    if objective.of == "training":
        return
    check_name("pedestrian", objective.pedestrians)
    known = [name for metric in METRICS for name in _numbers(metric.name, metric.numbers)]
    if objective.metric not in known:
        near = get_close_matches(objective.metric, known, 3, 0.4) or EXAMPLES
        raise SweepFileError(
            f"{plan.path}: objective.metric: an evaluation has no {objective.metric!r}; "
            f"it has {', '.join(near)} and others (docs: metrics)"
        )


def _numbers(name: str, kind: Any) -> list[str]:
    """Return the names of all numbers below a type of a summary."""
    if kind in (*INTERVALS, float, int):
        return [name]
    if not is_dataclass(kind):
        return []
    hints = get_type_hints(kind)
    return [found for each in fields(kind) for found in _numbers(f"{name}.{each.name}", hints[each.name])]
