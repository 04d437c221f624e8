"""Goal and collision rates of drivers: of all drivers, and of the co-trained one with less and more jaywalking."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxwalk.evaluation.document_parts import SeedNumbers
from jaxwalk.metrics import OverSeeds
from jaxwalk.report import published
from jaxwalk.report.figures.marks import DIAMOND, PointStyle, points, populations
from jaxwalk.report.material import Material
from jaxwalk.report.style import INK, panels

RATES: tuple[tuple[Callable[[SeedNumbers], OverSeeds], str, int], ...] = (
    (lambda numbers: numbers.goal_rate, "goals [%]", 0),
    (lambda numbers: numbers.collision_rate, "collisions [%]", 1),
)
"""What to show, its label, and its index in the paper's pairs."""


def baselines(material: Material) -> Figure:
    """Draw goal and collision rates of every driver, among each population."""
    figure, axes = panels(2, height=3.8, sharey=True)
    names = material.drivers
    known = [name for name in names if material.beside_paper and _published(name, 0)]
    for axis, (rate, unit, place) in zip(axes, RATES, strict=True):
        for people, colour, aside in populations(material.populations, spread=0.34):
            ours = [rate(material.over_seeds(name, people)) for name in names]
            where = [i + aside for i in range(len(names))]
            means, label = [number.mean for number in ours], f"ours, among {people}"
            points(axis, means, where, PointStyle(color=colour, label=label, scale=100.0, flat=True))
            first = people == material.populations[0]
            _each_seed(axis, ours, where, "each training seed" if first and material.several else None)
        for name in known:
            theirs = _published(name, place)
            where = [names.index(name)] * len(theirs)
            axis.plot(theirs, where, **DIAMOND, label="paper" if name == known[0] else None)
        axis.set(xlabel=unit, xlim=(-2, 102))
    axes[0].set_yticks(range(len(names)), names)
    axes[0].invert_yaxis()
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _each_seed(axis: Axes, ours: list[OverSeeds], where: list[float], label: str | None) -> None:
    """Draw a dot for each training seed, if there are several."""
    several = [(number.each, place) for number, place in zip(ours, where, strict=True) if len(number.each) > 1]
    shown = [(100 * value, place) for each, place in several for value in each if value is not None]
    values, places = [value for value, _ in shown], [place for _, place in shown]
    axis.plot(values, places, color=INK, marker=".", markersize=4, linestyle="none", zorder=5, label=label)


def _published(driver: str, place: int) -> list[float]:
    if driver in published.BASELINES:
        return [published.BASELINES[driver][place]]
    return [pair[place] for (name, _), pair in published.TRAINED.items() if name == driver]


def ablation(material: Material) -> Figure:
    """Draw goal and collision rates of the co-trained driver by jaywalk multiplier."""
    figure, axes = panels(2)
    for axis, (rate, label, place) in zip(axes, RATES, strict=True):
        for people, colour, aside in populations(material.ablated_populations, spread=0.02):
            ours = [rate(material.ablated(m, people)).mean for m in material.multipliers]
            where = [m + aside for m in material.multipliers]
            points(axis, ours, where, PointStyle(color=colour, label=f"ours, among {people}", scale=100.0, line=True))
        theirs = [pair[place] for pair in published.ABLATION.values()]
        style: dict[str, Any] = DIAMOND | {"linestyle": ":", "label": "paper, among always-go"}
        axis.plot(list(published.ABLATION), theirs, **style)
        axis.set(xlabel="jaywalk multiplier", ylabel=label, ylim=(0, 100 if place == 0 else None))
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure
