"""Options of the command that sweeps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

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
    example: Flag = False
    """Print an example of a file, and do nothing else."""
