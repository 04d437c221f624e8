"""Learning curves of the drivers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from jaxwalk.metrics import interquartile_mean
from jaxwalk.report.material import LearningCurve, Material
from jaxwalk.report.style import GREEN, GRID, RED, panels

SMOOTH = 20
"""Learning curves are running means over the training divided by this number."""
ENDINGS: dict[str, tuple[Callable[[LearningCurve], Sequence[float]], str]] = {
    "goal": (lambda curve: curve.goal_rate, GREEN),
    "collision": (lambda curve: curve.collision_rate, RED),
    "timeout": (lambda curve: curve.timeout_rate, GRID),
}
"""How episodes end, where the share is stored, and its colour; timeouts only with one training seed, for lack of space.
"""


def learning_curves(material: Material) -> Figure:
    """Draw goal and collision rates during training, over the episodes that ended in each update."""
    figure, axes = panels(len(material.curves), sharey=True)
    shown = [name for name in ENDINGS if name != "timeout" or not material.several]
    for axis, (name, curves) in zip(axes, material.curves.items(), strict=True):
        for ending in shown:
            _curve(axis, list(curves.values()), ending)
        axis.set(title=name, xlabel="environment steps [million]", ylim=(0, 100))
        axis.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x / 1e6:g}"))
    axes[0].set_ylabel("episodes [%]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _curve(axis: Axes, curves: list[LearningCurve], ending: str) -> None:
    """Draw the interquartile mean over training seeds and, if there are several, a thin line for each."""
    share, colour = ENDINGS[ending]
    steps = curves[0].steps
    seeds = [_running_mean(share(curve), curve.episodes) for curve in curves]
    found = 100 * np.transpose(seeds)
    if len(curves) > 1:
        axis.plot(steps, found, color=colour, lw=0.6, alpha=0.5)
    label = ending + (", IQM" if len(curves) > 1 else "")
    axis.plot(steps, interquartile_mean(found), color=colour, lw=2.0 if len(curves) > 1 else None, label=label)


def _running_mean(values: Sequence[float], weights: Sequence[float]) -> list[float]:
    """Return weighted means over the last values up to each one; NaN before the first episode ends."""
    width = max(1, len(values) // SMOOTH)
    means = []
    for i in range(len(values)):
        part = slice(max(0, i + 1 - width), i + 1)
        total = sum(weights[part])
        means.append(
            sum(v * w for v, w in zip(values[part], weights[part], strict=True)) / total if total else math.nan
        )
    return means
