"""The plan of a GPU: programs compiled for it (`gpu_programs`), and the speeds that follow from them.

This module imports no JAX: the programs are compiled in a process of their own, in which JAX knows no other device than
a GPU of this machine or, for one that is only described, a processor core.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from rich.box import SIMPLE
from rich.console import Group
from rich.table import Table

from jaxwalk.bench.benchmark_settings import HERE, Settings
from jaxwalk.bench.processes import BenchmarkError, measure_apart
from jaxwalk.writing import write_whole

SCHEMA = 1
"""Version of the document; it changes when the meaning of a name in it changes."""
NEEDED = ("jax-cuda13-plugin", "jax-cuda13-pjrt", "nvidia-nvvm", "nvidia-cuda-nvcc")
"""Packages that compile for NVIDIA GPUs; the first two have JAX's own version."""
ALONE = {
    "JAX_PLATFORMS": "cpu",
    "JAX_NUM_CPU_DEVICES": "1",
    "JAX_ENABLE_COMPILATION_CACHE": "false",
    "JAX_DISABLE_MOST_OPTIMIZATIONS": "false",
}
"""Environment variables of the process that compiles: a GPU in this machine stays unused."""
UNCACHED = {name: value for name, value in ALONE.items() if name.startswith(("JAX_ENABLE", "JAX_DISABLE"))}
"""Those of the process that measures this machine's GPU: a program from the cache has no files to read."""
LAUNCH_US = (2.0, 3.0)
"""Time that a launch takes, on a quick and on a slow host [us]."""
WAIT_US = 10.0
"""Time that the host and the GPU lose when one waits for the other [us]."""
ASSUMPTIONS = (
    f"a launch takes {LAUNCH_US[0]:g} to {LAUNCH_US[1]:g} us, one after the other",
    f"a host synchronisation takes {WAIT_US:g} us",
    "kernels take the time of XLA's model, in proportion to the number of environments, besides their launches",
    "a data-dependent loop makes one turn",
    "steps in which an ended episode waits for its restart count",
)
"""What predictions assume."""


class PlanError(BenchmarkError):
    """Programs can't be compiled for a GPU here. The message says what to install, in one line."""


def check_compiler() -> None:
    """Raise PlanError, which says what to install, if programs can't be compiled for a GPU."""
    found = {name: _version(name) for name in ("jax", *NEEDED)}
    wanted = [f"{name}=={found['jax']}" if name.startswith("jax-") else name for name in NEEDED]
    lacking = [name for name in NEEDED if not found[name] or (name.startswith("jax-") and found[name] != found["jax"])]
    if lacking:
        raise PlanError(
            f"--plan needs {', '.join(lacking)}, to compile for a GPU (none is needed); in an environment of its own: "
            f"pip install {' '.join(wanted)}"
        )


def planned(settings: Settings) -> dict[str, Any]:
    """Compile the programs and return the document. Raise PlanError if a package or the GPU is missing."""
    here = settings.plan == HERE
    check_gpu(settings) if here else check_compiler()
    found = measure_apart("plan", settings, UNCACHED if here else ALONE)
    rows = found.pop("programs")
    return {
        "schema": SCHEMA,
        "options": asdict(settings),
        **found,
        "assumptions": list(ASSUMPTIONS),
        "programs": rows,
        "predictions": [
            predicted(row, count)
            for row in rows
            for count in ((row["environments"],) if here else settings.environments)
        ],
    }


def check_gpu(settings: Settings) -> None:
    """Raise PlanError unless JAX sees a GPU in this machine."""
    platform = measure_apart("machine", settings)["hardware"]["platform"]
    if platform != "gpu":
        raise PlanError(
            f"--plan {HERE} measures programs on this machine's GPU, and JAX sees none (only: {platform}); "
            "install jaxwalk[cuda], or plan for a GPU that is elsewhere: --plan h100"
        )


def predicted(row: Mapping[str, Any], environments: int) -> dict[str, Any]:
    """Return the predicted speed of a program with another number of environments, by `ASSUMPTIONS` [steps/s]."""
    modelled = row["microseconds_per_step"] * environments / row["environments"]
    waits = WAIT_US * row["synchronisations_per_step"]
    best, worst = (environments / (each * row["launches_per_step"] + waits + modelled) * 1e6 for each in LAUNCH_US)
    return {
        "program": row["program"],
        "recipe": row["recipe"],
        "environments": environments,
        "steps_per_s": [round(worst), round(best)],
        "measured_steps_per_s": row.get("measured_steps_per_s"),
        "memory_bytes": round(row["memory_bytes"] * environments / row["environments"]),
    }


def write_plan(folder: Path, text: str) -> None:
    """Write plan.json."""
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / "plan.json", text)


def plan_tables(document: Mapping[str, Any]) -> Group:
    """Return the document as tables for a terminal."""
    return Group(_programs(document), _parts(document), _predictions(document))


def _programs(document: Mapping[str, Any]) -> Table:
    made = document["provenance"]
    versions = ", ".join(f"{name} {made['versions'][name]}" for name in ("jax", "jaxlib"))
    whose = "this machine's" if document["options"]["plan"] == HERE else "a described"
    origin = f"Compiled for {whose} {document['device']}; commit {made['commit'] or 'unknown'}; {versions}"
    names = ("launches", "copies", "waits", "modelled us", "memory [MB]", "compiled [s]")
    each = "For each step of all environments; copies are launches too, and waits are the host's"
    caption = f"{each}; programs compiled side by side. {origin}."
    drawn = _table(("program", "recipe", "size"), names, caption)
    for row in document["programs"]:
        amounts = (row[f"{x}_per_step"] for x in ("launches", "copies", "synchronisations", "microseconds"))
        cells = (*(f"{x:,.2f}" for x in amounts), f"{row['memory_bytes'] / 1e6:,.1f}", f"{row['compile_s']:.0f}")
        drawn.add_row(row["program"], row["recipe"], f"{row['environments']:,} x {row['steps']}", *cells)
    return drawn


def _parts(document: Mapping[str, Any]) -> Table:
    caption = "Where they are: the methods of the street; rest: restarts, copies for loops, acting, learning."
    drawn = _table(("program", "recipe", "part"), ("launches", "modelled us"), caption)
    for row in document["programs"]:
        for part, launches in row["launches_by_part"].items():
            time = row["microseconds_by_part"].get(part, 0.0)
            drawn.add_row(row["program"], row["recipe"], part, f"{launches:,.2f}", f"{time:,.2f}")
    return drawn


def _predictions(document: Mapping[str, Any]) -> Table:
    truth = any(row["measured_steps_per_s"] for row in document["predictions"])
    names = ("environments", "predicted steps/s", *(["measured steps/s"] if truth else []), "memory [GB]")
    caption = f"Predicted{'' if truth else ', not measured'}: {'; '.join(document['assumptions'])}."
    drawn = _table(("program", "recipe"), names, caption)
    for row in document["predictions"]:
        rates = " to ".join(f"{rate:,}" for rate in row["steps_per_s"])
        measured = [f"{row['measured_steps_per_s']:,}"] if truth else []
        cells = (f"{row['environments']:,}", rates, *measured, f"{row['memory_bytes'] / 1e9:,.2f}")
        drawn.add_row(row["program"], row["recipe"], *cells)
    return drawn


def _table(left: tuple[str, ...], right: tuple[str, ...], caption: str) -> Table:
    drawn = Table(*left, box=SIMPLE, padding=(0, 1), caption=caption, caption_justify="left")
    for name in right:
        drawn.add_column(name, justify="right")
    return drawn


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
