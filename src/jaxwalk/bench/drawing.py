"""Plots of rates, time and memory over environments and pedestrians."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from jaxwalk.bench.quantities import Rows, exponent, microseconds
from jaxwalk.report.style import BLUE, GREEN, ORANGE, RED, drawing, panels, save

NAME = "scaling"
"""Name of the files, without ending."""
DRAWN = ("env", "training", "pedestrians")
"""Lists of rows that are drawn."""


def draw(rows: Rows, folder: Path) -> None:
    """Write scaling.svg and scaling.png; if nothing in `DRAWN` was measured, remove earlier ones."""
    with drawing(NAME):
        figure = scaling(rows)
        if figure is not None:
            save(figure, folder, NAME)
            return
    for suffix in (".svg", ".png"):
        (folder / f"{NAME}{suffix}").unlink(missing_ok=True)


def scaling(rows: Rows) -> Figure | None:
    """Return a figure of rates over environments, and of time and memory over pedestrians with their slopes."""
    rates = bool(rows.get("env") or rows.get("training"))
    crowd = rows.get("pedestrians", ())
    count = rates + 2 * bool(crowd)
    if not count:
        return None
    figure, axes = panels(count, width=4.0 * count, height=3.6)
    if rates:
        _rates(axes[0], rows)
    if crowd:
        time, space = axes[-2:]
        _growth(time, crowd, [microseconds(row) for row in crowd], "time of a step [us]", BLUE)
        each = [row["temporary_bytes"] / row["environments"] / 1e3 for row in crowd]
        _growth(space, crowd, each, "temporary memory of an environment [kB]", ORANGE)
    return figure


def _rates(axis: Axes, rows: Rows) -> None:
    simulated = [row for row in rows.get("env", ()) if row["observations"] == "every"]
    _line(axis, simulated, "env_steps_per_s", "simulator alone", BLUE)
    for recipe, colour in (("fast", GREEN), ("paper", RED)):
        trained = [row for row in rows.get("training", ()) if row["recipe"] == recipe and not row["single_agent"]]
        _line(axis, trained, "train_steps_per_s", f"training, {recipe}", colour)
    axis.set(title="steps per second", xlabel="environments", xscale="log", yscale="log")
    for numbers in (axis.xaxis, axis.yaxis):
        numbers.set_major_formatter(FuncFormatter(lambda x, _: f"{x:,.0f}"))
    axis.legend()


def _line(axis: Axes, rows: Sequence[Mapping[str, Any]], name: str, label: str, colour: str) -> None:
    points = sorted((row["environments"], row[name]) for row in rows)
    if points:
        axis.plot(*zip(*points, strict=True), marker="o", color=colour, label=label)


def _growth(axis: Axes, rows: Sequence[Mapping[str, Any]], values: list[float], title: str, colour: str) -> None:
    people = [row["pedestrians"] for row in rows]
    slope = exponent(people, values)
    axis.plot(people, values, marker="o", color=colour, label=None if slope is None else f"slope {slope:.2f}")
    axis.set(title=title, xlabel="pedestrians", xscale="log", yscale="log")
    axis.set_xticks(people, [str(n) for n in people])
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    axis.yaxis.set_minor_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    if slope is not None:
        axis.legend()
