"""Find encounters: crossings that the car comes close to. Measure how near it came, when it braked, whether it hit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from jaxwalk.metrics.braking import ALREADY, NAMES, NEVER, ONSET, STANDING, UNSEEN, braking_times
from jaxwalk.metrics.counts import proportion
from jaxwalk.metrics.crossings import CROSSINGS, ROAD, TYPES, ByType, Crossings, RoadSteps, count_by_type
from jaxwalk.metrics.footprint import in_car_frame
from jaxwalk.metrics.metric import Finding, Metric, Rows, Sums
from jaxwalk.metrics.statistics import Estimate, Rate, interval, kaplan_meier_median, quantile, ratio
from jaxwalk.metrics.values import Values
from jaxwalk.sim.events import to_rectangle
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Trajectory


@dataclass(frozen=True)
class Encounters:
    """One row per encounter (at most one per crossing), in the order of the crossings."""

    episode: Int[np.ndarray, "encounter"]
    """Row of the episode."""
    scenario: Int[np.ndarray, "encounter"]
    ped: Int[np.ndarray, "encounter"]
    number: Int[np.ndarray, "encounter"]
    """Number of the crossing among the pedestrian's in this episode, from 1."""
    type: Int[np.ndarray, "encounter"]
    """CROSSWALK or JAYWALK."""
    enter: Int[np.ndarray, "encounter"]
    """First frame of the crossing; the encounter may begin later."""
    start: Int[np.ndarray, "encounter"]
    """First frame of the crossing with the car within 20 m and closing."""
    end: Int[np.ndarray, "encounter"]
    """Last frame of the crossing."""
    min_distance: Float[np.ndarray, "encounter"]
    """Smallest distance between the centres from ``start`` to ``end`` [m]."""
    min_gap: Float[np.ndarray, "encounter"]
    """Smallest gap between the car's rectangle and the pedestrian's body from ``start`` to ``end`` [m]."""
    entry_speed: Float[np.ndarray, "encounter"]
    """Speed of the car in frame ``enter`` [m/s]."""
    collided: Bool[np.ndarray, "encounter"]
    """Whether the encounter ended with the car touching this pedestrian."""
    braking: Int[np.ndarray, "encounter"]
    """NEVER, ONSET, ALREADY, STANDING or UNSEEN, as in ``metrics.braking``."""
    braking_time: Float[np.ndarray, "encounter"]
    """Time from road entry to braking onset, or to ``end`` if never [s]; NaN in the other cases."""


def encounter_starts(steps: RoadSteps) -> Int[np.ndarray, "crossing"]:
    """Return each crossing's first frame with the car close and closing in; beyond all frames if there is none."""
    never = np.iinfo(np.int32).max
    return np.minimum.reduceat(np.where(steps.closing, steps.frame, never), steps.first)


def find_encounters(
    trajectory: Trajectory, crossings: Crossings, steps: RoadSteps, gaps: Float[np.ndarray, "step"]
) -> Encounters:
    """Find all encounters of a trajectory; ``gaps`` are those of `gaps_on_road`."""
    start = encounter_starts(steps)
    meeting = steps.frame >= start[steps.crossing]
    nearest, gap = (np.minimum.reduceat(np.where(meeting, x, np.inf), steps.first) for x in (steps.distance, gaps))
    met = start <= crossings.last
    episode, ped, enter, end = (c[met] for c in (crossings.episode, crossings.ped, crossings.enter, crossings.last))
    hit = trajectory.collision[episode] & trajectory.touched[episode, ped] & (end == trajectory.length[episode])
    braking, braking_time = braking_times(trajectory, episode=episode, enter=enter, last=end)
    return Encounters(
        episode=episode,
        scenario=trajectory.scenario[episode],
        ped=ped,
        number=crossings.number[met],
        type=crossings.type[met],
        enter=enter,
        start=start[met].astype(np.int32),
        end=end,
        min_distance=nearest[met].astype(np.float32),
        min_gap=gap[met].astype(np.float32),
        entry_speed=trajectory.car_speed[enter, episode].astype(np.float32),
        collided=hit,
        braking=braking,
        braking_time=braking_time,
    )


def gaps_on_road(trajectory: Trajectory, steps: RoadSteps, config: SimConfig) -> Float[np.ndarray, "step"]:
    """Return the distance from the car's rectangle to the pedestrian's body [m]; 0 in contact."""
    place = in_car_frame(trajectory, steps.frame, steps.episode, steps.ped)
    away = to_rectangle(*place, config.car_length, config.car_width)
    return np.maximum(away - config.body_radius, 0)


@dataclass(frozen=True)
class Braking:
    """Time from a pedestrian's road entry to the car's braking onset."""

    median: Estimate
    """Kaplan-Meier median [s], over ``observed`` and ``censored``; None if fewer than half brake in time."""
    mean_observed: Estimate
    """Mean over the observed times only [s]; it leaves out encounters in which the car never brakes."""
    observed: int
    """Encounters with a braking onset."""
    censored: int
    """Encounters in which the car never begins to brake."""
    already: int
    """Encounters with the car braking at road entry."""
    standing: int
    """Encounters with the car at 1 m/s or less at road entry."""
    unseen: int
    """Encounters with a pedestrian who was on the road when the episode began."""


@dataclass(frozen=True)
class EncounterSummary:
    """The encounters of one type."""

    count: int
    collided: Rate
    """Share that ended with the car touching the pedestrian."""
    minimum_approach: Estimate
    """5th percentile of the smallest distance between the centres [m], as in the paper."""
    minimum_gap: Estimate
    """5th percentile of the smallest gap between car and body [m]."""
    braking: Braking


def encounter_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return, per episode and type, encounters, braking onsets and the sum of their times [s]."""
    table = rows[ENCOUNTERS]
    braked = table.braking == ONSET
    onsets = table.episode[braked], table.type[braked], rows.episodes
    return {
        "encounters": count_by_type(table.episode, table.type, rows.episodes),
        "onsets": count_by_type(*onsets),
        "onset_time": count_by_type(*onsets, weights=table.braking_time[braked]),
    }


def summarise_encounters(rows: Rows, sums: Sums) -> ByType[EncounterSummary]:
    """Return the numbers of encounters, by type."""
    own = sums[ENCOUNTERS]
    means = ratio(own["onset_time"], own["onsets"])
    return ByType(*(_summarise_type(rows, kind, means[:, kind - 1]) for kind in TYPES))


def _summarise_type(rows: Rows, kind: int, mean: np.ndarray) -> EncounterSummary:
    """Summarise the encounters of one type; ``mean`` is the resampled mean time to an observed braking onset [s]."""

    def of_kind(name: str, *, watched: bool = False) -> Values:
        return rows.values(lambda chunk: _column(chunk, kind, name, watched=watched))

    found = rows.total(lambda chunk: np.bincount(_column(chunk, kind, "braking"), minlength=len(NAMES)))
    collided = rows.total(lambda chunk: _column(chunk, kind, "collided").sum())
    onset = of_kind("braking", watched=True).each(lambda status: status == ONSET)
    counts = found.tolist()
    return EncounterSummary(
        count=sum(counts),
        collided=proportion(collided, sum(counts)),
        minimum_approach=quantile(of_kind("min_distance"), 0.05),
        minimum_gap=quantile(of_kind("min_gap"), 0.05),
        braking=Braking(
            median=kaplan_meier_median(of_kind("braking_time", watched=True), onset),
            mean_observed=interval(mean, counts[ONSET]),
            observed=counts[ONSET],
            censored=counts[NEVER],
            already=counts[ALREADY],
            standing=counts[STANDING],
            unseen=counts[UNSEEN],
        ),
    )


def _column(rows: Rows, kind: int, name: str, *, watched: bool = False) -> Shaped[np.ndarray, "encounter"]:
    """Return a column of the encounters of one type: all, or those in which the car could begin to brake."""
    table = rows[ENCOUNTERS]
    chosen = table.type == kind
    if watched:
        chosen &= table.braking <= ONSET
    return getattr(table, name)[chosen]


ROAD_GAPS = Finding(
    name="road_gaps",
    measure=lambda recording: gaps_on_road(recording.trajectory, recording[ROAD][1], recording.config),
    needs=(ROAD,),
)
ENCOUNTERS = Metric(
    name="encounters",
    measure=lambda recording: find_encounters(
        recording.trajectory, recording[CROSSINGS], recording[ROAD][1], recording[ROAD_GAPS]
    ),
    needs=(ROAD, CROSSINGS, ROAD_GAPS),
    columns=encounter_columns,
    summarise=summarise_encounters,
)
