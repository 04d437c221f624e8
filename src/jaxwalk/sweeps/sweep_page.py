"""The page of a sweep: the best trials, which field mattered, parallel coordinates and learning curves.

It is one static file without a script: pictures are SVG, made here from numbers.
"""

from __future__ import annotations

import math
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from jaxwalk.provenance import provenance
from jaxwalk.sweeps.drawn_population import ancestry, drawn_lineage, drawn_moves, place_of
from jaxwalk.sweeps.drawn_trials import (
    BOTTOM,
    LEFT,
    TALL,
    TOP,
    WIDE,
    DrawnAxis,
    DrawnLine,
    axis_of,
    between,
    height_of,
    said_of,
    share_of,
    shown_value,
)  # fmt: skip
from jaxwalk.sweeps.trial_curves import curve_name
from jaxwalk.viewer.filled_page import filled_in

if TYPE_CHECKING:
    from jaxwalk.sweeps.sweep_results import SweepResults

SHOWN = 10
"""Number of trials in the table of the best."""
AXIS = 150
"""Distance of two axes [px]."""
BEST_SHARE = 4
"""One of this many trials, the best ones, is coloured."""


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
        lineage=drawn_lineage(results), moves=drawn_moves(results), place=place_of,
    )  # fmt: skip


def _axes(results: SweepResults) -> list[DrawnAxis]:
    """Return an axis for each field, and one for the objective; none without complete trials."""
    best = results.best
    if not best:
        return []
    found = []
    for index, (name, varied) in enumerate(results.plan.fields.items()):
        found.append(axis_of(name, varied, LEFT + AXIS * index))
    ends = between([trial.value or 0.0 for trial in best])
    ticks = tuple((height_of(share), shown_value(float(end))) for share, end in zip((0.0, 1.0), ends, strict=True))
    return [*found, DrawnAxis(results.plan.objective.metric, LEFT + AXIS * len(found), ticks)]


def _parallel_lines(results: SweepResults) -> list[DrawnLine]:
    """Return the line of each complete trial, the best last, so that they lie on top."""
    best, found = results.best, []
    low, high = between([trial.value or 0.0 for trial in best]) if best else (0.0, 1.0)
    for rank, trial in enumerate(best):
        shares = [share_of(varied, trial.values[name]) for name, varied in results.plan.fields.items()]
        shares.append(((trial.value or 0.0) - low) / (high - low))
        points = " ".join(f"{LEFT + AXIS * index},{height_of(share)}" for index, share in enumerate(shares))
        kind = "best" if rank < math.ceil(len(best) / BEST_SHARE) else "other"
        found.append(DrawnLine(points, kind, said_of(trial)))
    return found[::-1]


def _last_update(results: SweepResults) -> int:
    """Return the last update of all curves."""
    return max((curve.updates[-1] for curve in results.curves.values()), default=1)


def _curve_ends(results: SweepResults) -> tuple[float, float]:
    values = [value for curve in results.curves.values() for value in curve.values]
    return between(values) if values else (0.0, 1.0)


def _curve_ticks(results: SweepResults) -> list[tuple[float, str]]:
    """Return place and text of three values beside the curves."""
    low, high = _curve_ends(results)
    return [(height_of(share), shown_value(low + share * (high - low))) for share in (0.0, 0.5, 1.0)]


def _curve_lines(results: SweepResults) -> list[DrawnLine]:
    """Return the curve of each trial, those of the best ones last."""
    (low, high), last = _curve_ends(results), _last_update(results)
    best = [trial.number for trial in results.best]
    coloured = set(ancestry(results) if results.plan.pbt else best[: math.ceil(len(best) / BEST_SHARE)])
    found = []
    for trial in results.trials:
        curve, before = (
            results.curves.get(trial.number),
            results.curves.get(-1 if trial.parent is None else trial.parent),
        )
        if curve is None:
            continue
        reached = list(zip(curve.updates, curve.values, strict=True))
        if before is not None:  # the line begins where it goes on from
            reached.insert(0, (before.updates[-1], before.values[-1]))
        corners = [
            f"{LEFT + (WIDE - LEFT) * update / last:.1f},{height_of((value - low) / (high - low))}"
            for update, value in reached
        ]
        points = " ".join(corners if len(corners) > 1 else [f"{LEFT},{corners[0].partition(',')[2]}", *corners])
        kind = "best" if trial.number in coloured else "other" if trial.state == "complete" else "early"
        found.append(DrawnLine(points, kind, said_of(trial)))
    return sorted(found, key=lambda line: line.kind == "best")
