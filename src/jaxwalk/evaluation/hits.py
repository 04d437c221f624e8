"""The collisions of an evaluation, found in its rows: who was touched, when, and since when they were on the road."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Int, Shaped

from jaxwalk.metrics import CROSSINGS, OUTCOMES, Rows

LEAD = 3.0
"""A person hit on a sidewalk entered no road: the driver's action changes this long before, or from the start [s]."""


@dataclass(frozen=True)
class Hits:
    """Collisions of an evaluation, one row each."""

    collisions: int
    """All collisions of the evaluation, selected or not."""
    dt: float
    """Duration of a step [s]."""
    scenario: Int[np.ndarray, "collision"]
    steps: Int[np.ndarray, "collision"]
    """Frame of the contact."""
    ped: Int[np.ndarray, "collision"]
    """The pedestrian touched (the nearest if there are several)."""
    contact: Int[np.ndarray, "collision"]
    moving: Bool[np.ndarray, "collision"]
    entered: Bool[np.ndarray, "collision"]
    """Whether the pedestrian was hit on a roadway, and had entered it after frame 0."""
    start: Int[np.ndarray, "collision"]
    """Frame of the road entry; if hit on a sidewalk, the frame from which the driver's action changes."""

    def some(self, rows: slice | Shaped[np.ndarray, "row"]) -> Hits:
        """Return the rows selected by a slice, indices or a mask."""
        columns = {name: x[rows] for name, x in vars(self).items() if isinstance(x, np.ndarray)}
        return replace(self, **columns)

    def first(self, count: int | None) -> Hits:
        """Return the first ``count`` collisions, or all if it is None. Raise ValueError if it is negative."""
        if (count or 0) < 0:
            raise ValueError(f"the number of collisions must be 0 or more, not {count}")
        return self.some(slice(count))

    def among(self, scenarios: Collection[int]) -> Hits:
        """Return the collisions in the scenarios with these numbers."""
        return self.some(np.isin(self.scenario, list(scenarios)))


def find_hits(rows: Rows) -> Hits:
    """Return the collisions of an evaluation, in the order of its episodes."""
    table, crossings = rows[OUTCOMES], rows[CROSSINGS]
    whose = crossings.episode
    hit = (crossings.ped == table.contact_ped[whose]) & (crossings.last == table.steps[whose])
    enter = np.full(len(table.steps), -1)
    enter[whose[hit]] = crossings.enter[hit]
    earlier = np.maximum(table.steps - round(LEAD / rows.dt), 0)
    every = Hits(
        collisions=int(table.collision.sum()),
        dt=rows.dt,
        scenario=table.scenario,
        steps=table.steps,
        ped=table.contact_ped,
        contact=table.contact,
        moving=table.moving,
        entered=enter > 0,
        start=np.where(enter >= 0, enter, earlier),
    )
    return every.some(table.collision)
