"""The car's speed near jaywalkers and near crosswalk users, and how much of the difference is due to them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxwalk.evaluation.document_parts import Number
from jaxwalk.metrics import SPEED_DIFFERENTIAL
from jaxwalk.metrics.speed_differential import SpeedBin, SpeedGap
from jaxwalk.report import published
from jaxwalk.report.figures.marks import DIAMOND, TYPES, PointStyle, points
from jaxwalk.report.material import Material
from jaxwalk.report.style import BLUE, GREEN, GRID, INK, PURPLE, RED, SKY, panels
from jaxwalk.report.surprise import FEWEST

WEIGHTS: dict[str, tuple[Callable[[SpeedBin], SpeedGap], str]] = {
    "pooled over frames": (lambda b: b.pooled, PURPLE),
    "by encounter": (lambda b: b.by_encounter, GREEN),
}
"""How speeds are averaged, where the numbers are stored, and their colour."""


def speed_differential(material: Material) -> Figure:
    """Draw car speed by distance to the nearest pedestrian on a roadway, by type; shade the gap, and plot it."""
    figure, axes = panels(3, height=3.0)
    bins = material.cell(material.subject, material.crowd).summary[SPEED_DIFFERENTIAL]
    street = material.results.street
    top = 9.0 if street is None else max(9.0, 1.05 * street.sim.max_speed)
    for axis, (title, (gap, _)) in zip(axes, WEIGHTS.items(), strict=False):
        _speeds(axis, [gap(b) for b in bins], [_middle(b) for b in bins])
        axis.set(title=f"car speed, {title} [m/s]", ylim=(0, top))
    for value in published.SPEEDS if material.beside_paper else ():
        axes[0].plot(_middle(bins[0]), value, **DIAMOND, label="paper" if value == published.SPEEDS[0] else None)
    _gaps(axes[2], bins)
    if material.beside_paper:
        _their_gaps(axes[2], bins)
    for axis in axes:
        axis.set(xlim=(0, bins[-1].far), xticks=[0, *(b.far for b in bins)])
    axes[1].set_xlabel("distance to the nearest pedestrian of the type [m]")
    named = [axis.get_legend_handles_labels() for axis in (axes[0], axes[2])]
    handles, labels = (left + right for left, right in zip(*named, strict=True))
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _middle(b: SpeedBin) -> float:
    return (b.near + b.far) / 2


def _speeds(axis: Axes, gaps: Sequence[SpeedGap], middles: list[float]) -> None:
    """Draw the speeds near both types, and the gap between them."""
    near, lines = {"crosswalk": [g.crosswalk for g in gaps], "jaywalk": [g.jaywalk for g in gaps]}, {}
    for k, (kind, colour) in enumerate(TYPES.items()):
        where = [m + 0.16 * (2 * k - 1) for m in middles]
        points(axis, near[kind], where, PointStyle(color=colour, label=f"near {kind}", scale=1.0, line=True))
        lines[kind] = [math.nan if x.value is None else x.value for x in near[kind]]
    axis.fill_between(middles, lines["crosswalk"], lines["jaywalk"], color=GRID, alpha=0.25, label="gap", lw=0)


def _gaps(axis: Axes, bins: Sequence[SpeedBin]) -> None:
    """Draw the differences with both weights."""
    for k, (title, (gap, colour)) in enumerate(WEIGHTS.items()):
        ours = [gap(b).difference for b in bins]
        where = [_middle(b) + 0.16 * (2 * k - 1) for b in bins]
        points(axis, ours, where, PointStyle(color=colour, label=title, scale=1.0, line=True))
    axis.axhline(0, color=INK, lw=0.8)
    axis.set_title("jaywalk minus crosswalk [m/s]")


def _their_gaps(axis: Axes, bins: Sequence[SpeedBin]) -> None:
    """Draw the paper's differences."""
    axis.plot(_middle(bins[0]), published.SPEED_GAP, **DIAMOND)
    low, high = published.SPEED_GAP_FARTHER
    axis.fill_between([bins[1].near, bins[-1].far], low, high, alpha=0.25, color=SKY, lw=0, label="paper, 3-12 m")


def surprise(material: Material) -> Figure:
    """Draw the difference four ways, and how much more it is than near ghosts, among each population."""
    figure, axes = panels(len(material.populations), height=3.2, sharey=True)
    for axis, people in zip(axes, material.populations, strict=True):
        found = material.cell(material.subject, people).summary[SPEED_DIFFERENTIAL]
        bins = [b for b in found if b.by_encounter.difference.count >= FEWEST]
        for k, (name, (find, colour, marker)) in enumerate(WAYS.items()):
            where = [_middle(b) + 0.3 * (k - 2) for b in bins]
            points(axis, [find(b) for b in bins], where, PointStyle(color=colour, label=name, scale=1.0, marker=marker))
        axis.axhline(0, color=INK, lw=0.8)
        edges = [0, *(b.far for b in found)]
        axis.set(title=f"among {people}", xlim=(0, edges[-1]), xticks=edges)
        if not bins:
            axis.text(0.5, 0.6, "too few encounters", ha="center", transform=axis.transAxes)
    axes[len(axes) // 2].set_xlabel("distance to the nearest pedestrian of the type [m]")
    axes[0].set_ylabel("jaywalk minus crosswalk [m/s]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure


WAYS: dict[str, tuple[Callable[[SpeedBin], Number], str, str]] = {
    "frames": (lambda b: b.pooled.difference, PURPLE, "o"),
    "encounters": (lambda b: b.by_encounter.difference, GREEN, "s"),
    "matched": (lambda b: b.matched, BLUE, "^"),
    "ghosts": (lambda b: b.placebo.ghosts.difference, GRID, "x"),
    "people minus ghosts": (lambda b: b.placebo.difference, RED, "v"),
}
"""How to find the differences in a bin, their colours and markers; the names are those of the table."""
