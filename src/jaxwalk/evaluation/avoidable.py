"""Numbers about replayed collisions: who, and what driver in the car's place, could have avoided them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Shaped

from jaxwalk.evaluation.counterfactual import CHANGES, JUDGEMENTS, LABELS, Counterfactuals
from jaxwalk.metrics import Estimate, Rate, proportion
from jaxwalk.metrics.outcomes import SIDEWALK
from jaxwalk.metrics.statistics import quantile
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK


@dataclass(frozen=True)
class Judged:
    """Shares of collisions by the driver who would have avoided them in the car's place."""

    human: Rate
    """A careful human would have."""
    oracle: Rate
    """A careful human would not, but one who knows the future, or brakes fully at once, would have."""
    unavoidable: Rate
    """Neither."""


@dataclass(frozen=True)
class Avoidable:
    """Who could have avoided a group of replayed collisions."""

    collisions: int
    labels: Mapping[str, Rate]
    """The share of each of `LABELS`."""
    judged: Judged
    """With others at the wheel from when the car first perceived the pedestrian."""
    judged_from_start: Judged
    """The same with others at the wheel all the way."""
    seen_for: Estimate
    """Median of the time from that moment to the collision [s]."""
    avoided: Mapping[str, Rate]
    """For each of `CHANGES`, the share of collisions that it avoids among those to which it applies."""


@dataclass(frozen=True)
class CounterfactualSummary:
    """Shares of the replayed collisions, with `proportion`'s intervals; None: a number that does not exist."""

    collisions: int
    """All collisions of the evaluation, replayed or not."""
    replayed: int
    all: Avoidable
    moving: Avoidable
    """Those in which the car was moving."""
    crosswalk: Avoidable
    jaywalk: Avoidable
    sidewalk: Avoidable

    @property
    def preventable(self) -> Rate:
        """The share of the replayed collisions that a careful human would have avoided, once the person was seen."""
        return self.all.judged.human

    def as_dict(self) -> dict[str, Any]:
        """Return plain nested dicts, numbers and None: ready for JSON."""
        return asdict(self)


def summarise_counterfactuals(table: Counterfactuals) -> CounterfactualSummary:
    """Return who could have avoided the collisions, in total and by contact type."""
    return CounterfactualSummary(
        collisions=table.collisions,
        replayed=len(table.scenario),
        all=_avoidable(table, table.contact > 0),
        moving=_avoidable(table, table.moving),
        crosswalk=_avoidable(table, table.contact == CROSSWALK),
        jaywalk=_avoidable(table, table.contact == JAYWALK),
        sidewalk=_avoidable(table, table.contact == SIDEWALK),
    )


def _avoidable(table: Counterfactuals, mine: Bool[np.ndarray, "collision"]) -> Avoidable:
    """Summarise the collisions selected by ``mine``."""
    avoided = {}
    for change in CHANGES:
        applies = mine & getattr(table, f"{change}_applies", True)
        avoided[change] = proportion((getattr(table, change) & applies).sum(), applies.sum())
    return Avoidable(
        collisions=int(mine.sum()),
        labels=_shares(table.label[mine], LABELS),
        judged=Judged(**_shares(table.judged[mine], JUDGEMENTS)),
        judged_from_start=Judged(**_shares(table.judged_from_start[mine], JUDGEMENTS)),
        seen_for=quantile(table.seen_for[mine], 0.5),
        avoided=avoided,
    )


def _shares(answers: Shaped[np.ndarray, "collision"], names: Sequence[str]) -> dict[str, Rate]:
    """Return the share of each name among the answers."""
    return {name: proportion((answers == name).sum(), len(answers)) for name in names}
