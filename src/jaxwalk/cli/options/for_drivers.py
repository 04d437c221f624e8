"""Options of the commands for people who write their own drivers or use a trained one elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import tyro

from jaxwalk.cli.options.declare import option

Role = Literal["driver", "pedestrian"]


@dataclass(frozen=True)
class Export:
    """Write a trained policy as ONNX, for other runtimes, after checking that both act the same.

    For example: jaxwalk export runs/first --out driver.onnx
    """

    policy: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="POLICY")] = field()
    """A run folder, a policy file, or a trained policy that comes with jaxwalk (co-trained, single-agent, learned)."""
    out: Annotated[Path | None, option("needed", "FILE")] = None
    """FILE.onnx; an existing one is replaced."""
    role: Annotated[Role, option("driver", "ROLE")] = "driver"
    """Whose network: driver or pedestrian."""


@dataclass(frozen=True)
class Observations:
    """List the observation sets of a driver or a pedestrian: the place of each part, and what 1 stands for in it."""

    role: Annotated[Role, option("driver", "ROLE")] = "driver"
    """Whose: driver or pedestrian."""
