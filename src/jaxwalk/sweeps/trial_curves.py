"""Learning curves of trials, thinned for a page."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from jaxwalk.sweeps.study_file import PERCENT, SweepObjective

MOST_POINTS = 60
"""Most points of a curve."""
UNLESS_TRAINED = "goal_rate"
"""What the curves show if the objective isn't a number of the training."""


@dataclass(frozen=True)
class TrialCurve:
    """A number during the trainings of a trial: means over seeds and over some updates each."""

    updates: tuple[int, ...]
    """The last update of each point."""
    values: tuple[float, ...]
    """The number there."""


def curve_name(objective: SweepObjective) -> str:
    """Return the name of the number that curves show."""
    return objective.metric if objective.of == "training" else UNLESS_TRAINED


def curve_of(seeds: Sequence[Sequence[Mapping[str, Any]]], objective: SweepObjective) -> TrialCurve | None:
    """Return the curve of a trial from the metrics of its seeds; None if there are none."""
    name, last = curve_name(objective), max((lines[-1]["update"] for lines in seeds if lines), default=0)
    width = max(1, math.ceil(last / MOST_POINTS))
    points: dict[int, list[float]] = defaultdict(list)
    for line in (line for lines in seeds for line in lines):
        if name in line and (name not in PERCENT or line["episodes"]):
            points[min(last, width * math.ceil(line["update"] / width))].append(line[name])
    if not points:
        return None
    at = tuple(sorted(points))
    return TrialCurve(at, tuple(math.fsum(points[update]) / len(points[update]) for update in at))
