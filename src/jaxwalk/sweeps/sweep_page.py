"""The page of a sweep: the best trials, which field mattered, parallel coordinates and learning curves.

It is one static file without a script: pictures are SVG, made here from numbers.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jaxwalk.provenance import provenance
from jaxwalk.sweeps.trial_curves import curve_name
from jaxwalk.sweeps.varied import ListedValues, Varied
from jaxwalk.viewer.filled_page import filled_in

if TYPE_CHECKING:
    from jaxwalk.sweeps.sweep_results import SweepResults, TrialResult

SHOWN = 10
"""Number of trials in the table of the best."""
AXIS, TALL, WIDE = 150, 300, 760
"""Distance of two axes, height of a picture, width of the curves' picture [px]."""
LEFT, TOP, BOTTOM = 70, 16, 30
"""Margins [px]."""
BEST_SHARE = 4
"""One of this many trials, the best ones, is coloured."""


@dataclass(frozen=True)
class DrawnLine:
    """The line of a trial in a picture."""

    points: str
    """Its corners, as SVG has them."""
    kind: str
    """best, other or ended early."""
    said: str
    """What a reader sees who points at it."""


@dataclass(frozen=True)
class DrawnAxis:
    """An axis of the parallel coordinates."""

    name: str
    x: int
    """Its place, from the left [px]."""
    ticks: tuple[tuple[float, str], ...]
    """Place [px] and text of some values."""


def sweep_page(folder: Path, results: SweepResults) -> str:
    """Return the page."""
    template = resources.files("jaxwalk.sweeps").joinpath("sweep_page.html").read_text(encoding="utf-8")
    plan = results.plan
    return filled_in(
        template,
        results=results, plan=plan, objective=plan.objective, best=results.best[:SHOWN], folder=folder,
        fields=list(plan.fields), shown=shown_value, made=provenance(), curve=curve_name(plan.objective),
        axes=_axes(results), lines=_parallel_lines(results), ticks=_curve_ticks(results), curves=_curve_lines(results),
        size={"wide": WIDE, "tall": TALL, "left": LEFT, "top": TOP, "bottom": BOTTOM},
        across=LEFT * 2 + AXIS * len(plan.fields), last=_last_update(results),
    )  # fmt: skip


def shown_value(value: Any) -> str:
    """Return a value as a page shows it."""
    if isinstance(value, float):
        return f"{value:.4g}"
    return value if isinstance(value, str) else json.dumps(value)


def _height(share: float) -> float:
    """Return the place of a share of an axis [px], from the top."""
    return round(TOP + (TALL - TOP - BOTTOM) * (1 - share), 1)


def _share(varied: Varied, value: Any) -> float:
    """Return where on its axis a value is, from 0 at the bottom to 1."""
    if isinstance(varied, ListedValues):
        return varied.values.index(value) / (len(varied.values) - 1)
    low, high = varied.low, varied.high
    if varied.log:
        return math.log(value / low) / math.log(high / low)
    return (value - low) / (high - low)


def _between(values: Sequence[float]) -> tuple[float, float]:
    """Return the ends of an axis that shows these values."""
    low, high = min(values), max(values)
    return (low, high) if low < high else (low - 0.5, high + 0.5)


def _axes(results: SweepResults) -> list[DrawnAxis]:
    """Return an axis for each field, and one for the objective; none without complete trials."""
    best = results.best
    if not best:
        return []
    found = []
    for index, (name, varied) in enumerate(results.plan.fields.items()):
        ticks = tuple(
            (_height(_share(varied, value)), shown_value(value)) for value in map(varied.value, varied.labels)
        )
        found.append(DrawnAxis(name, LEFT + AXIS * index, ticks))
    ends = _between([trial.value or 0.0 for trial in best])
    ticks = tuple((_height(share), shown_value(float(end))) for share, end in zip((0.0, 1.0), ends, strict=True))
    return [*found, DrawnAxis(results.plan.objective.metric, LEFT + AXIS * len(found), ticks)]


def _parallel_lines(results: SweepResults) -> list[DrawnLine]:
    """Return the line of each complete trial, the best last, so that they lie on top."""
    best, found = results.best, []
    low, high = _between([trial.value or 0.0 for trial in best]) if best else (0.0, 1.0)
    for rank, trial in enumerate(best):
        shares = [_share(varied, trial.values[name]) for name, varied in results.plan.fields.items()]
        shares.append(((trial.value or 0.0) - low) / (high - low))
        points = " ".join(f"{LEFT + AXIS * index},{_height(share)}" for index, share in enumerate(shares))
        kind = "best" if rank < math.ceil(len(best) / BEST_SHARE) else "other"
        found.append(DrawnLine(points, kind, _said(trial)))
    return found[::-1]


def _said(trial: TrialResult) -> str:
    """Return a trial in words."""
    values = ", ".join(f"{name} {shown_value(value)}" for name, value in trial.values.items())
    number = trial.state if trial.value is None else shown_value(float(trial.value))
    return f"trial {trial.number}: {number}; {values}"


def _last_update(results: SweepResults) -> int:
    """Return the last update of all curves."""
    return max((curve.updates[-1] for curve in results.curves.values()), default=1)


def _curve_ends(results: SweepResults) -> tuple[float, float]:
    values = [value for curve in results.curves.values() for value in curve.values]
    return _between(values) if values else (0.0, 1.0)


def _curve_ticks(results: SweepResults) -> list[tuple[float, str]]:
    """Return place and text of three values beside the curves."""
    low, high = _curve_ends(results)
    return [(_height(share), shown_value(low + share * (high - low))) for share in (0.0, 0.5, 1.0)]


def _curve_lines(results: SweepResults) -> list[DrawnLine]:
    """Return the curve of each trial, those of the best ones last."""
    (low, high), last = _curve_ends(results), _last_update(results)
    best = [trial.number for trial in results.best]
    coloured = set(best[: math.ceil(len(best) / BEST_SHARE)])
    found = []
    for trial in results.trials:
        curve = results.curves.get(trial.number)
        if curve is None:
            continue
        corners = [
            f"{LEFT + (WIDE - LEFT) * update / last:.1f},{_height((value - low) / (high - low))}"
            for update, value in zip(curve.updates, curve.values, strict=True)
        ]
        points = " ".join(corners if len(corners) > 1 else [f"{LEFT},{corners[0].partition(',')[2]}", *corners])
        kind = "best" if trial.number in coloured else "other" if trial.state == "complete" else "early"
        found.append(DrawnLine(points, kind, _said(trial)))
    return sorted(found, key=lambda line: line.kind == "best")
