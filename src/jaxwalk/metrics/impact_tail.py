"""Measure how fast the car is in the contacts of its worst episodes: a rare fast one counts as much as many slow ones.

The conditional value at risk (Rockafellar and Uryasev, 2000) of the car's speed in the contact that ends an episode; an
episode without a contact has 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy
from jaxtyping import Float, Shaped

from jaxwalk.metrics.counts import FEW
from jaxwalk.metrics.metric import Metric, NoRows, Rows, Sums
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.metrics.statistics import CONFIDENCE, Estimate, standard_deviation
from jaxwalk.metrics.values import Values

LEVEL = 0.99
"""The tail is the worst 1 - this of the episodes."""


@dataclass(frozen=True)
class ImpactTail:
    """The speeds of the car in contacts, over all episodes."""

    worst_hundredth: Estimate
    """Mean over the worst hundredth of the episodes, those with the fastest contacts [m/s]; 0 without any. The count is
    the number of them with a contact."""
    exceeded_by_a_hundredth: float | None
    """The value at risk: the slowest speed of those episodes [m/s]; None without episodes."""
    mean: float | None
    """Mean over all episodes [m/s]; None without any."""


def impact_speeds(rows: Rows) -> Float[np.ndarray, "episode"]:
    """Return the speed of the car in the contact that ends each episode [m/s]; 0 where none does."""
    return np.nan_to_num(rows[OUTCOMES].impact_speed.astype(np.float64))


def value_at_risk(values: Shaped[np.ndarray, "episode"] | Values, level: float = LEVEL) -> float:
    """Return the smallest of the largest 1 - ``level`` of the values, at least one."""
    values = Values.of(values)
    return values.ordered([values.count - _beyond(values.count, level)])[0]


def _beyond(count: int, level: float) -> int:
    """Return how many of a number of values are at least partly among the largest 1 - ``level``."""
    return max(math.ceil(count * (1 - level) - 1e-9), 1)


def tail_parts(values: Shaped[np.ndarray, "episode"], level: float = LEVEL) -> Float[np.ndarray, "episode"]:
    """Return what each value adds to the mean of the largest 1 - ``level`` of them, which is the mean of these parts.

    With v the value at risk: v + max(x - v, 0) / (1 - level) (Rockafellar and Uryasev 2000, theorem 1). A value at the
    edge of the tail counts by the share of it that is in the tail.
    """
    return _beyond_edge(value_at_risk(values, level), level, values)


def _beyond_edge(edge: float, level: float, values: Shaped[np.ndarray, "value"]) -> Float[np.ndarray, "value"]:
    return edge + np.maximum(np.asarray(values, np.float64) - edge, 0) / (1 - level)


def tail_mean(values: Shaped[np.ndarray, "episode"] | Values, level: float = LEVEL) -> Estimate:
    """Return the mean of the largest 1 - ``level`` of independent values, which are 0 or more, with its interval.

    The count is the number of values above 0 among them. The interval is Student's of `tail_parts` on the scale of
    logarithms, with the degrees of freedom of that number: the rest of the values says nothing about the tail's spread.
    There is none for fewer than `FEW`.
    """
    values = Values.of(values)
    parts = values.each(partial(_beyond_edge, value_at_risk(values, level), level))
    above = sum(int((piece > 0).sum()) for piece in values)
    count, mean, (least, most) = min(above, _beyond(values.count, level)), parts.sum() / values.count, parts.ends()
    if count < FEW or least == most:
        return Estimate(mean, None, None, count)
    error = standard_deviation(parts, mean) / math.sqrt(values.count)
    half = float(scipy.stats.t.ppf((1 + CONFIDENCE) / 2, count - 1)) * error / mean
    return Estimate(mean, mean * math.exp(-half), mean * math.exp(half), count)


def summarise_impacts(rows: Rows, sums: Sums) -> ImpactTail:
    """Return the speeds in the contacts of the worst episodes."""
    speeds = rows.values(impact_speeds)
    if not rows.episodes:
        return ImpactTail(Estimate(None, None, None, 0), None, None)
    return ImpactTail(tail_mean(speeds), value_at_risk(speeds), speeds.sum() / rows.episodes)


IMPACT_TAIL = Metric(
    name="impact_tail", measure=lambda recording: NoRows(), needs=(OUTCOMES,), summarise=summarise_impacts
)
