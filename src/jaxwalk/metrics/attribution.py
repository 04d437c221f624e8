"""Compare jaywalking's share of the collisions with its share of crossings and of time at risk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from jaxwalk.metrics.counts import clustered_share, proportion, rate, rate_ratio
from jaxwalk.metrics.crossings import CROSSINGS, ROAD, TYPES, Crossings, RoadSteps, count_by_type
from jaxwalk.metrics.encounters import ENCOUNTERS
from jaxwalk.metrics.metric import Metric, Rows, Sums
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.metrics.statistics import Estimate, ratio
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
    """Jaywalk rate over crosswalk rate: 1 if both are equally dangerous; the count is the collisions of both types.
    Without a collision on a crosswalk it has no value and no upper end, but a lower end."""


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
    own, hits = sums[ATTRIBUTION], sums[OUTCOMES]["contacts"][0, : len(TYPES)]
    found = proportion(hits[JAYWALK - 1], hits.sum())
    crossed, near, met = rows.total(_exposed).tolist()
    return Attribution(
        share=Estimate(found.value, found.low, found.high, found.trials),
        per_crossing=_risk(hits, own["crossings"], crossed),
        per_encounter=_risk(hits, sums[ENCOUNTERS]["encounters"], met),
        per_second=_risk(hits, own["road_time"], crossed),
        per_second_near=_risk(hits, own["near_time"], near),
    )


def _exposed(rows: Rows) -> Int[np.ndarray, "exposure"]:
    """Return the number of episodes with any crossing, any frame near the car, any encounter."""
    table = rows[ATTRIBUTION]
    met = len(np.unique(rows[ENCOUNTERS].episode))
    return np.array([*(np.any(x, axis=1).sum() for x in (table.crossings, table.near_frames)), met])


def _risk(hits: Float[np.ndarray, "type"], exposure: Float[np.ndarray, "draw type"], episodes: int) -> Risk:
    """Return the rates and their ratio; only jaywalking's share of the exposure is taken as uncertain."""
    crosswalk, jaywalk = exposure[0].tolist()
    share = ratio(exposure[:, JAYWALK - 1], exposure.sum(axis=1))
    return Risk(
        exposure_crosswalk=crosswalk,
        exposure_jaywalk=jaywalk,
        share=clustered_share(share, crosswalk + jaywalk, episodes),
        crosswalk=rate(hits[CROSSWALK - 1], crosswalk),
        jaywalk=rate(hits[JAYWALK - 1], jaywalk),
        ratio=rate_ratio((hits[CROSSWALK - 1], hits[JAYWALK - 1]), (crosswalk, jaywalk)),
    )


ATTRIBUTION = Metric(
    name="attribution",
    measure=lambda recording: measure_exposure(recording.trajectory, recording[CROSSINGS], recording[ROAD][1]),
    needs=(ROAD, CROSSINGS, ENCOUNTERS, OUTCOMES),
    columns=exposure_columns,
    summarise=summarise_attribution,
)
