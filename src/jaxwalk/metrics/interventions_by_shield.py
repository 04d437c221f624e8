"""Count what a shield does: how often it begins to change a driver's actions, and when nothing it can do is safe."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Bool, Int

from jaxwalk.metrics.counts import clustered_rate, clustered_share
from jaxwalk.metrics.crossings import real_frames
from jaxwalk.metrics.encounters import ENCOUNTERS
from jaxwalk.metrics.metric import Metric, Recording, Rows, Sums, episodes_with
from jaxwalk.metrics.outcomes import OUTCOMES
from jaxwalk.metrics.statistics import Estimate, ratio

UNKNOWN = Estimate(None, None, None, 0)
"""A number of drivers that have no shield."""


@dataclass(frozen=True)
class ShieldWork:
    """One row per episode."""

    shielded: Bool[np.ndarray, "episode"]
    """Whether the driver has a shield; else all counts are 0."""
    steps: Int[np.ndarray, "episode"]
    """Steps played."""
    changed: Int[np.ndarray, "episode"]
    """Steps in which the shield changed the action."""
    interventions: Int[np.ndarray, "episode"]
    """Unbroken rows of such steps."""
    infeasible: Int[np.ndarray, "episode"]
    """Steps in which nothing that the shield could do was safe by its rule."""


@dataclass(frozen=True)
class ShieldInterventions:
    """What a shield does. No number exists without one."""

    per_km: Estimate
    """Interventions per kilometre driven: unbroken rows of changed steps; the count is of those."""
    per_encounter: Estimate
    """Interventions per encounter, wherever they were."""
    changed: Estimate
    """Share of steps whose action was changed; the count is of steps."""
    infeasible: Estimate
    """Share of steps in which nothing was safe by the shield's rule; the count is of steps."""


def measure_shield_work(recording: Recording) -> ShieldWork:
    """Count a shield's interventions."""
    trajectory = recording.trajectory
    changed, infeasible = trajectory.shield_changed, trajectory.shield_infeasible
    none = np.zeros(len(trajectory.length), np.int32)
    steps = trajectory.length.astype(np.int32)
    if changed is None or infeasible is None:
        return ShieldWork(none.astype(bool), steps, none, none, none)
    played = real_frames(trajectory)[1:]
    acts = changed[1:] & played
    begins = acts.copy()
    begins[1:] &= ~acts[:-1]
    counts = (x.sum(axis=0).astype(np.int32) for x in (acts, begins, infeasible[1:] & played))
    return ShieldWork(~none.astype(bool), steps, *counts)


def _columns(rows: Rows) -> dict[str, np.ndarray]:
    return {column.name: getattr(rows[SHIELD_INTERVENTIONS], column.name) for column in fields(ShieldWork)}


def _summarise(rows: Rows, sums: Sums) -> ShieldInterventions:
    own, found = sums[SHIELD_INTERVENTIONS], episodes_with(rows, _columns)
    if found["shielded"] < rows.episodes or not rows.episodes:
        return ShieldInterventions(UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN)
    episodes, steps = found["steps"], own["steps"]
    met = float(sums[ENCOUNTERS]["encounters"][0].sum())
    return ShieldInterventions(
        per_km=clustered_rate(own["interventions"], float(sums[OUTCOMES]["km"][0])),
        per_encounter=clustered_rate(own["interventions"], met),
        changed=clustered_share(ratio(own["changed"], steps), steps[0], episodes),
        infeasible=clustered_share(ratio(own["infeasible"], steps), steps[0], episodes),
    )


SHIELD_INTERVENTIONS = Metric(
    name="shield",
    measure=measure_shield_work,
    needs=(OUTCOMES, ENCOUNTERS),
    columns=_columns,
    summarise=_summarise,
)
