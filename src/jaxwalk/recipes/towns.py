"""The recipes ``town`` and ``blind-corner``: many generated streets, where everybody is seen or many are hidden.

``docs/recipes.md`` gives a reason for what differs.

Numbers that aren't named here are those of ``fast``. What car and critics see has the same size whatever the street and
the number of people, and nothing in it tells where on a street the car is.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from jaxwalk.recipes.fast import FAST
from jaxwalk.sim.sim_config import WORLDS

_FAST = FAST.train.roles

TOWN: Final = replace(
    FAST,
    recipe="town",
    train=replace(
        FAST.train,
        roles={**_FAST, "driver": replace(_FAST["driver"], critic_observes=("route-footprint",))},
        updates=1000,
    ),
    maps=("training:64",),
    sim=WORLDS["town"],
    crowds=(12, 3, 72, 36),
)

BLIND_CORNER: Final = replace(
    TOWN,
    recipe="blind-corner",
    maps=("parked-training:64",),
    sim=WORLDS["blind-corner"],
    crowds=(48, 12, 72, 24),
)
