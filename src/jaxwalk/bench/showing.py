"""Shows a benchmark's document as a table on the terminal and as Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from statistics import median
from typing import Any

import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from jaxwalk.bench.drawing import DRAWN, NAME
from jaxwalk.bench.quantities import memory, microseconds
from jaxwalk.metrics.statistics import quantile
from jaxwalk.report.table import markdown_table

COLUMNS = {
    "env": (
        "environments",
        "observations",
        "env steps/s",
        "memory [MB]",
        "temporary [MB]",
        "state [MB]",
        "kept [MB]",
        "compiled in [s]",
    ),
    "training": ("recipe", "environments x steps", "train steps/s", "transitions/s", "GFLOP/s", "first update [s]"),
    "pedestrians": ("pedestrians", "us per step", "temporary kB per environment", "compiled in [s]"),
    "products": ("matrices", "precision", "GFLOP/s"),
    "streets": ("observations", "streets", "env steps/s", "kB per street"),
    "train-streets": ("recipe", "train steps/s"),
    "suites": ("suite", "pedestrians", "env steps/s", "of the paper's street with 12 people [95 %]"),
}
"""Column titles of each list of rows."""


def shown(value: float | int, unit: str) -> str:
    """Return a figure with its unit, rounded for reading."""
    if unit in ("steps/s", "transitions/s"):
        return f"{value:,.0f} {unit}"
    if unit == "share":
        return f"{100 * value:.1f} %"
    for size, prefix in ((1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k")):
        if unit in ("FLOP", "FLOP/s", "B") and value >= size:
            return f"{value / size:,.1f} {prefix}{unit}"
    return f"{value:.2f}" + (f" {unit}" if unit == "s" else "")


def table(document: Mapping[str, Any]) -> Table:
    """Return a table of all figures."""
    drawn = Table("figure", box=SIMPLE, padding=(0, 1), caption=caption(document), caption_justify="left")
    drawn.add_column("value", justify="right", no_wrap=True)
    drawn.add_column("what it is")
    for name, figure in document["figures"].items():
        drawn.add_row(name, shown(figure["value"], figure["unit"]), figure["what"])
    return drawn


def caption(document: Mapping[str, Any]) -> str:
    """Return the origin of the figures."""
    made, quick = document["provenance"], "quick: no measure of this machine; " if document["options"]["quick"] else ""
    versions = ", ".join(f"{name} {version}" for name, version in made["versions"].items())
    return f"{quick}{made['hardware']}; commit {made['commit'] or 'unknown'}; {versions}"


def markdown(document: Mapping[str, Any]) -> str:
    """Return all figures and rows as a Markdown page, which shows the plots beside it."""
    figures = [
        (f"`{name}`", shown(x["value"], x["unit"]), x["what"]) for name, x in document["figures"].items()
    ]  # fmt: skip
    parts = ["# Benchmark", f"{caption(document)}. {document['seconds'] / 60:.1f} minutes."]
    parts.append(markdown_table(("figure", "value", "what it is"), figures))
    if any(document["rows"].get(name) for name in DRAWN):
        parts.append(f"![Rates over environments; time and memory over pedestrians]({NAME}.svg)")
    for name, title in TITLES.items():
        rows = document["rows"].get(name)
        if rows:
            parts += [f"## {title}", markdown_table(COLUMNS[name], [_CELLS[name](row) for row in rows])]
    return "\n\n".join(parts) + "\n"


def _environments(row: Mapping[str, Any]) -> list[str]:
    sizes = (memory(row), row["temporary_bytes"], row["state_bytes"], row["kept_bytes"])
    megabytes = [f"{size / 1e6:,.2f}" for size in sizes]
    rate, compiling = f"{row['env_steps_per_s']:,}", f"{row['compile_s']:.1f}"
    return [f"{row['environments']:,}", row["observations"], rate, *megabytes, compiling]


def _training(row: Mapping[str, Any]) -> list[str]:
    name = row["recipe"] + (", the car alone" if row["single_agent"] else "")
    rates = [f"{row[x]:,.0f}" for x in ("train_steps_per_s", "agent_transitions_per_s")]
    return [
        name, f"{row['environments']:,} x {row['steps']:,}", *rates, f"{row['flops'] / 1e9:,.1f}",
        f"{row['first_update_s']:.1f}",
    ]  # fmt: skip


def _crowd(row: Mapping[str, Any]) -> list[str]:
    each = row["temporary_bytes"] / row["environments"] / 1e3
    return [f"{row['pedestrians']}", f"{microseconds(row):.2f}", f"{each:.2f}", f"{row['compile_s']:.1f}"]


def _products(row: Mapping[str, Any]) -> list[str]:
    return [f"{row['side']:,} x {row['side']:,}", row["precision"], f"{row['flops'] / 1e9:,.1f}"]


def _streets(row: Mapping[str, Any]) -> list[str]:
    speed, size = median(row["env_steps_per_s"]), row["bytes_per_street"] / 1e3
    return [row["observations"], f"{row['streets']}", f"{speed:,.0f}", f"{size:,.0f}"]


def _in_turns(row: Mapping[str, Any]) -> list[str]:
    return [row["recipe"], f"{median(row['train_steps_per_s']):,.0f}"]


def _suites(row: Mapping[str, Any]) -> list[str]:
    speed, share = median(row["env_steps_per_s"]), quantile(np.array(row["share_of_paper"]), 0.5)
    ends = ", ".join("none" if end is None else f"{100 * end:.1f}" for end in (share.low, share.high))
    of_paper = f"{100 * median(row['share_of_paper']):.1f} % [{ends}]"
    return [row["suite"], f"{row['pedestrians']}", f"{speed:,.0f}", of_paper]


_CELLS = {
    "env": _environments, "training": _training, "pedestrians": _crowd, "products": _products, "streets": _streets,
    "train-streets": _in_turns, "suites": _suites,
}  # fmt: skip
TITLES = {
    "env": "The simulator alone, over environments",
    "training": "Training",
    "pedestrians": "The simulator alone, over pedestrians",
    "products": "Matrix products",
    "streets": "The simulator alone, over generated streets, in turns",
    "train-streets": "Trainings on one street and on many, in turns",
    "suites": "The simulator alone, in worlds and on streets of suites, in turns",
}
"""Title of each list of rows."""
