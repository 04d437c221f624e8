"""The recipe ``blind-corner-cvar``: ``blind-corner`` with a limit of the speed in the contacts of the worst episodes.

``docs/recipes.md`` gives a reason for every number, ``docs/learning.md#limits`` the formulas.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from jaxwalk.learning.config import CostLimit
from jaxwalk.recipes.experiment import Experiment, with_limits
from jaxwalk.recipes.towns import BLIND_CORNER

BLIND_CORNER_CVAR: Final[Experiment] = replace(
    with_limits(BLIND_CORNER, CostLimit("impact_speed", limit=5.0, tail=0.99, worth=0.01)),
    recipe="blind-corner-cvar",
)
