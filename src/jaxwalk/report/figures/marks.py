"""Draw numbers: ours with 95 % intervals, the paper's as open diamonds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes

from jaxwalk.evaluation.document_parts import Number
from jaxwalk.report.style import BLUE, GREEN, ORANGE, PAPER, PURPLE, RED
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK

TYPES = {CROSSWALK.word: BLUE, JAYWALK.word: RED}
"""Colours of the types of crossing."""
DIAMOND: dict[str, Any] = {
    "color": PAPER,
    "marker": "D",
    "markersize": 6,
    "markerfacecolor": "none",
    "linestyle": "none",
    "zorder": 4,
}
"""How the paper's numbers are drawn."""


def populations(names: Sequence[str], *, spread: float) -> list[tuple[str, str, float]]:
    """Return each population with its colour and its offset from the middle; ``spread`` is the total width."""
    colours = (ORANGE, BLUE, GREEN, PURPLE)
    step = spread / max(len(names) - 1, 1)
    return [(name, colours[k % len(colours)], step * (k - (len(names) - 1) / 2)) for k, name in enumerate(names)]


@dataclass(frozen=True)
class PointStyle:
    """How a row of numbers is drawn."""

    color: str
    label: str | None
    scale: float
    """Factor by which numbers are multiplied."""
    marker: str = "o"
    flat: bool = False
    """Whether values run along the horizontal axis and places along the vertical one."""
    line: bool = False
    """Whether a line joins the numbers."""


def points(axis: Axes, ours: Iterable[Number], where: Iterable[float], drawn_as: PointStyle) -> None:
    """Draw numbers at their places, with their intervals."""
    placed = zip(where, ours, strict=True)
    shown = [(place, n.value, n.low, n.high) for place, n in placed if n.value is not None]
    places = [place for place, *_ in shown]
    values = [drawn_as.scale * value for _, value, *_ in shown]
    below = [0.0 if low is None else drawn_as.scale * max(value - low, 0.0) for _, value, low, _ in shown]
    above = [0.0 if high is None else drawn_as.scale * max(high - value, 0.0) for _, value, _, high in shown]
    bars = [below, above]
    style: dict[str, Any] = {
        "color": drawn_as.color,
        "marker": drawn_as.marker,
        "markersize": 4,
        "capsize": 2,
        "label": drawn_as.label,
    }
    style["linestyle"] = "-" if drawn_as.line else "none"
    if drawn_as.flat:
        axis.errorbar(values, places, xerr=bars, **style)
    else:
        axis.errorbar(places, values, yerr=bars, **style)
