"""Results of policies trained with several seeds: numbers over the seeds, and pairs of the same scenarios."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from jaxwalk.evaluation.comparison import paired
from jaxwalk.evaluation.document_parts import Interval, PairedSeeds, PairedSide, SeedNumbers
from jaxwalk.evaluation.results import Cell
from jaxwalk.metrics import ATTRIBUTION, OUTCOMES, Estimate, OverSeeds, Rate, Rows, Summary, over_seeds
from jaxwalk.metrics.statistics import FEWEST_SEEDS


@dataclass(frozen=True)
class Match:
    """One driver among one population: the numbers, and the rows that they come from."""

    cell: Cell
    rows: Rows

    @property
    def names(self) -> tuple[str, str]:
        """Names of the driver and of the population."""
        return self.cell.driver, self.cell.pedestrians


@dataclass(frozen=True)
class SeedRatio:
    """A number that is computed over training seeds: a ratio of two sums over episodes."""

    of_one: Callable[[Summary], Rate | Estimate]
    """The number for a single cell."""
    parts: Callable[[Rows], tuple[np.ndarray, np.ndarray]]
    """Its numerators and denominators, one pair per episode."""


def _rate(ending: Callable[[Rows], np.ndarray]) -> Callable[[Rows], tuple[np.ndarray, np.ndarray]]:
    return lambda rows: (ending(rows), np.ones(rows.episodes))


SEED_RATIOS: dict[str, SeedRatio] = {
    "goal_rate": SeedRatio(lambda s: s[OUTCOMES].goal, _rate(lambda rows: rows[OUTCOMES].goal)),
    "collision_rate": SeedRatio(lambda s: s[OUTCOMES].collision, _rate(lambda rows: rows[OUTCOMES].collision)),
    "timeout_rate": SeedRatio(
        lambda s: s[OUTCOMES].timeout, _rate(lambda rows: ~rows[OUTCOMES].goal & ~rows[OUTCOMES].collision)
    ),
    "collisions_per_km": SeedRatio(
        lambda s: s[OUTCOMES].all.per_km, lambda rows: (rows[OUTCOMES].collision, rows[OUTCOMES].driven / 1000)
    ),
    "mean_time_to_goal": SeedRatio(
        lambda s: s[OUTCOMES].time_to_goal,
        lambda rows: (rows[OUTCOMES].goal * rows[OUTCOMES].steps * rows.dt, rows[OUTCOMES].goal),
    ),
    "jaywalk_share": SeedRatio(
        lambda s: s[ATTRIBUTION].per_crossing.share,
        lambda rows: (rows[ATTRIBUTION].crossings[:, 1], rows[ATTRIBUTION].crossings.sum(axis=1)),
    ),
}
"""Numbers over training seeds, by their names in `SeedNumbers`."""


def over_training_seeds(matches: Sequence[Match]) -> tuple[SeedNumbers, ...]:
    """Return the numbers over training seeds for each driver, population and jaywalk multiplier."""
    groups: dict[tuple[str, str, float], list[Match]] = {}
    for match in matches:
        groups.setdefault((*match.names, match.cell.jaywalk_multiplier), []).append(match)
    return tuple(
        SeedNumbers(
            driver=driver,
            pedestrians=pedestrians,
            jaywalk_multiplier=multiplier,
            training_seeds=tuple(match.cell.training_seed for match in group),
            **{name: _over_seeds(ratio, group) for name, ratio in SEED_RATIOS.items()},
        )
        for (driver, pedestrians, multiplier), group in groups.items()
    )


def _over_seeds(ratio: SeedRatio, group: list[Match]) -> OverSeeds:
    """Return one number over seeds.

    A single cell keeps its own interval over scenarios. So do rates that are 0 or 1 in every cell: a bootstrap of equal
    values has no width.
    """
    number = ratio.of_one(group[0].cell.summary)
    each = tuple(ratio.of_one(match.cell.summary).value for match in group)
    never_or_always = len(group) >= FEWEST_SEEDS and set(each) in ({0.0}, {1.0})
    if len(group) == 1 or never_or_always:
        same = Estimate(number.value, number.low, number.high, len(group))
        return OverSeeds(same, same, each)
    over, under = zip(*(ratio.parts(match.rows) for match in group), strict=True)
    return over_seeds(np.stack(over), np.stack(under))


Ending = Literal["collision", "goal"]
ENDINGS: tuple[Ending, ...] = ("collision", "goal")
"""The endings of episodes that are compared."""


def paired_over_seeds(ending: Ending, a: Sequence[Match], b: Sequence[Match]) -> PairedSeeds:
    """Compare how often A and B have this ending on the same scenarios: the pairs of all training seeds together.

    Pair (seed, scenario) has that seed's A and B; if nothing was trained, the only match stands for every seed. The
    exact McNemar test assumes independent pairs: it concerns these particular policies. The interval of the difference
    resamples seeds and scenarios (`jaxwalk.metrics.over_seeds`), so it also covers training with other seeds.

    Raises:
        ValueError: A and B have different training seeds, or the same ones in another order, or they did not play the
            same scenarios.
    """
    seeds = max(len(a), len(b))
    _check_seeds_agree(a, b)
    a, b = (list(side) * (seeds // len(side)) for side in (a, b))
    joined = [Rows.join([match.rows for match in side]) for side in (a, b)]
    pairs = paired(*joined)
    found = pairs.goal if ending == "goal" else pairs.collision
    ends_a, ends_b = (np.stack([_ended(match.rows, ending) for match in side]) for side in (a, b))
    return PairedSeeds(
        ending=ending,
        a=PairedSide(*a[0].names, rate=float(ends_a.mean())),
        b=PairedSide(*b[0].names, rate=float(ends_b.mean())),
        training_seeds=seeds,
        pairs=ends_a.size,
        both=found.both,
        only_a=found.only_a,
        only_b=found.only_b,
        difference=Interval.of(over_seeds(ends_b - ends_a, np.ones_like(ends_a)).mean),
        p=found.p,
    )


def _check_seeds_agree(a: Sequence[Match], b: Sequence[Match]) -> None:
    """Raise ValueError unless a side has a single match, or both sides have the same training seeds in one order."""
    of_a, of_b = ([match.cell.training_seed for match in side] for side in (a, b))
    if min(len(of_a), len(of_b)) != 1 and of_a != of_b:
        raise ValueError(f"A has the training seeds {of_a} and B {of_b}; only matches with equal seeds can be paired")


def _ended(rows: Rows, ending: str) -> np.ndarray:
    """Return 1.0 for each episode with this ending, else 0.0."""
    return (rows[OUTCOMES].goal if ending == "goal" else rows[OUTCOMES].collision).astype(float)
