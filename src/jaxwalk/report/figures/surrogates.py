"""How near encounters came to a collision: the share beyond every threshold, not only the critical one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxwalk.metrics import SURROGATE_DISTRIBUTIONS
from jaxwalk.metrics.severity import Distribution, Distributions
from jaxwalk.metrics.surrogate import DRAC_CRITICAL, PET_CRITICAL, TTC_CRITICAL
from jaxwalk.report.figures.marks import TYPES
from jaxwalk.report.material import Material
from jaxwalk.report.style import INK, panels
from jaxwalk.report.table import by_type

MEASURES: dict[str, tuple[Callable[[Distributions], Distribution], float, str]] = {
    "time to collision below [s]": (lambda d: d.ttc, TTC_CRITICAL, "critical"),
    "post-encroachment time below [s]": (lambda d: d.pet, PET_CRITICAL, "critical"),
    "required deceleration above [m/s²]": (lambda d: d.drac, DRAC_CRITICAL, "critical"),
    "gap between car and body up to [m]": (lambda d: d.gap, 0.0, "touch"),
}
"""The measures: where each distribution is stored, the value beyond which an encounter is critical, and its name."""
FEWEST = 20
"""A curve of fewer encounters is not drawn."""


def surrogates(material: Material) -> Figure:
    """Draw the share of encounters beyond thresholds of four measures, by type and driver."""
    figure, axes = panels(2, rows=2, height=5.2)
    drivers = [(material.subject, "-"), *([(material.rival, "--")] if material.rival else [])]
    people = material.populations[0]  # always-go, who leave it to the driver
    found = {driver: by_type(material.cell(driver, people).summary[SURROGATE_DISTRIBUTIONS]) for driver, _ in drivers}
    for axis, (label, (find, critical, word)) in zip(axes, MEASURES.items(), strict=True):
        for driver, line in drivers:
            for kind, colour in TYPES.items():
                _curve(axis, find(found[driver][kind]), colour, line, f"{driver}, {kind}")
        axis.axvline(critical, color=INK, lw=0.8, ls=":")
        where = axis.get_xaxis_transform()
        axis.text(critical, 1.0, f" {word}", transform=where, va="top", fontsize=7, color=INK)
        axis.set(xlabel=label, ylim=(0, None))
    for axis in axes[::2]:
        axis.set_ylabel("encounters [%]")
    named = {}
    for axis in axes:  # a panel may lack curves
        named |= dict(zip(*reversed(axis.get_legend_handles_labels()), strict=True))
    figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=4)
    return figure


def _curve(axis: Axes, found: Distribution, colour: str, line: str, label: str) -> None:
    """Draw one distribution with its band."""
    if found.count < FEWEST:
        return
    low, value, high = (100 * np.array(x, float) for x in (found.low, found.value, found.high))
    axis.plot(found.threshold, value, color=colour, ls=line, label=label)
    axis.fill_between(found.threshold, low, high, color=colour, alpha=0.15, lw=0)
