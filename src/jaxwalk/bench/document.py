"""All measurements as one document: options, hardware, provenance, figures, rows."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console

from jaxwalk.bench.benchmark_settings import PARTS, Settings
from jaxwalk.bench.drawing import draw
from jaxwalk.bench.processes import measure_apart
from jaxwalk.bench.quantities import figures
from jaxwalk.bench.showing import markdown
from jaxwalk.bench.starting import starts
from jaxwalk.writing import together, write_whole

SCHEMA = 1
"""Version of the document; it changes when the meaning of a name in it changes."""
TITLES = {
    "env": "the simulator alone",
    "train": "training, and the machine's peak",
    "compile": "the first minute",
    "pedestrians": "the cost of a crowd",
    "streets": "the cost of many streets",
    "suites": "the cost of suites",
}
"""Description of each part."""


def benchmark(settings: Settings, console: Console | None = None) -> dict[str, Any]:
    """Measure what the settings ask for; report progress on standard error."""
    console, begun = console or Console(stderr=True), time.monotonic()
    rows: dict[str, list[Any]] = {}
    chosen = [part for part in PARTS if part in settings.only]
    machine = measure_apart("machine", settings)
    devices = f"{machine['hardware']['devices']} devices of JAX"
    console.print(f"measuring on {machine['provenance']['hardware']}, {devices}", soft_wrap=True, highlight=False)
    for number, part in enumerate(chosen, 1):
        console.print(f"{number}/{len(chosen)} {TITLES[part]}", soft_wrap=True, highlight=False)
        rows |= MEASURES[part](settings)
    return {
        "schema": SCHEMA,
        "options": asdict(settings),
        **machine,
        "seconds": round(time.monotonic() - begun, 1),
        "figures": figures(rows),
        "rows": rows,
    }


def write(folder: Path, document: dict[str, Any]) -> None:
    """Write bench.json, bench.md and, if rates or a crowd were measured, scaling.svg and scaling.png."""
    folder.mkdir(parents=True, exist_ok=True)
    with together():
        write_whole(folder / "bench.json", as_text(document))
        write_whole(folder / "bench.md", markdown(document))
        draw(document["rows"], folder)


def as_text(document: dict[str, Any]) -> str:
    """Return the document as JSON."""
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _train(settings: Settings) -> dict[str, list[Any]]:
    """Measure both recipes, each in a process of its own."""
    found = [measure_apart(f"train-{recipe}", settings) for recipe in ("fast", "paper")]
    return {
        "training": [row for part in found for row in part["rows"]],
        "products": [row for part in found for row in part["products"]],
    }


def _starts(_: Settings) -> dict[str, list[Any]]:
    return {"starts": [{"name": name, "seconds": seconds} for name, seconds in starts().items()]}


def _streets(settings: Settings) -> dict[str, list[Any]]:
    return {part: measure_apart(part, settings) for part in ("streets", "train-streets")}


MEASURES: dict[str, Callable[[Settings], dict[str, list[Any]]]] = {
    "env": lambda settings: {"env": measure_apart("env", settings)},
    "train": _train,
    "compile": _starts,
    "pedestrians": lambda settings: {"pedestrians": measure_apart("pedestrians", settings)},
    "streets": _streets,
    "suites": lambda settings: {"suites": measure_apart("suites", settings)},
}
"""The function that measures each part and returns rows by name."""
