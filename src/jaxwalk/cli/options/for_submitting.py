"""The options of the command that checks entries of a leaderboard."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from jaxwalk.cli.options.declare import Flag, option


@dataclass(frozen=True)
class Submit:
    """Check entries of a leaderboard, and show them side by side.

    An entry is a folder with README.md (what the driver is), the driver's files, and results.json, which
    jaxwalk evaluate --driver policy.safetensors --out . writes, called in that folder, on 2,000 scenarios or more.
    --check evaluates it again as its author did, and on fresh scenarios, whose seed follows from the files of the
    entry. So that seed isn't secret: an author can change a file until it suits. With --salt no author can know it
    (docs: leaderboard). An entry that can't be used is listed with the reason, and the others go on; the exit code is
    2 then.

    For example: jaxwalk submit zoo/mine --check, and then jaxwalk submit zoo/* --out leaderboard.md
    """

    entries: Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="FOLDER [FOLDER ...]")] = ()
    """Folders of entries."""
    check: Flag = False
    """Evaluate each entry, and write checked.json into its folder; exit code 1 if one doesn't come out again. The
    driver's own code runs, with your rights."""
    salt: Annotated[str | None, option("none", "TEXT")] = None
    """The seed of fresh scenarios follows from this text too. Give a long random one, keep it secret, and give the same
    one to show the leaderboard: a check with another salt, or without one, doesn't count."""
    out: Annotated[Path | None, option("none", "FILE")] = None
    """Write the leaderboard into this file (.md)."""
    trust: Flag = False
    """Also load drivers from files that can run any code when they are loaded (pickled Torch modules, SB3 agents)."""
    driver_seconds: Annotated[float, option("10", "S")] = 10.0
    """Time limit of a driver that is not JAX for one step of its batch."""
