"""How bad contacts are, over training seeds and against another driver: the fastest ones, and who is injured."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.evaluation.training_seeds import Match, matched
from jaxwalk.metrics import FEWEST_SEEDS, Estimate, OverSeeds, Rows, crossed_mean, over_seeds
from jaxwalk.metrics.expected_injuries import PER, expected_injuries
from jaxwalk.metrics.impact_tail import impact_speeds, tail_mean, tail_parts
from jaxwalk.metrics.statistics import mean_of

Harm = Literal["worst hundredth", "serious injuries"]
"""``worst hundredth``: mean speed of the car in the contacts of the worst hundredth of the scenarios
(`jaxwalk.metrics.impact_tail`) [m/s]. ``serious injuries``: those to be expected in 1,000 scenarios
(`jaxwalk.metrics.expected_injuries`), by the footprint."""


def injuries(rows: Rows) -> Float[np.ndarray, "scenario"]:
    """Return the serious injuries to be expected in 1,000 scenarios like each of these."""
    return PER * expected_injuries(rows, "footprint")


PARTS: dict[Harm, Callable[[Rows], Float[np.ndarray, "scenario"]]] = {
    "worst hundredth": lambda rows: tail_parts(impact_speeds(rows)),
    "serious injuries": injuries,
}
"""What each scenario adds to the number: the number is their mean."""
OF_ONE: dict[Harm, Callable[[Rows], Estimate]] = {
    "worst hundredth": lambda rows: tail_mean(impact_speeds(rows)),
    "serious injuries": lambda rows: mean_of(injuries(rows), within=(0.0, math.inf)),
}
"""The number of a single driver, with its interval over scenarios."""


@dataclass(frozen=True)
class SeedHarm:
    """How bad the contacts of one driver among one population are."""

    harm: Harm
    driver: str
    pedestrians: str
    training_seeds: tuple[int | None, ...]
    """None where nothing was trained."""
    number: OverSeeds


@dataclass(frozen=True)
class PairedHarm:
    """How much worse B's contacts are than A's, on the same scenarios."""

    harm: Harm
    a: str
    b: str
    pedestrians: str
    training_seeds: int
    difference: Interval
    """The number of B minus that of A."""
    p: float | None
    """The p-value of the t-test over training seeds that there is no difference; None if it can't be judged."""


def seed_harms(harm: Harm, matches: Sequence[Match]) -> tuple[SeedHarm, ...]:
    """Return the numbers of each driver and population; none below `FEWEST_SEEDS` seeds has an interval over seeds."""
    groups: dict[tuple[str, str], list[Match]] = {}
    for match in matches:
        groups.setdefault(match.names, []).append(match)
    return tuple(
        SeedHarm(harm, *names, tuple(match.cell.training_seed for match in group), _over_seeds(harm, group))
        for names, group in groups.items()
    )


def paired_harm(harm: Harm, a: Sequence[Match], b: Sequence[Match]) -> PairedHarm:
    """Compare A's and B's contacts; the interval is that of `crossed_mean` of the differences of their parts.

    Neither interval nor p-value with fewer training seeds than `FEWEST_SEEDS`, or where nothing differs. Raises
    ValueError as `jaxwalk.evaluation.paired_over_seeds` does.
    """
    a, b = matched(a, b)
    more = _parts(harm, b) - _parts(harm, a)
    found = crossed_mean(more) if len(a) >= FEWEST_SEEDS else None
    ends, p = (None, None), None
    if found is not None and found.error > 0:
        ends, p = found.ends(), found.p()
    return PairedHarm(
        harm=harm,
        a=a[0].cell.driver,
        b=b[0].cell.driver,
        pedestrians=a[0].cell.pedestrians,
        training_seeds=len(a),
        difference=Interval(float(more.mean()), *ends),
        p=p,
    )


def _over_seeds(harm: Harm, group: Sequence[Match]) -> OverSeeds:
    """Return the mean over seeds; a single match keeps its interval over scenarios. No number is below 0."""
    if len(group) == 1:
        one = OF_ONE[harm](group[0].rows)
        return OverSeeds(Estimate(one.value, one.low, one.high, 1), one.value, (one.value,))
    parts = _parts(harm, group)
    found = over_seeds(parts, np.ones(parts.shape))
    low = None if found.mean.low is None else max(found.mean.low, 0.0)
    return OverSeeds(Estimate(found.mean.value, low, found.mean.high, found.mean.count), found.iqm, found.each)


def _parts(harm: Harm, matches: Sequence[Match]) -> Float[np.ndarray, "seed scenario"]:
    """Return what each scenario adds to each seed's number."""
    return np.stack([PARTS[harm](match.rows) for match in matches])
