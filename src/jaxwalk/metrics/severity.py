"""Measure how severe encounters are: the share that comes nearer to a collision than each of several thresholds.

Shares are over all encounters of a type, so the curves of two types or two drivers can be compared directly. A curve
that never reaches 1 leaves out the encounters without a number: those never on a collision course, or whose paths do
not meet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from jaxwalk.metrics.counts import clustered_share
from jaxwalk.metrics.crossings import TYPES, ByType, count_by_type
from jaxwalk.metrics.encounters import ENCOUNTERS
from jaxwalk.metrics.metric import Metric, NoRows, Rows, Sums, episodes_with
from jaxwalk.metrics.statistics import ratio
from jaxwalk.metrics.surrogate import DRAC_CRITICAL, PET_CLOSE, PET_CRITICAL, SURROGATES, TTC_CRITICAL

THRESHOLDS: dict[str, tuple[float, ...]] = {
    "ttc": (0.25, 0.5, 0.75, 1.0, TTC_CRITICAL, 2.0, 2.5, 3.0, 4.0, 5.0),
    "pet": (0.25, 0.5, 0.75, 1.0, PET_CRITICAL, 2.0, 2.5, PET_CLOSE, 4.0, 5.0),
    "drac": (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, DRAC_CRITICAL, 4.0, 5.0, 6.0, 8.0, 10.0),
    "gap": (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 15.0),
}
"""Thresholds: times [s] count below them, gaps [m] at and below them, decelerations [m/s2] above them."""


@dataclass(frozen=True)
class Distribution:
    """The share of a type's encounters beyond each threshold, with its interval; None without encounters."""

    threshold: tuple[float, ...]
    value: tuple[float | None, ...]
    low: tuple[float | None, ...]
    high: tuple[float | None, ...]
    count: int
    """The number of all encounters of the type."""


@dataclass(frozen=True)
class Distributions:
    """The distributions of the encounters of one type."""

    ttc: Distribution
    """Share with a time to collision below each threshold [s]."""
    pet: Distribution
    """Share with a post-encroachment time below each threshold [s], whoever came first."""
    drac: Distribution
    """Share with a required deceleration above each threshold [m/s2]; above 0: those ever on a collision course."""
    gap: Distribution
    """Share in which car and body came as near as each threshold or nearer [m]; at 0 m they touched."""


def distribution_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return the encounters beyond each threshold (episode, type, threshold), and all encounters (episode, type)."""
    table = rows[SURROGATES]

    def count(chosen: np.ndarray) -> Int[np.ndarray, "episode type"]:
        found = count_by_type(table.episode[chosen], table.type[chosen], rows.episodes)
        return found.astype(np.int16)  # small, so that a million episodes fit into memory

    # comparisons with NaN are false
    beyond = {
        "ttc": lambda x: table.ttc < x,
        "pet": lambda x: np.abs(table.pet) < x,
        "drac": lambda x: table.drac > x,
        "gap": lambda x: rows[ENCOUNTERS].min_gap <= x,
    }
    return {"met": count(np.ones(len(table.type), bool))} | {
        name: np.stack([count(beyond[name](x)) for x in thresholds], axis=2) for name, thresholds in THRESHOLDS.items()
    }


def _met(rows: Rows) -> dict[str, Int[np.ndarray, "episode type"]]:
    """Return all encounters by type."""
    table = rows[SURROGATES]
    return {"met": count_by_type(table.episode, table.type, rows.episodes)}


def summarise_distributions(rows: Rows, sums: Sums) -> ByType[Distributions]:
    """Return the distributions of all encounters, by type."""
    met = episodes_with(rows, _met)["met"].tolist()
    return ByType(
        *(
            Distributions(**{name: _distribution(name, kind, sums, met[kind - 1]) for name in THRESHOLDS})
            for kind in TYPES
        )
    )


def _distribution(name: str, kind: int, sums: Sums, episodes: int) -> Distribution:
    own = sums[SURROGATE_DISTRIBUTIONS]
    met, beyond = own["met"][:, kind - 1], own[name][:, kind - 1]
    shares = [clustered_share(ratio(column, met), met[0], episodes) for column in beyond.T]
    return Distribution(
        threshold=THRESHOLDS[name],
        value=tuple(x.value for x in shares),
        low=tuple(x.low for x in shares),
        high=tuple(x.high for x in shares),
        count=int(met[0]),
    )


SURROGATE_DISTRIBUTIONS = Metric(
    name="surrogate_distributions",
    measure=lambda recording: NoRows(),
    needs=(ENCOUNTERS, SURROGATES),
    columns=distribution_columns,
    summarise=summarise_distributions,
)
