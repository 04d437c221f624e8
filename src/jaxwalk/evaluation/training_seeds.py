"""Results of policies trained with several seeds: numbers over the seeds, and pairs of the same scenarios."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from jaxtyping import Bool

from jaxwalk.evaluation.comparison import check_same_scenarios
from jaxwalk.evaluation.document_parts import Interval, PairedDelay, PairedSeeds, PairedSide, SeedNumbers
from jaxwalk.evaluation.results import Cell
from jaxwalk.metrics import (
    APPROACHES,
    ATTRIBUTION,
    DELAY,
    FEWEST_SEEDS,
    OUTCOMES,
    Estimate,
    OverSeeds,
    Rate,
    Rows,
    Summary,
    crossed_mean,
    mcnemar,
    over_seeds,
    paired_difference,
)
from jaxwalk.metrics.approaches import approach_columns
from jaxwalk.metrics.contacts import MEASURED_CONTACTS, touched_while_moving
from jaxwalk.metrics.delay import delays
from jaxwalk.metrics.over_seeds import Kind, crossed_ratio


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
    kind: Kind


def _rate(of_one: Callable[[Summary], Rate], ending: Callable[[Rows], np.ndarray]) -> SeedRatio:
    return SeedRatio(of_one, lambda rows: (ending(rows), np.ones(rows.episodes)), kind="share")


def _known(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return values with 0 for those that don't exist, and which do."""
    return np.nan_to_num(values), ~np.isnan(values)


def _approaches(rows: Rows) -> tuple[np.ndarray, np.ndarray]:
    """Return each episode's approaches in which somebody waited, and all."""
    found = approach_columns(rows)
    return found["waited"], found["approaches"]


SEED_RATIOS: dict[str, SeedRatio] = {
    "goal_rate": _rate(lambda s: s[OUTCOMES].goal, lambda rows: rows[OUTCOMES].goal),
    "collision_rate": _rate(lambda s: s[OUTCOMES].collision, lambda rows: rows[OUTCOMES].collision),
    "timeout_rate": _rate(lambda s: s[OUTCOMES].timeout, lambda rows: ~rows[OUTCOMES].goal & ~rows[OUTCOMES].collision),
    "moving_contact_rate": _rate(lambda s: s[MEASURED_CONTACTS].footprint.moving, touched_while_moving),
    "collisions_per_km": SeedRatio(
        lambda s: s[OUTCOMES].all.per_km, lambda rows: (rows[OUTCOMES].collision, rows[OUTCOMES].driven / 1000), "rate"
    ),
    "mean_time_to_goal": SeedRatio(
        lambda s: s[OUTCOMES].time_to_goal,
        lambda rows: (rows[OUTCOMES].goal * rows[OUTCOMES].steps * rows.dt, rows[OUTCOMES].goal),
        kind="mean",
    ),
    "mean_delay": SeedRatio(lambda s: s[DELAY].mean, lambda rows: _known(delays(rows)), kind="mean"),
    "jaywalk_share": SeedRatio(
        lambda s: s[ATTRIBUTION].per_crossing.share,
        lambda rows: (rows[ATTRIBUTION].crossings[:, 1], rows[ATTRIBUTION].crossings.sum(axis=1)),
        kind="share",
    ),
    "waited_share": SeedRatio(lambda s: s[APPROACHES].waited, _approaches, kind="share"),
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
    """Return one number over seeds; a single cell keeps its own interval over scenarios."""
    if len(group) == 1:
        number = ratio.of_one(group[0].cell.summary)
        return OverSeeds(Estimate(number.value, number.low, number.high, 1), number.value, (number.value,))
    over, under = zip(*(ratio.parts(match.rows) for match in group), strict=True)
    return over_seeds(np.stack(over), np.stack(under), kind=ratio.kind)


Ending = Literal["collision", "goal", "moving contact", "hit"]
"""What is compared: how episodes end, and in which the moving car touches somebody by its footprint. A hit is a
collision of the moving car."""
ENDINGS: tuple[Ending, ...] = ("collision", "goal")
"""The endings of episodes that reports compare."""


def paired_over_seeds(ending: Ending, a: Sequence[Match], b: Sequence[Match]) -> PairedSeeds:
    """Compare how often A and B have this ending on the same scenarios.

    One pair of policies has the exact McNemar test over scenarios. Several training seeds have a test over seeds
    (`jaxwalk.metrics.crossed_mean` of the differences): pairs of scenario and seed are not independent, and McNemar's
    test of all of them called drivers different in 42 % of simulations in which they were not. With fewer seeds than
    `FEWEST_SEEDS` there is neither interval nor p-value. If nothing was trained on one side, its only match stands for
    every seed.

    Raises:
        ValueError: A and B have different training seeds, or the same ones in another order, or they did not play the
            same scenarios.
    """
    a, b = matched(a, b)
    ends_a, ends_b = (np.stack([_ended(match.rows, ending) for match in side]) for side in (a, b))
    difference, p = _difference(ends_a, ends_b)
    return PairedSeeds(
        ending=ending,
        a=PairedSide(*a[0].names, rate=float(ends_a.mean())),
        b=PairedSide(*b[0].names, rate=float(ends_b.mean())),
        training_seeds=len(a),
        pairs=ends_a.size,
        both=int((ends_a & ends_b).sum()),
        only_a=int((ends_a & ~ends_b).sum()),
        only_b=int((ends_b & ~ends_a).sum()),
        difference=difference,
        p=p,
    )


def paired_delay(a: Sequence[Match], b: Sequence[Match]) -> PairedDelay:
    """Compare the delays of A and B on the scenarios in which both arrive.

    Neither interval nor p-value with fewer training seeds than `FEWEST_SEEDS`. Raises ValueError as
    `paired_over_seeds` does.
    """
    a, b = matched(a, b)
    later = np.stack([delays(of_b.rows) - delays(of_a.rows) for of_a, of_b in zip(a, b, strict=True)])
    over, under = _known(later)
    found = over_seeds(over, under)
    judged = found.mean.low is not None
    return PairedDelay(
        a=a[0].cell.driver,
        b=b[0].cell.driver,
        pedestrians=a[0].cell.pedestrians,
        training_seeds=len(a),
        pairs=int(under.sum()),
        difference=Interval.of(found.mean),
        p=crossed_ratio(over, under).p() if judged else None,
    )


def every_two(matches: Sequence[Match]) -> tuple[PairedSeeds, ...]:
    """Compare how often every two drivers hit somebody, among each population that both met.

    Raises ValueError as `paired_over_seeds` does.
    """
    groups: dict[tuple[str, str], list[Match]] = {}
    for match in matches:
        groups.setdefault(match.names, []).append(match)
    pairs = combinations(groups, 2)
    return tuple(paired_over_seeds("hit", groups[a], groups[b]) for a, b in pairs if a[1] == b[1])


def matched(a: Sequence[Match], b: Sequence[Match]) -> tuple[list[Match], list[Match]]:
    """Return both sides with equally many matches: the only one of a side stands for every training seed.

    Raises:
        ValueError: the sides have different training seeds, or did not play the same scenarios.
    """
    _check_seeds_agree(a, b)
    seeds = max(len(a), len(b))
    a, b = (list(side) * (seeds // len(side)) for side in (a, b))
    for of_a, of_b in zip(a, b, strict=True):
        check_same_scenarios(of_a.rows, of_b.rows)
    return a, b


def _difference(
    a: Bool[np.ndarray, "seed scenario"], b: Bool[np.ndarray, "seed scenario"]
) -> tuple[Interval, float | None]:
    """Return the rate of B minus that of A with its interval, and the p-value of the test that it is 0.

    Seeds that do not differ at all say no more than one of them: then the interval and test are those of one pair.
    """
    seeds = len(a)
    if 1 < seeds < FEWEST_SEEDS:
        return Interval(float(b.mean()) - float(a.mean()), None, None), None
    found = crossed_mean(b.astype(float) - a) if seeds > 1 else None
    if found is None or found.error == 0:
        return Interval.of(paired_difference(a[0], b[0])), mcnemar(a[0], b[0])
    low, high = np.clip(found.ends(), -1, 1).tolist()
    return Interval(found.value, low, high), found.p()


def _check_seeds_agree(a: Sequence[Match], b: Sequence[Match]) -> None:
    """Raise ValueError unless a side has a single match, or both sides have the same training seeds in one order."""
    of_a, of_b = ([match.cell.training_seed for match in side] for side in (a, b))
    if min(len(of_a), len(of_b)) != 1 and of_a != of_b:
        raise ValueError(f"A has the training seeds {of_a} and B {of_b}; only matches with equal seeds can be paired")


def _ended(rows: Rows, ending: Ending) -> Bool[np.ndarray, "scenario"]:
    """Return which episodes have this ending."""
    if ending == "moving contact":
        return touched_while_moving(rows)
    table = rows[OUTCOMES]
    return {"goal": table.goal, "collision": table.collision, "hit": table.moving}[ending]
