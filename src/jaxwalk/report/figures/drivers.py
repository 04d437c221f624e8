"""Goals and collisions of drivers: all of them, and the co-trained one with more and less jaywalking."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxwalk.report import published
from jaxwalk.report.figures.marks import COLOURS, DIAMOND, points
from jaxwalk.report.material import POPULATIONS, Material, Number
from jaxwalk.report.style import INK, panels

RATES = (("goal_rate", "goals [%]", 0), ("collision_rate", "collisions [%]", 1))
"""What to show, its label, and its place in the paper's pairs."""


def baselines(material: Material) -> Figure:
    """Goals and collisions of every driver, among both populations."""
    figure, axes = panels(2, height=3.8, sharey=True)
    names = material.drivers
    for axis, (rate, unit, place) in zip(axes, RATES, strict=True):
        for k, people in enumerate(POPULATIONS):
            ours = [material.over_seeds(name, people)[rate] for name in names]
            where = [i + 0.17 * (2 * k - 1) for i in range(len(names))]
            means, label = [number["mean"] for number in ours], f"ours, among {people}"
            points(axis, means, where, color=COLOURS[people], label=label, scale=100.0, flat=True)
            _each_seed(axis, ours, where, "each training seed" if k == 0 and material.several else None)
        for i, name in enumerate(names):
            for value in _published(name, place):
                axis.plot(value, i, **DIAMOND, label="paper" if i == 0 else None)
        axis.set(xlabel=unit, xlim=(-2, 102))
    axes[0].set_yticks(range(len(names)), names)
    axes[0].invert_yaxis()
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _each_seed(axis: Axes, ours: list[Number], where: list[float], label: str | None) -> None:
    """A dot for each training seed, where there are several."""
    several = [(number["each"], place) for number, place in zip(ours, where, strict=True) if len(number["each"]) > 1]
    values = [100 * value for each, _ in several for value in each]
    places = [place for each, place in several for _ in each]
    axis.plot(values, places, color=INK, marker=".", markersize=4, linestyle="none", zorder=5, label=label)


def _published(driver: str, place: int) -> list[float]:
    if driver in published.BASELINES:
        return [published.BASELINES[driver][place]]
    return [pair[place] for (name, _), pair in published.TRAINED.items() if name == driver]


def ablation(material: Material) -> Figure:
    """Goals and collisions of the co-trained driver by jaywalk multiplier."""
    figure, axes = panels(2)
    for axis, (rate, label, place) in zip(axes, RATES, strict=True):
        for k, people in enumerate(POPULATIONS):
            ours = [material.ablated(m, people)[rate]["mean"] for m in material.multipliers]
            where = [m + 0.01 * (2 * k - 1) for m in material.multipliers]
            points(axis, ours, where, color=COLOURS[people], label=f"ours, among {people}", scale=100.0, line=True)
        theirs = [pair[place] for pair in published.ABLATION.values()]
        style: dict[str, Any] = DIAMOND | {"linestyle": ":", "label": "paper, among always-go"}
        axis.plot(list(published.ABLATION), theirs, **style)
        axis.set(xlabel="jaywalk multiplier", ylabel=label, ylim=(0, 100 if place == 0 else None))
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure
