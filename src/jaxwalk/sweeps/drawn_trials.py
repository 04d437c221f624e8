"""Pieces of the pictures of a sweep's page: lines, axes and places, in pixels."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from jaxwalk.sweeps.varied import ListedValues, Varied

if TYPE_CHECKING:
    from jaxwalk.sweeps.sweep_results import TrialResult

TALL, WIDE = 300, 760
"""Height of a picture, width of one over updates or generations [px]."""
LEFT, TOP, BOTTOM = 70, 16, 30
"""Margins [px]."""


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
    """An axis of a picture."""

    name: str
    x: int
    """Its place, from the left [px]."""
    ticks: tuple[tuple[float, str], ...]
    """Place [px] and text of some values."""


def shown_value(value: Any) -> str:
    """Return a value as a page shows it."""
    if isinstance(value, float):
        return f"{value:.4g}"
    return value if isinstance(value, str) else json.dumps(value)


def height_of(share: float) -> float:
    """Return the place of a share of an axis [px], from the top."""
    return round(TOP + (TALL - TOP - BOTTOM) * (1 - share), 1)


def share_of(varied: Varied, value: Any) -> float:
    """Return where on its axis a value is, from 0 at the bottom to 1."""
    if isinstance(varied, ListedValues):
        return varied.values.index(value) / (len(varied.values) - 1)
    low, high = varied.low, varied.high
    if varied.log:
        return math.log(value / low) / math.log(high / low)
    return (value - low) / (high - low)


def between(values: Sequence[float]) -> tuple[float, float]:
    """Return the ends of an axis that shows these values."""
    low, high = min(values), max(values)
    return (low, high) if low < high else (low - 0.5, high + 0.5)


def axis_of(name: str, varied: Varied, x: int) -> DrawnAxis:
    """Return the axis of a field."""
    ticks = ((height_of(share_of(varied, value)), shown_value(value)) for value in map(varied.value, varied.labels))
    return DrawnAxis(name, x, tuple(ticks))


def said_of(trial: TrialResult) -> str:
    """Return a trial in words."""
    values = ", ".join(f"{name} {shown_value(value)}" for name, value in trial.values.items())
    number = trial.state if trial.value is None else shown_value(float(trial.value))
    return f"trial {trial.number}: {number}; {values}"
