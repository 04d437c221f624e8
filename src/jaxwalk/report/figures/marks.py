"""How numbers are drawn: ours with 95 % intervals, the paper's as open diamonds."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from matplotlib.axes import Axes

from jaxwalk.evaluation.document_parts import Number
from jaxwalk.report.material import Material
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
"""How the paper's numbers look."""


def populations(material: Material, *, spread: float) -> list[tuple[str, str, float]]:
    """Each population with its colour and, its place beside the middle, over a width of ``spread`` in all."""
    names = material.populations
    colours = (ORANGE, BLUE, GREEN, PURPLE)
    step = spread / max(len(names) - 1, 1)
    return [(name, colours[k % len(colours)], step * (k - (len(names) - 1) / 2)) for k, name in enumerate(names)]


def points(
    axis: Axes, ours: Iterable[Number], where: Iterable[float], *,
    color: str, label: str, scale: float, marker: str = "o", flat: bool = False, line: bool = False,
) -> None:  # fmt: skip
    """Numbers with their intervals; ``flat``: values go to the right, places up."""
    placed = zip(where, ours, strict=True)
    shown = [(place, n.value, n.low, n.high) for place, n in placed if n.value is not None]
    places = [place for place, *_ in shown]
    values = [scale * value for _, value, *_ in shown]
    below = [0.0 if low is None else scale * max(value - low, 0.0) for _, value, low, _ in shown]
    above = [0.0 if high is None else scale * max(high - value, 0.0) for _, value, _, high in shown]
    bars = [below, above]
    style: dict[str, Any] = {"color": color, "marker": marker, "markersize": 4, "capsize": 2, "label": label}
    style["linestyle"] = "-" if line else "none"
    if flat:
        axis.errorbar(values, places, xerr=bars, **style)
    else:
        axis.errorbar(places, values, yerr=bars, **style)
