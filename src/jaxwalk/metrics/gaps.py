"""Measure which gaps before the car people accept at the kerb, and which they let pass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from jaxwalk.metrics.kerb import FAST, KERB, NEAR, Kerb
from jaxwalk.metrics.metric import Metric, Rows, Sums
from jaxwalk.metrics.statistics import Estimate, quantile
from jaxwalk.metrics.values import without_nan
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Trajectory


@dataclass(frozen=True)
class Gaps:
    """One row per stay at the kerb; NaN stands for a gap that does not exist."""

    episode: Int[np.ndarray, "stay"]
    """Row of the episode."""
    accepted: Float[np.ndarray, "stay"]
    """Gap in the last moment before the person entered the roadway [s]."""
    rejected: Float[np.ndarray, "stay"]
    """Largest gap of a moment that was waited through [s]."""


@dataclass(frozen=True)
class GapAcceptance:
    """Gaps in time to the car; stays at the kerb are assumed independent. Each count is of stays."""

    accepted: Estimate
    """Median accepted gap [s]."""
    shortest: Estimate
    """5th percentile of the accepted gaps [s]."""
    rejected: Estimate
    """Median of the largest gap that each person let pass [s]."""


def find_gaps(trajectory: Trajectory, kerb: Kerb, config: SimConfig) -> Gaps:
    """Return the accepted and the largest rejected gap of each stay.

    The gap is the time that the car's front needs at its present speed to come abreast of the person. It exists if the
    person is ahead of the front, the centres nearer than 40 m, and the car faster than 2 m/s.
    """
    ahead = kerb.ahead - config.car_length / 2
    coming = (ahead > 0) & (kerb.distance < NEAR) & (kerb.speed > FAST)
    gap = np.divide(ahead, kerb.speed, out=np.full(len(coming), np.nan), where=coming)
    last = kerb.last
    entered = trajectory.on_roadway[kerb.frame[last] + 1, kerb.episode[last], kerb.ped[last]]
    waited = np.where(kerb.waited, gap, np.nan)
    return Gaps(
        episode=kerb.episode[last].astype(np.int32),
        accepted=np.where(entered, gap[last], np.nan).astype(np.float32),
        rejected=np.fmax.reduceat(waited, kerb.first).astype(np.float32),
    )


def summarise_gaps(rows: Rows, sums: Sums) -> GapAcceptance:
    """Return accepted and rejected gaps."""
    accepted = rows.values(lambda chunk: without_nan(chunk[GAPS].accepted))
    rejected = rows.values(lambda chunk: without_nan(chunk[GAPS].rejected))
    return GapAcceptance(quantile(accepted, 0.5), quantile(accepted, 0.05), quantile(rejected, 0.5))


GAPS = Metric(
    name="gaps",
    measure=lambda recording: find_gaps(recording.trajectory, recording[KERB], recording.config),
    needs=(KERB,),
    summarise=summarise_gaps,
)
