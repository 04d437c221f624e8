"""Collisions against time: a driver that creeps hits nobody, so neither number is enough alone."""

from __future__ import annotations

from itertools import cycle

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from jaxwalk.report.material import Material
from jaxwalk.report.style import BLUE, GREEN, GRID, INK, ORANGE, PURPLE, RED, SKY, panels

LEAST = 0.01
"""Smallest collision rate drawn [%]; smaller ones are drawn here, since the axis is logarithmic."""
SIGNS = tuple(zip("sv^<DoxP*hpd" * 2, cycle((GRID, PURPLE, SKY, GREEN, ORANGE, RED, BLUE, INK)), strict=False))
"""A marker and a colour for each of 24 drivers, in order; no two are alike."""


def frontier(material: Material) -> Figure:
    """Draw each driver's collisions against its time to goal, one marker for each training seed; low left is best.

    The line joins the drivers that no other driver beats in both, by their means over seeds.
    """
    figure, axes = panels(len(material.populations), height=3.9, sharey=True)
    for axis, people in zip(axes, material.populations, strict=True):
        _drivers(axis, material, people)
        axis.set(title=f"among {people}", xlabel="mean time to the goal [s]", yscale="log", ylim=(LEAST * 0.7, 100))
        axis.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    axes[0].set_ylabel("collisions [%]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _drivers(axis: Axes, material: Material, people: str) -> None:
    means = []
    for driver, (marker, colour) in zip(material.drivers, cycle(SIGNS), strict=False):
        found = material.over_seeds(driver, people)
        times, rates = found.mean_time_to_goal, found.collision_rate
        each = zip(times.each, rates.each, strict=True)
        seeds = [(t, max(100 * rate, LEAST)) for t, rate in each if t and rate is not None]
        x, y = zip(*seeds, strict=True) if seeds else ((), ())
        axis.plot(x, y, marker=marker, markersize=6, linestyle="none", color=colour, alpha=0.8, label=driver)
        time, rate = times.mean.value, rates.mean.value
        if time is not None and rate is not None:
            means.append((time, max(100 * rate, LEAST)))
    unbeaten = [a for a in means if not any(b[0] <= a[0] and b[1] <= a[1] and b != a for b in means)]
    if unbeaten:
        axis.plot(*zip(*sorted(unbeaten), strict=True), color=INK, lw=1, alpha=0.5, zorder=0)
