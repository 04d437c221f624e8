"""Options of the command that sweeps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from jaxwalk.cli.options.declare import Flag, option


@dataclass(frozen=True)
class Sweep:
    """Many trainings from one file, which says what varies and what counts (docs: sweeps).

    For example: jaxwalk sweep study.toml --out runs/sweep. Run it again to continue after an interruption; in
    another terminal, or on another machine that has the folder, it takes a share of the work.
    """

    study: Annotated[Path | None, tyro.conf.Positional, option("none; needed unless --example", "FILE")] = None
    """The TOML file of the sweep."""
    out: Annotated[Path, option("runs/sweep", "DIR")] = Path("runs/sweep")
    """Folder for everything; open study.html in it."""
    on: Annotated[Literal["local", "slurm", "ray"], option("local")] = "local"
    """Where processes work on the sweep. local: here, one; slurm: jobs, submitted from a login node; ray: tasks on the
    cluster that RAY_ADDRESS names, or here. Slurm's jobs and Ray's machines need the same folder."""
    workers: Annotated[int, option("1", "N")] = 1
    """With slurm or ray: the number of processes."""
    cpus: Annotated[int, option("2", "N")] = 2
    """With slurm or ray: cores of each process."""
    gpus: Annotated[int, option("0", "N")] = 0
    """With slurm or ray: GPUs of each process."""
    slurm: Annotated[tuple[str, ...], option("none", "KEY=VALUE [KEY=VALUE ...]")] = ()
    """Further parameters of submitit, such as timeout_min=240 slurm_partition=long."""
    example: Flag = False
    """Print an example of a file, and do nothing else."""
