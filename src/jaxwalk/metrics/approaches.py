"""Measure how each approach to a kerb ends, if a car is dangerous there: does the person wait, and who goes first?

Waiting makes moments of its own, so a share of moments says little about people. Here every stay at the kerb counts
once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from jaxwalk.metrics.counts import clustered_share
from jaxwalk.metrics.kerb import DANGER, KERB, Kerb
from jaxwalk.metrics.metric import Metric, Rows, Sums, episodes_with
from jaxwalk.metrics.statistics import Estimate, ratio
from jaxwalk.sim.crossing_kind import CROSSWALK
from jaxwalk.sim.trajectory import Trajectory

NEITHER, PERSON, CAR = range(3)
"""Who was first: the person entered the roadway ahead of the car; the car went past; or the episode ended before."""


@dataclass(frozen=True)
class ApproachRows:
    """One row per stay at the kerb with a dangerous moment."""

    episode: Int[np.ndarray, "approach"]
    """Row of the episode."""
    crosswalk: Bool[np.ndarray, "approach"]
    """The person had decided to use a crosswalk."""
    waited: Bool[np.ndarray, "approach"]
    """Waited through the first dangerous moment."""
    entered: Bool[np.ndarray, "approach"]
    """Entered the roadway straight from a dangerous moment."""
    before: Int[np.ndarray, "approach"]
    """NEITHER, PERSON or CAR: who went first, from the first dangerous moment to the end of the stay."""
    hit: Bool[np.ndarray, "approach"]
    """The car touched this person, who came to no other kerb before."""


@dataclass(frozen=True)
class Approaches:
    """Shares of approaches with a dangerous moment; each count is of approaches."""

    waited: Estimate
    """Waited through their first dangerous moment."""
    entered_in_danger: Estimate
    """Entered the roadway straight from a dangerous moment."""
    yielded: Estimate
    """At crosswalks, and where somebody was first: the car let the person go first, and did not touch it."""


def find_approaches(trajectory: Trajectory, kerb: Kerb) -> ApproachRows:
    """Find all stays at the kerb with a dangerous moment, and how they ended."""
    danger, row = kerb.setting == DANGER, np.arange(len(kerb.setting))
    met = np.minimum.reduceat(np.where(danger, row, len(row)), kerb.first)
    since = row >= np.repeat(met, kerb.last - kerb.first + 1)
    passed = np.logical_or.reduceat(since & (kerb.ahead <= 0), kerb.first)
    again = np.zeros(len(met), bool)
    begins = kerb.first[1:], kerb.first[:-1]
    again[:-1] = np.logical_and(*(np.equal(*(who[rows] for rows in begins)) for who in (kerb.episode, kerb.ped)))

    stays = np.flatnonzero(met < len(row))
    met, last = met[stays], kerb.last[stays]
    episode, ped = kerb.episode[last], kerb.ped[last]
    entered = trajectory.on_roadway[kerb.frame[last] + 1, episode, ped]
    return ApproachRows(
        episode=episode.astype(np.int32),
        crosswalk=trajectory.crossing[kerb.frame[last], episode, ped] == CROSSWALK,
        waited=kerb.waited[met],
        entered=entered & danger[last],
        before=np.where(passed[stays], CAR, np.where(entered, PERSON, NEITHER)).astype(np.int8),
        hit=trajectory.touched[episode, ped] & ~again[stays],
    )


def approach_columns(rows: Rows) -> dict[str, np.ndarray]:
    """Return the approaches of each episode, those at crosswalks in which somebody was first, and how they ended."""
    table = rows[APPROACHES]
    return {
        name: np.bincount(table.episode[chosen], minlength=rows.episodes) for name, chosen in _chosen(table).items()
    }


def _chosen(table: ApproachRows) -> dict[str, Bool[np.ndarray, "approach"]]:
    judged = table.crosswalk & (table.before != NEITHER)
    return {
        "approaches": np.ones(len(table.episode), bool),
        "judged": judged,
        "waited": table.waited,
        "entered": table.entered,
        "yielded": judged & (table.before == PERSON) & ~table.hit,
    }


def summarise_approaches(rows: Rows, sums: Sums) -> Approaches:
    """Return the shares of approaches."""
    own, episodes = sums[APPROACHES], episodes_with(rows, approach_columns)

    def share(name: str, over: str) -> Estimate:
        return clustered_share(ratio(own[name], own[over]), own[over][0], episodes[over])

    return Approaches(
        waited=share("waited", "approaches"),
        entered_in_danger=share("entered", "approaches"),
        yielded=share("yielded", "judged"),
    )


APPROACHES = Metric(
    name="approaches",
    measure=lambda recording: find_approaches(recording.trajectory, recording[KERB]),
    needs=(KERB,),
    columns=approach_columns,
    summarise=summarise_approaches,
)
