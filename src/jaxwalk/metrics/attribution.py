"""Compare jaywalking's share of the collisions with its share of crossings and of time at risk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from jaxwalk.metrics.crossings import CROSSINGS, ROAD, TYPES, Crossings, RoadSteps, count_by_type
from jaxwalk.metrics.encounters import ENCOUNTERS
from jaxwalk.metrics.metric import Metric, Rows, Sums
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.metrics.statistics import Estimate, interval, ratio
from jaxwalk.sim import events
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.trajectory import Trajectory


@dataclass(frozen=True)
class Exposure:
    """How much each type of crossing was used: one row per episode."""

    crossings: Int[np.ndarray, "episode type"]
    road_frames: Int[np.ndarray, "episode type"]
    """Frames that pedestrians spent on a roadway, added up over all pedestrians."""
    near_frames: Int[np.ndarray, "episode type"]
    """Those frames in which the car was within 20 m."""


@dataclass(frozen=True)
class Risk:
    """Collisions with people on a roadway, divided by one measure of exposure."""

    exposure_crosswalk: float
    """Exposure of crosswalk users, in the unit of the measure."""
    exposure_jaywalk: float
    share: Estimate
    """Jaywalking's share of the exposure; the count is the exposure itself, rounded down."""
    crosswalk: Estimate
    """Collisions per unit of exposure; the count is the number of collisions."""
    jaywalk: Estimate
    ratio: Estimate
    """Jaywalk rate over crosswalk rate: 1 if both are equally dangerous; the count is the collisions of both types."""


@dataclass(frozen=True)
class Attribution:
    """Jaywalking's part in the collisions with people on a roadway, on four scales of exposure."""

    share: Estimate
    """Jaywalking's share of the collisions with people on a roadway; the count is the number of those collisions."""
    per_crossing: Risk
    per_encounter: Risk
    per_second: Risk
    """Per second that one pedestrian spends on a roadway."""
    per_second_near: Risk
    """Per second that one pedestrian spends on a roadway with the car within 20 m."""


def measure_exposure(trajectory: Trajectory, crossings: Crossings, steps: RoadSteps) -> Exposure:
    """Count the crossings of each episode and the frames on a roadway."""
    episodes = len(trajectory.length)
    near = steps.distance <= events.ENCOUNTER_DISTANCE
    return Exposure(
        crossings=count_by_type(crossings.episode, crossings.type, episodes).astype(np.int32),
        road_frames=count_by_type(steps.episode, steps.type, episodes).astype(np.int32),
        near_frames=count_by_type(steps.episode[near], steps.type[near], episodes).astype(np.int32),
    )


def exposure_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return the exposures, each of shape (episode, type); times in s."""
    table = rows[ATTRIBUTION]
    return {
        "crossings": table.crossings,
        "road_time": table.road_frames * rows.dt,
        "near_time": table.near_frames * rows.dt,
    }


def summarise_attribution(rows: Rows, sums: Sums) -> Attribution:
    """Return jaywalking's share of the collisions, and the risks on each scale of exposure."""
    own, hits = sums[ATTRIBUTION], sums[OUTCOMES]["contacts"][:, : len(TYPES)]
    both = hits.sum(axis=1)
    return Attribution(
        share=interval(ratio(hits[:, JAYWALK - 1], both), both[0]),
        per_crossing=_risk(hits, own["crossings"]),
        per_encounter=_risk(hits, sums[ENCOUNTERS]["encounters"]),
        per_second=_risk(hits, own["road_time"]),
        per_second_near=_risk(hits, own["near_time"]),
    )


def _risk(hits: np.ndarray, exposure: np.ndarray) -> Risk:
    """Return the rates and their ratio, from resampled sums of shape (resample, type)."""
    rate = ratio(hits, exposure)
    crosswalk, jaywalk = rate[:, CROSSWALK - 1], rate[:, JAYWALK - 1]
    whole = exposure.sum(axis=1)
    return Risk(
        exposure_crosswalk=float(exposure[0, CROSSWALK - 1]),
        exposure_jaywalk=float(exposure[0, JAYWALK - 1]),
        share=interval(ratio(exposure[:, JAYWALK - 1], whole), whole[0]),
        crosswalk=interval(crosswalk, hits[0, CROSSWALK - 1]),
        jaywalk=interval(jaywalk, hits[0, JAYWALK - 1]),
        ratio=interval(ratio(jaywalk, crosswalk), hits[0].sum()),
    )


ATTRIBUTION = Metric(
    name="attribution",
    measure=lambda recording: measure_exposure(recording.trajectory, recording[CROSSINGS], recording[ROAD][1]),
    needs=(ROAD, CROSSINGS, ENCOUNTERS, OUTCOMES),
    columns=exposure_columns,
    summarise=summarise_attribution,
)
