"""Collisions against time: a driver that creeps hits nobody, so neither number says much alone."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxwalk.report.material import POPULATIONS, Material
from jaxwalk.report.style import INK, panels

LEAST = 0.01
"""Collision rates are drawn as at least this [%], since the axis is logarithmic."""


def frontier(material: Material) -> Figure:
    """Each driver's collisions against its time to the goal, a dot for each training seed; the best lie at the left
    below, and the line joins those that nobody beats in both."""
    figure, axes = panels(2, height=4.2, sharey=True)
    for axis, people in zip(axes, POPULATIONS, strict=True):
        _drivers(axis, material, people)
        axis.set(title=f"among {people}", xlabel="mean time to the goal [s]", yscale="log", ylim=(LEAST * 0.8, 100))
    axes[0].set_ylabel("collisions [%]")
    return figure


def _drivers(axis: Axes, material: Material, people: str) -> None:
    means = {}
    for driver in material.drivers:
        found = material.over_seeds(driver, people)
        times, rates = found["mean_time_to_goal"], found["collision_rate"]
        if times["mean"] is None or times["mean"]["value"] is None:
            continue
        dots = [(t, max(100 * rate, LEAST)) for t, rate in zip(times["each"], rates["each"], strict=True) if t]
        axis.plot(*zip(*dots, strict=True), marker=".", markersize=4, linestyle="none", color=INK)
        means[driver] = times["mean"]["value"], max(100 * rates["mean"]["value"], LEAST)
        axis.annotate(driver, means[driver], xytext=(5, 3), textcoords="offset points", fontsize=8)
    unbeaten = [a for a in means.values() if not any(b[0] <= a[0] and b[1] <= a[1] and b != a for b in means.values())]
    axis.plot(*zip(*sorted(unbeaten), strict=True), color=INK, lw=1, alpha=0.5)
