"""How often people decide to jaywalk, and whether the trait tau shows in it (paper, equation 1 and section IV-B)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from jaxwalk.metrics.counts import proportion
from jaxwalk.metrics.crossings import real_frames, rows_of
from jaxwalk.metrics.metric import Metric, Rows, Sums
from jaxwalk.metrics.statistics import Rate
from jaxwalk.sim.crossing_kind import JAYWALK, NO_CROSSING
from jaxwalk.sim.trajectory import Trajectory

QUARTERS = 4
"""tau in [0, 0.25), [0.25, 0.5), [0.5, 0.75) and [0.75, 1]."""


@dataclass(frozen=True)
class Decisions:
    """One row per frame in which a pedestrian has decided how to cross, ordered by episode, pedestrian, frame."""

    episode: Int[np.ndarray, "decision"]
    """Row of the episode."""
    ped: Int[np.ndarray, "decision"]
    frame: Int[np.ndarray, "decision"]
    type: Int[np.ndarray, "decision"]
    """CROSSWALK or JAYWALK: the last decision in the frame; NO_CROSSING if the recording does not say."""
    made: Int[np.ndarray, "decision"]
    """Decisions in the frame: 1, unless the recording is coarse; then the types of the earlier ones are lost."""
    tau: Float[np.ndarray, "decision"]
    """Jaywalking tendency of the pedestrian who decided."""


@dataclass(frozen=True)
class JaywalkRate:
    """Jaywalk decisions over decisions."""

    all: Rate
    quarters: tuple[Rate, ...]
    """By tau: [0, 0.25), [0.25, 0.5), [0.5, 0.75), [0.75, 1]."""
    unknown: int
    """Decisions of unknown type; no rate counts them."""


def find_decisions(trajectory: Trajectory) -> Decisions:
    """Find all decisions: each is an increment of ``Trajectory.decisions`` (from 0 before frame 0)."""
    made = np.diff(trajectory.decisions, axis=0, prepend=np.zeros_like(trajectory.decisions[:1]))
    decided = (made > 0) & real_frames(trajectory)[..., None]
    frame, episode, ped = rows_of(decided)
    return Decisions(
        episode=episode.astype(np.int32),
        ped=ped.astype(np.int16),
        frame=frame.astype(np.int32),
        type=trajectory.crossing[frame, episode, ped].astype(np.int8),
        made=made[frame, episode, ped].astype(np.int16),
        tau=trajectory.jaywalking_tendency[episode, ped].astype(np.float32),
    )


def summarise_decisions(rows: Rows, sums: Sums) -> JaywalkRate:
    """Return jaywalk rates over the decisions of known type."""
    found = rows.total(_counts)
    return JaywalkRate(
        all=proportion(*found["all"]),
        quarters=tuple(proportion(*counts) for counts in found["quarters"]),
        unknown=int(found["made"] - found["all"][1]),
    )


def _counts(rows: Rows) -> dict[str, Any]:
    """Return the decisions to jaywalk and all of known type, together and by quarter of tau, and how many were made."""
    table = rows[JAYWALK_RATE]
    quarter = np.clip(np.floor(table.tau * QUARTERS), 0, QUARTERS - 1)
    chosen = np.stack([table.type == JAYWALK, table.type != NO_CROSSING])
    return {
        "all": chosen.sum(axis=1),
        "quarters": np.stack([(chosen & (quarter == q)).sum(axis=1) for q in range(QUARTERS)]),
        "made": table.made.sum(dtype=np.int64),
    }


JAYWALK_RATE = Metric(
    name="jaywalk_rate",
    measure=lambda recording: find_decisions(recording.trajectory),
    summarise=summarise_decisions,
)
