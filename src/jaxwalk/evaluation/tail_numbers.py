"""The car's speed in the contacts of the worst episodes, over training seeds and against another driver."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.evaluation.training_seeds import Match, matched
from jaxwalk.metrics import FEWEST_SEEDS, IMPACT_TAIL, Estimate, OverSeeds, crossed_mean, over_seeds
from jaxwalk.metrics.impact_tail import impact_speeds, tail_parts


@dataclass(frozen=True)
class SeedTail:
    """The worst contacts of one driver among one population."""

    driver: str
    pedestrians: str
    training_seeds: tuple[int | None, ...]
    """None where nothing was trained."""
    worst_hundredth: OverSeeds
    """`jaxwalk.metrics.impact_tail.ImpactTail.worst_hundredth` [m/s]."""


@dataclass(frozen=True)
class PairedTail:
    """How much faster B's worst contacts are than A's, on the same scenarios."""

    a: str
    b: str
    pedestrians: str
    training_seeds: int
    difference: Interval
    """Worst hundredth of B minus that of A [m/s]."""
    p: float | None
    """The p-value of the t-test over training seeds that there is no difference; None if it can't be judged."""


def seed_tails(matches: Sequence[Match]) -> tuple[SeedTail, ...]:
    """Return the numbers of each driver and population; none below `FEWEST_SEEDS` seeds has an interval over seeds."""
    groups: dict[tuple[str, str], list[Match]] = {}
    for match in matches:
        groups.setdefault(match.names, []).append(match)
    return tuple(
        SeedTail(*names, tuple(match.cell.training_seed for match in group), _over_seeds(group))
        for names, group in groups.items()
    )


def paired_tail(a: Sequence[Match], b: Sequence[Match]) -> PairedTail:
    """Compare the worst contacts of A and B; the interval is that of `crossed_mean` of the differences of their parts.

    Neither interval nor p-value with fewer training seeds than `FEWEST_SEEDS`, or where nothing differs. Raises
    ValueError as `jaxwalk.evaluation.paired_over_seeds` does.
    """
    a, b = matched(a, b)
    more = _parts(b) - _parts(a)
    found = crossed_mean(more) if len(a) >= FEWEST_SEEDS else None
    ends, p = (None, None), None
    if found is not None and found.error > 0:
        ends, p = found.ends(), found.p()
    return PairedTail(
        a=a[0].cell.driver,
        b=b[0].cell.driver,
        pedestrians=a[0].cell.pedestrians,
        training_seeds=len(a),
        difference=Interval(float(more.mean()), *ends),
        p=p,
    )


def _over_seeds(group: Sequence[Match]) -> OverSeeds:
    """Return the mean over seeds; a single match keeps its interval over scenarios. No speed is below 0."""
    if len(group) == 1:
        one = group[0].cell.summary[IMPACT_TAIL].worst_hundredth
        return OverSeeds(Estimate(one.value, one.low, one.high, 1), one.value, (one.value,))
    parts = _parts(group)
    found = over_seeds(parts, np.ones(parts.shape))
    low = None if found.mean.low is None else max(found.mean.low, 0.0)
    return OverSeeds(Estimate(found.mean.value, low, found.mean.high, found.mean.count), found.iqm, found.each)


def _parts(matches: Sequence[Match]) -> Float[np.ndarray, "seed scenario"]:
    """Return what each scenario adds to each seed's number."""
    return np.stack([tail_parts(impact_speeds(match.rows)) for match in matches])
