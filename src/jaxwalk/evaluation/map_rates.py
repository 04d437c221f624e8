"""How episodes end on each of several maps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Shaped

from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.metrics import OUTCOMES, Rows, proportion
from jaxwalk.metrics.delay import delays
from jaxwalk.metrics.statistics import interval, ratio, sums_over_chunks


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
    sums = sums_over_chunks((_columns(chunk, names) for chunk in rows.chunks()), rows.episodes)
    return tuple(_rates(name, {key: found[:, at] for key, found in sums.items()}) for at, name in enumerate(names))


def _columns(rows: Rows, names: list[str]) -> dict[str, Shaped[np.ndarray, "episode map"]]:
    """Return numbers of each episode on the map where it is, and 0 on the others; times in s."""
    table, delay = rows[OUTCOMES], delays(rows)
    numbers = {
        "episodes": np.ones(rows.episodes, bool),
        "goals": table.goal,
        "collisions": table.collision,
        "time": table.steps * table.goal * rows.dt,
        "arrived": ~np.isnan(delay),
        "delay": np.nan_to_num(delay),
    }
    here = np.asarray(rows.maps)[:, None] == np.array(names, object)
    return {name: each[:, None] * here for name, each in numbers.items()}


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
