"""The recipe ``blind-corner-lagrangian``: ``blind-corner`` with limits of contacts and of time in which one is near.

``docs/recipes.md`` gives a reason for every number, ``docs/learning.md#limits`` the formulas.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from jaxwalk.learning.config import CostLimit
from jaxwalk.recipes.experiment import Experiment, with_limits
from jaxwalk.recipes.towns import BLIND_CORNER

BLIND_CORNER_LAGRANGIAN: Final[Experiment] = replace(
    with_limits(
        BLIND_CORNER,
        CostLimit("contact", limit=0.01, worth=15.0),
        CostLimit("critical_time", limit=0.1, worth=1.5),
    ),
    recipe="blind-corner-lagrangian",
)
