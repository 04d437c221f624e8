"""How episodes end on each of several maps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from jaxtyping import Float

from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.metrics import OUTCOMES, Rows, proportion
from jaxwalk.metrics.delay import delays
from jaxwalk.metrics.statistics import episode_slices, interval, ratio, resampled_sums

NUMBERS = ("episodes", "goals", "collisions", "time", "arrived", "delay")
"""What is added up for each map."""


@dataclass(frozen=True)
class MapRates:
    """How the episodes on one map ended."""

    map: str
    """The map's name."""
    episodes: int
    goal_rate: Interval
    collision_rate: Interval
    timeout_rate: Interval
    mean_time_to_goal: Interval
    """Mean over the episodes that reach the goal [s]."""
    mean_delay: Interval
    """Mean delay [s]: how much later the car arrives than at full throttle where there is nobody."""


def rates_by_map(rows: Rows) -> tuple[MapRates, ...]:
    """Return the rates on each map, by name; empty unless the episodes are on several maps."""
    names = sorted({name for chunk in rows.chunks() if chunk.maps is not None for name in chunk.maps.tolist()})
    if len(names) < 2:
        return ()
    sums = resampled_sums(_matrices(rows, names), rows.episodes).reshape(-1, len(names), len(NUMBERS))
    return tuple(_rates(name, dict(zip(NUMBERS, sums[:, at].T, strict=True))) for at, name in enumerate(names))


def _matrices(rows: Rows, names: list[str]) -> Iterator[Any]:
    """Yield `NUMBERS` of some episodes in the columns of their map, sparse; times in s."""
    for chunk in rows.chunks():
        table, delay = chunk[OUTCOMES], delays(chunk)
        seconds = table.steps * table.goal * chunk.dt
        always = np.ones(chunk.episodes)
        numbers = np.stack(
            [always, table.goal, table.collision, seconds, ~np.isnan(delay), np.nan_to_num(delay)], axis=1
        )
        found, which = np.unique(np.asarray(chunk.maps), return_inverse=True)
        first = np.searchsorted(names, found.astype(str))[which] * len(NUMBERS)
        column = first[:, None] + np.arange(len(NUMBERS))
        row = np.repeat(np.arange(chunk.episodes), len(NUMBERS))
        shape = chunk.episodes, len(names) * len(NUMBERS)
        matrix = scipy.sparse.csr_array((numbers.ravel(), (row, column.ravel())), shape=shape)
        yield from (matrix[some] for some in episode_slices(chunk.episodes))


def _rates(name: str, sums: dict[str, Float[np.ndarray, "draw"]]) -> MapRates:
    episodes, goals, collisions, arrived = (int(sums[key][0]) for key in ("episodes", "goals", "collisions", "arrived"))
    return MapRates(
        map=name,
        episodes=episodes,
        goal_rate=Interval.of(proportion(goals, episodes)),
        collision_rate=Interval.of(proportion(collisions, episodes)),
        timeout_rate=Interval.of(proportion(episodes - goals - collisions, episodes)),
        mean_time_to_goal=Interval.of(interval(ratio(sums["time"], sums["goals"]), goals)),
        mean_delay=Interval.of(interval(ratio(sums["delay"], sums["arrived"]), arrived)),
    )
