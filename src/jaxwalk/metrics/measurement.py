"""From trajectories to rows to numbers. ``docs/metrics.md`` has the formulas."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from jaxwalk.metrics.attribution import Attribution, exposure_columns, measure_exposure, summarise_attribution
from jaxwalk.metrics.crossings import ByType, find_crossings
from jaxwalk.metrics.decisions import JaywalkRate, find_decisions, summarise_decisions
from jaxwalk.metrics.distributions import Distributions, distribution_columns, summarise_distributions
from jaxwalk.metrics.encounters import EncounterSummary, encounter_columns, find_encounters, summarise_encounters
from jaxwalk.metrics.meetings import find_meetings, matched_differences, meeting_columns
from jaxwalk.metrics.outcomes import Outcomes, measure_outcomes, outcome_columns, summarise_outcomes
from jaxwalk.metrics.rows import Rows
from jaxwalk.metrics.speed_differential import (
    SpeedBin,
    measure_near_speeds,
    measure_placebo,
    speed_columns,
    summarise_speeds,
)
from jaxwalk.metrics.statistics import RESAMPLES, episode_sums
from jaxwalk.metrics.surrogate import (
    SurrogateSummary,
    measure_surrogates,
    summarise_surrogates,
    surrogate_columns,
)
from jaxwalk.metrics.waiting import Waiting, measure_waiting, summarise_waiting, waiting_columns
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Ghosts, Trajectory


@dataclass(frozen=True)
class Summary:
    """All metrics, with 95 % intervals and counts. What does not exist is None."""

    episodes: int
    outcomes: Outcomes
    speed_differential: tuple[SpeedBin, ...]
    """From the nearest bin to the farthest."""
    attribution: Attribution
    encounters: ByType[EncounterSummary]
    surrogates: ByType[SurrogateSummary]
    surrogate_distributions: ByType[Distributions]
    jaywalk_rate: JaywalkRate
    waiting: Waiting

    def as_dict(self) -> dict[str, Any]:
        """Plain nested dicts, tuples, numbers and None: ready for JSON."""
        return asdict(self)


def measure(trajectory: Trajectory, ghosts: Ghosts | None = None, *, config: SimConfig | None = None) -> Rows:
    """The rows of all episodes of a trajectory; rows of several are put together by ``Rows.join``.

    Args:
        trajectory: recorded episodes; frames after their ``length`` are ignored.
        ghosts: whom the cars could not see, for the placebo.
        config: when a car is moving, and what is a touch (default: `SimConfig`'s).
    """
    config = config or SimConfig()
    frames = len(trajectory.car_x)
    if trajectory.length.size and trajectory.length.max() >= frames:
        raise ValueError(f"length {trajectory.length.max()} needs one frame more than the trajectory's {frames}")
    crossings, steps = find_crossings(trajectory)
    encounters = find_encounters(trajectory, crossings, steps)
    return Rows(
        dt=float(trajectory.dt),
        episodes=measure_outcomes(trajectory, moving_speed=config.moving_speed),
        exposure=measure_exposure(trajectory, crossings, steps),
        near_speeds=measure_near_speeds(trajectory, steps),
        placebo=measure_placebo(trajectory, ghosts, collision_distance=config.collision_distance),
        waiting=measure_waiting(trajectory),
        crossings=crossings,
        encounters=encounters,
        meetings=find_meetings(trajectory, steps),
        surrogates=measure_surrogates(
            trajectory,
            encounters,
            collision_distance=config.collision_distance,
            moving_speed=config.moving_speed,
        ),
        decisions=find_decisions(trajectory),
    )


def summarise(rows: Rows, *, resamples: int = RESAMPLES, seed: int = 0) -> Summary:
    """All metrics of the rows; the bootstrap's draws come from ``seed``."""
    episodes = len(rows.episodes.scenario)
    columns = outcome_columns(rows.episodes, dt=rows.dt)
    columns |= exposure_columns(rows.exposure, dt=rows.dt)
    columns |= encounter_columns(rows.encounters, episodes=episodes)
    columns |= surrogate_columns(rows.surrogates, episodes=episodes)
    columns |= distribution_columns(rows.surrogates, rows.encounters, episodes=episodes)
    columns |= speed_columns(rows.near_speeds, rows.placebo)
    columns |= meeting_columns(rows.meetings, episodes=episodes)
    columns |= waiting_columns(rows.waiting, dt=rows.dt)
    sums = episode_sums(columns, resamples=resamples, seed=seed)
    matched = matched_differences(rows.meetings, episodes=episodes, resamples=resamples, seed=seed)
    return Summary(
        episodes=episodes,
        outcomes=summarise_outcomes(rows.episodes, sums, dt=rows.dt),
        speed_differential=summarise_speeds(sums, matched),
        attribution=summarise_attribution(sums),
        encounters=summarise_encounters(rows.encounters, sums),
        surrogates=summarise_surrogates(rows.surrogates, sums),
        surrogate_distributions=summarise_distributions(sums),
        jaywalk_rate=summarise_decisions(rows.decisions),
        waiting=summarise_waiting(rows.waiting, sums),
    )
