"""How episodes end on each of several maps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.metrics import OUTCOMES, Rows, bootstrap_by_episode, proportion
from jaxwalk.metrics.delay import delays


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
    if rows.maps is None:
        return ()
    names = sorted(set(rows.maps.tolist()))
    return tuple(_rates(name, rows, rows.maps == name) for name in names) if len(names) > 1 else ()


def _rates(name: str, rows: Rows, here: np.ndarray) -> MapRates:
    table, count = rows[OUTCOMES], int(here.sum())
    goal, collision = table.goal[here], table.collision[here]
    time, delay = np.where(goal, table.steps[here] * rows.dt, 0), delays(rows)[here]
    return MapRates(
        map=name,
        episodes=count,
        goal_rate=Interval.of(proportion(goal.sum(), count)),
        collision_rate=Interval.of(proportion(collision.sum(), count)),
        timeout_rate=Interval.of(proportion((~goal & ~collision).sum(), count)),
        mean_time_to_goal=Interval.of(bootstrap_by_episode(time, goal)),
        mean_delay=Interval.of(bootstrap_by_episode(np.nan_to_num(delay), ~np.isnan(delay))),
    )
