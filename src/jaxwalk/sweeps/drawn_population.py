"""Pictures of a population: whose checkpoint each member went on from, and how fields moved over the generations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from jaxwalk.sweeps.drawn_trials import LEFT, TOP, WIDE, DrawnAxis, DrawnLine, axis_of, height_of, said_of, share_of

if TYPE_CHECKING:
    from jaxwalk.sweeps.sweep_results import SweepResults, TrialResult

ROW = 24
"""Distance of two members in the picture of lineage [px]."""


@dataclass(frozen=True)
class DrawnDot:
    """A member at the end of a generation."""

    x: float
    y: float
    kind: str
    """best, other or ended early."""
    said: str
    """What a reader sees who points at it."""


@dataclass(frozen=True)
class DrawnLineage:
    """Members in rows, generations in columns: a line from each trial to that from whose end it went on."""

    lines: tuple[DrawnLine, ...]
    """Those of copies have the kind copy, or best if the best member descends from them."""
    dots: tuple[DrawnDot, ...]
    rows: tuple[tuple[float, str], ...]
    """Place [px] and name of each member."""
    columns: tuple[tuple[float, str], ...]
    """Place [px] and name of each generation."""
    tall: int
    """Height of the picture [px]."""


@dataclass(frozen=True)
class DrawnMoves:
    """A field's values over the generations."""

    axis: DrawnAxis
    lines: tuple[DrawnLine, ...]
    """The line of each trial, from the value of that from whose end it went on to its own."""
    dots: tuple[DrawnDot, ...]


def ancestry(results: SweepResults) -> list[int]:
    """Return the best trial and those from whose ends it came, newest first; [] while none is complete."""
    found = [results.best[0].number] if results.best else []
    while found and (parent := results.trials[found[-1]].parent) is not None:
        found.append(parent)
    return found


def place_of(results: SweepResults, trial: TrialResult) -> str:
    """Return where a member of a population went on, in words."""
    plan = results.plan.pbt
    if plan is None or trial.parent is None:
        return ""
    own = plan.member(trial.parent) == plan.member(trial.number)
    return f"its own, trial {trial.parent}" if own else f"copied from trial {trial.parent}"


def drawn_lineage(results: SweepResults) -> DrawnLineage | None:
    """Return the picture of whose checkpoint each member went on from; None without a population."""
    plan = results.plan.pbt
    if plan is None:
        return None
    best, dots, lines = set(ancestry(results)), [], []
    for trial in results.trials:
        x, y = _across(results, trial.number), TOP + ROW * (plan.member(trial.number) + 0.5)
        dots.append(DrawnDot(x, y, _kind(trial, best), said_of(trial)))
        if trial.parent is not None:
            row = plan.member(trial.parent)
            points = f"{_across(results, trial.parent)},{TOP + ROW * (row + 0.5)} {x},{y}"
            copied = "other" if row == plan.member(trial.number) else "copy"
            kind = "best" if trial.number in best else copied
            lines.append(DrawnLine(points, kind, f"trial {trial.number}: {place_of(results, trial)}"))
    return DrawnLineage(
        lines=tuple(sorted(lines, key=lambda line: line.kind == "best")),
        dots=tuple(dots),
        rows=tuple((TOP + ROW * (member + 0.5), str(member)) for member in range(plan.members)),
        columns=tuple((_across(results, k * plan.members), str(k)) for k in range(plan.generations)),
        tall=TOP + ROW * plan.members + 2 * TOP,
    )


def drawn_moves(results: SweepResults) -> list[DrawnMoves]:
    """Return a picture for each field; [] without a population."""
    return [_moves(results, name) for name in results.plan.fields] if results.plan.pbt else []


def _moves(results: SweepResults, name: str) -> DrawnMoves:
    """Return the picture of a field."""
    varied, best, lines, dots = results.plan.fields[name], set(ancestry(results)), [], []
    for trial in (trial for trial in results.trials if name in trial.values):
        x, y = _across(results, trial.number), height_of(share_of(varied, trial.values[name]))
        dots.append(DrawnDot(x, y, _kind(trial, best), said_of(trial)))
        if trial.parent is not None:
            before = height_of(share_of(varied, results.trials[trial.parent].values[name]))
            kind = "best" if trial.number in best else "other"
            lines.append(DrawnLine(f"{_across(results, trial.parent)},{before} {x},{y}", kind, said_of(trial)))
    lines.sort(key=lambda line: line.kind == "best")
    return DrawnMoves(axis_of(name, varied, LEFT), tuple(lines), tuple(dots))


def _across(results: SweepResults, number: int) -> float:
    """Return the place of a trial's generation [px], from the left."""
    plan = results.plan.pbt
    assert plan is not None
    return round(LEFT + (WIDE - LEFT) * (plan.generation(number) + 0.5) / plan.generations, 1)


def _kind(trial: TrialResult, best: set[int]) -> str:
    return "best" if trial.number in best else "other" if trial.state == "complete" else "early"
