"""Options of the command that measures speed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from jaxwalk.cli.options.declare import Flag, option

BenchPart = Literal["env", "train", "compile", "pedestrians", "streets", "suites"]
"""What `jaxwalk bench` can measure."""


@dataclass(frozen=True)
class Bench:
    """How fast is jaxwalk on this machine? Simulator, training, first minute, crowds, streets, suites: some minutes.

    For example: jaxwalk bench --out bench
    """

    only: Annotated[tuple[BenchPart, ...], option("all", "PART [PART ...]")] = ()
    """env: the simulator alone; train: training and the machine's peak; compile: the first minute; pedestrians: the
    cost of a crowd; streets: the cost of many streets; suites: the cost of worlds where people can be hidden."""
    quick: Flag = False
    """Few sizes and short times: checks that everything can be measured, without precise numbers."""
    environments: Annotated[tuple[int, ...], option("64 to 16384", "N [N ...]")] = ()
    """Numbers of environments for the simulator alone, a row each."""
    training_environments: Annotated[tuple[int, ...], option("128 512 2048", "N [N ...]")] = ()
    """Numbers of environments for training with the recipe fast, a row each."""
    pedestrians: Annotated[tuple[int, ...], option("12 24 48 96", "N [N ...]")] = ()
    """Numbers of people in an episode, a row each."""
    seconds: Annotated[float | None, option("3", "S")] = None
    """Time to measure each row, without compiling."""
    chunk_rows: Annotated[int | None, option("the recipe's; on an accelerator a whole minibatch", "N")] = None
    """Rows whose gradient is taken at once in training."""
    plan: Annotated[Literal["h100", "here"] | None, option("none: this machine is measured", "{h100,here}")] = None
    """Compile for this GPU without having one: launches and waits a step, memory, predicted speed (minutes).
    With 'here' for this machine's GPU, on which the programs then run: the measured speed, too."""
    seed: Annotated[int, option("0", "N")] = 0
    """Seed of scenarios, networks and actions."""
    out: Annotated[Path | None, option("none", "DIR")] = None
    """Folder for bench.json, bench.md, scaling.svg and scaling.png, or plan.json; earlier files are replaced."""
    json: Flag = False
    """Print one JSON document instead of the table."""
