"""Contacts against delay in a suite: a line for each driver, a sign for each setting of its knob."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.evaluation.frontier_scores import FrontierScores, FrontierSuite, Standing, standings
from jaxwalk.report.figures.frontier import LEAST, SIGNS
from jaxwalk.report.style import drawing, panels, save


def draw_frontiers(suites: Sequence[FrontierSuite], folder: Path) -> None:
    """Write the plot of each suite into the folder, as ``frontier-SUITE.svg`` and ``.png``."""
    for found in suites:
        name = f"frontier-{found.suite}"
        with drawing(name):
            save(plot(found), folder, name)


def plot(found: FrontierSuite) -> Figure:
    """Draw contacts against delay with their intervals; filled: nobody beats it, hollow: dominated or open."""
    figure, (axis,) = panels(1, height=5.6)
    families = list(dict.fromkeys(one.contender.family for one in found.scores))
    pairs = list(zip(found.scores, standings(found.scores), strict=True))
    for family, sign in zip(families, cycle(SIGNS), strict=False):
        _line(axis, [pair for pair in pairs if pair[0].contender.family == family], family, sign)
    axis.set(
        title=f"{found.suite}, among {found.pedestrians}", xlabel="mean delay [s]",
        ylabel="scenarios with a contact of the moving car [%]", yscale="log", ylim=(LEAST * 0.7, 100),
    )  # fmt: skip
    axis.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    figure.legend(*axis.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _line(axis: Axes, pairs: Sequence[tuple[FrontierScores, Standing]], family: str, sign: tuple[str, str]) -> None:
    """Draw the settings of one driver in their order; one that never arrives has no delay and is left out."""
    marker, colour = sign
    drawn = [(one.mean_delay(), one.contact_rate(), standing.verdict) for one, standing in pairs]
    points = [(delay.value, _percent(rate.value)) for delay, rate, _ in drawn if delay.value is not None]
    x, y = zip(*points, strict=True) if points else ((), ())
    axis.plot(x, y, marker=marker, markersize=5, linestyle="-", lw=0.8, color=colour, mfc="none", label=family)
    for delay, rate, verdict in drawn:
        if delay.value is None:
            continue
        _bars(axis, Interval.of(delay), Interval.of(rate), colour)
        if verdict == "not dominated":
            axis.plot([delay.value], [_percent(rate.value)], marker=marker, markersize=6, color=colour)


def _bars(axis: Axes, delay: Interval, rate: Interval, colour: str) -> None:
    """Draw both intervals."""
    across, up = (delay.low, delay.value, delay.high), (rate.low, rate.value, rate.high)
    x = [x for x in across if x is not None]
    axis.plot(x, [_percent(rate.value)] * len(x), color=colour, lw=0.6, alpha=0.5)
    axis.plot([delay.value or 0.0] * len(up), [_percent(y) for y in up], color=colour, lw=0.6, alpha=0.5)


def _percent(share: float | None) -> float:
    """Return a share in per cent, at least as large as is drawn."""
    return max(100 * (share or 0.0), LEAST)
