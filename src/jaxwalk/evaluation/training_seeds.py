"""Results of policies trained with several seeds: numbers over the seeds, and pairs of the same scenarios."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from jaxwalk.evaluation.comparison import paired
from jaxwalk.evaluation.results import Cell
from jaxwalk.metrics import ATTRIBUTION, OUTCOMES, Estimate, OverSeeds, Rate, Rows, Summary, over_seeds
from jaxwalk.metrics.statistics import FEWEST_SEEDS


@dataclass(frozen=True)
class Match:
    """One driver among one population."""

    cell: Cell
    rows: Rows
    training_seed: int | None
    """Of the driver or the population, or of both; None if neither was trained."""

    @property
    def names(self) -> tuple[str, str]:
        """Of the driver and of the population."""
        return self.cell.driver, self.cell.pedestrians

    def as_dict(self) -> dict[str, Any]:
        """The cell's document, with the training seed."""
        names = {"driver": self.cell.driver, "pedestrians": self.cell.pedestrians}
        return {**names, "training_seed": self.training_seed, **self.cell.as_dict()}


@dataclass(frozen=True)
class Measure:
    """A number that is shown over training seeds."""

    of_one: Callable[[Summary], Rate | Estimate]
    """The number of a single cell."""
    parts: Callable[[Rows], tuple[np.ndarray, np.ndarray]]
    """Its numerators and denominators, one of each per episode."""


def _rate(ending: Callable[[Rows], np.ndarray]) -> Callable[[Rows], tuple[np.ndarray, np.ndarray]]:
    return lambda rows: (ending(rows), np.ones(rows.episodes))


MEASURES: dict[str, Measure] = {
    "goal_rate": Measure(lambda s: s[OUTCOMES].goal, _rate(lambda rows: rows[OUTCOMES].goal)),
    "collision_rate": Measure(lambda s: s[OUTCOMES].collision, _rate(lambda rows: rows[OUTCOMES].collision)),
    "timeout_rate": Measure(
        lambda s: s[OUTCOMES].timeout, _rate(lambda rows: ~rows[OUTCOMES].goal & ~rows[OUTCOMES].collision)
    ),
    "collisions_per_km": Measure(
        lambda s: s[OUTCOMES].all.per_km, lambda rows: (rows[OUTCOMES].collision, rows[OUTCOMES].driven / 1000)
    ),
    "mean_time_to_goal": Measure(
        lambda s: s[OUTCOMES].time_to_goal,
        lambda rows: (rows[OUTCOMES].goal * rows[OUTCOMES].steps * rows.dt, rows[OUTCOMES].goal),
    ),
    "jaywalk_share": Measure(
        lambda s: s[ATTRIBUTION].per_crossing.share,
        lambda rows: (rows[ATTRIBUTION].crossings[:, 1], rows[ATTRIBUTION].crossings.sum(axis=1)),
    ),
}
"""Numbers over training seeds, by name; ``jaywalk_share`` is jaywalking's of the crossings."""


def over_training_seeds(matches: Sequence[Match]) -> list[dict[str, Any]]:
    """For each driver, population and jaywalk multiplier: all `MEASURES` over the training seeds (`OverSeeds`)."""
    groups: dict[tuple[str, str, float], list[Match]] = {}
    for match in matches:
        groups.setdefault((*match.names, match.cell.jaywalk_multiplier), []).append(match)
    return [
        {
            "driver": driver,
            "pedestrians": pedestrians,
            "jaywalk_multiplier": multiplier,
            "training_seeds": [match.training_seed for match in group],
            **{name: asdict(_over_seeds(measure, group)) for name, measure in MEASURES.items()},
        }
        for (driver, pedestrians, multiplier), group in groups.items()
    ]


def _over_seeds(measure: Measure, group: list[Match]) -> OverSeeds:
    """One cell alone keeps its own interval, over scenarios; so do rates of 0 or 1 everywhere: no bootstrap has one."""
    number = measure.of_one(group[0].cell.summary)
    each = tuple(measure.of_one(match.cell.summary).value for match in group)
    never_or_always = len(group) >= FEWEST_SEEDS and set(each) in ({0.0}, {1.0})
    if len(group) == 1 or never_or_always:
        same = Estimate(number.value, number.low, number.high, len(group))
        return OverSeeds(same, same, each)
    over, under = zip(*(measure.parts(match.rows) for match in group), strict=True)
    return over_seeds(np.stack(over), np.stack(under))


def paired_over_seeds(ending: str, a: Sequence[Match], b: Sequence[Match]) -> dict[str, Any]:
    """How often B ends so (``goal``, ``collision``), and A, on the same scenarios: all training seeds' pairs together.

    Pair (seed, scenario) has that seed's A and B; where nobody was trained, the only match stands for every seed. The
    exact McNemar test takes pairs as independent: it is about these very policies. The interval of the difference
    resamples seeds and scenarios (`jaxwalk.metrics.over_seeds`): it is about training with other seeds, too.
    """
    seeds = max(len(a), len(b))
    a, b = (list(side) * (seeds // len(side)) for side in (a, b))
    joined = [Rows.join([match.rows for match in side]) for side in (a, b)]
    found = getattr(paired(*joined), ending)
    ends_a, ends_b = (np.stack([getattr(m.rows[OUTCOMES], ending) for m in side]).astype(float) for side in (a, b))
    difference = over_seeds(ends_b - ends_a, np.ones_like(ends_a)).mean
    names = [{"driver": side[0].cell.driver, "pedestrians": side[0].cell.pedestrians} for side in (a, b)]
    return {
        "ending": ending,
        "a": {**names[0], "rate": float(ends_a.mean())},
        "b": {**names[1], "rate": float(ends_b.mean())},
        "training_seeds": seeds,
        "pairs": ends_a.size,
        "both": found.both,
        "only_a": found.only_a,
        "only_b": found.only_b,
        "difference": {"value": difference.value, "low": difference.low, "high": difference.high},
        "p": found.p,
    }
