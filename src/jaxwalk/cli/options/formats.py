"""Commands for those who bring a driver, or take one away."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import tyro

from jaxwalk.cli.options.option import option

Role = Literal["driver", "pedestrian"]


@dataclass(frozen=True)
class Export:
    """Write a trained policy as ONNX, for other runtimes, after comparing what both do.

    For example: jaxwalk export runs/first --out driver.onnx
    """

    policy: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="POLICY")] = field()
    """A run folder, a policy file, or a trained policy that comes with jaxwalk (co-trained, single-agent, learned)."""
    out: Annotated[Path | None, option("needed", "FILE")] = None
    """FILE.onnx; an existing one is replaced."""
    role: Annotated[Role, option("driver", "ROLE")] = "driver"
    """Whose network: driver or pedestrian."""

    def run(self) -> int:
        """Do it."""
        from jaxwalk.cli.formats import export

        return export(self)


@dataclass(frozen=True)
class Observations:
    """What a driver or a pedestrian can be shown: the observation sets, and where each part stands in them."""

    role: Annotated[Role, option("driver", "ROLE")] = "driver"
    """Whose: driver or pedestrian."""

    def run(self) -> int:
        """Do it."""
        from jaxwalk.cli.formats import observations

        return observations(self)
