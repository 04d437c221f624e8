"""Could it have been avoided, and by whom? Every collision of an evaluation, replayed with one thing changed.

What is changed, and what a label means: ``docs/metrics.md``, Counterfactuals. A scenario holds all chance and a step
none, so everything else is as it was until the change makes a difference.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from jaxwalk.evaluation.batches import BATCH, Progress
from jaxwalk.evaluation.interventions import Brake, TakeOver, Wait, on_the_crosswalk
from jaxwalk.evaluation.playing import play
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.metrics import CROSSINGS, OUTCOMES, Rate, Rows, wilson
from jaxwalk.metrics.outcomes import SIDEWALK, Episodes, measure_outcomes
from jaxwalk.policies import Oracle
from jaxwalk.scenarios import Source
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario

SMALL_BATCH = 64
"""Collisions replayed at once, unless told otherwise."""
WATCHED = 5.0
"""A collision is avoided if nobody is touched up to this long after it happened [s]; a later one is not this one."""
LEAD = 3.0
"""Who is hit on a sidewalk entered no road: the driver does otherwise from this long before, or from the start [s]."""
CHANGES = ("crosswalk", "wait", "brake", "planner", "planner_from_start")
"""What is done otherwise, each in a replay of its own."""
LABELS = ("either", "driver", "pedestrian", "unavoidable")
"""Who could have avoided a collision."""


class ReplayError(ValueError):
    """A collision did not come back in a replay without any change."""


@dataclass(frozen=True)
class Counterfactuals:
    """One row per replayed collision. The columns named as `CHANGES` say: so changed, it did not happen."""

    collisions: int
    """Of the evaluation, replayed or not."""
    scenario: Int[np.ndarray, "collision"]
    contact: Int[np.ndarray, "collision"]
    """CROSSWALK, JAYWALK or SIDEWALK: what the pedestrian touched was doing."""
    moving: Bool[np.ndarray, "collision"]
    """Of a moving car."""
    notice: Float[np.ndarray, "collision"]
    """From road entry (on a sidewalk: from when the driver does otherwise) to the collision [s]."""
    crosswalk_applies: Bool[np.ndarray, "collision"]
    """It was a jaywalker."""
    wait_applies: Bool[np.ndarray, "collision"]
    """It was somebody who had stepped into the road."""
    crosswalk: Bool[np.ndarray, "collision"]
    """The pedestrian crosses on the crosswalk (false where that does not apply)."""
    wait: Bool[np.ndarray, "collision"]
    """The pedestrian waits at the kerb (false where that does not apply)."""
    brake: Bool[np.ndarray, "collision"]
    """The car brakes fully from road entry on."""
    planner: Bool[np.ndarray, "collision"]
    """The oracle drives from road entry on."""
    planner_from_start: Bool[np.ndarray, "collision"]
    """The oracle drives all the way; no part of the label."""

    @property
    def label(self) -> Shaped[np.ndarray, "collision"]:
        """One of `LABELS`, as text."""
        driver, pedestrian = self.brake | self.planner, self.crosswalk | self.wait
        return np.select([driver & pedestrian, driver, pedestrian], LABELS[:3], LABELS[3])


def counterfactuals(
    street: Street, policies: Roles[Policy], source: Source, hits: Hits, *,
    batch: int | None = None, progress: Progress | None = None,
) -> Counterfactuals:  # fmt: skip
    """Replay collisions of an evaluation, unchanged and with each of `CHANGES`.

    Args:
        street: the world; this and the following as they were for the evaluation.
        policies: who plays each role.
        source: the scenarios.
        hits: the collisions, from `find_hits`.
        batch: episodes played at once. If left out, `SMALL_BATCH`, which is quicker for few collisions, or where these
            round differently, `BATCH`, with which `evaluate` plays.
        progress: called after every batch with the collisions replayed so far and those to replay.

    Raises:
        ReplayError: an unchanged replay ends otherwise than the row says.
        ValueError: ``batch`` is below 1.
    """
    if batch is not None and batch < 1:
        raise ValueError(f"batch must be at least 1, not {batch}")
    replayed = partial(_replay_all, street, policies, source, hits, progress)
    try:
        avoided = replayed(batch or SMALL_BATCH)
    except ReplayError:
        if batch is not None:
            raise
        avoided = replayed(BATCH)
    return Counterfactuals(
        collisions=hits.collisions,
        scenario=hits.scenario,
        contact=hits.contact,
        moving=hits.moving,
        notice=(hits.steps - hits.start) * hits.dt,
        crosswalk_applies=hits.contact == JAYWALK,
        wait_applies=hits.entered,
        **avoided,
    )


def _replay_all(
    street: Street, policies: Roles[Policy], source: Source, hits: Hits, progress: Progress | None, batch: int
) -> dict[str, Bool[np.ndarray, "collision"]]:
    """Return whether each change avoids each collision; ``batch`` of them are replayed at once."""
    count = len(hits.scenario)
    avoided = {change: np.zeros(count, bool) for change in CHANGES}
    for first in range(0, count, batch):
        some = np.arange(first, min(first + batch, count))
        full = np.resize(some, batch)  # repeated to a full batch, so that nothing is compiled twice
        for change, answer in _replay(street, policies, source, hits.some(full)).items():
            avoided[change][some] = answer[: len(some)]
        if progress is not None:
            progress(int(some[-1]) + 1, count)
    return avoided


@dataclass(frozen=True)
class Hits:
    """Collisions of an evaluation, one row each."""

    collisions: int
    """All of the evaluation, chosen or not."""
    dt: float
    """Duration of a step [s]."""
    scenario: Int[np.ndarray, "collision"]
    steps: Int[np.ndarray, "collision"]
    """Frame of the contact."""
    ped: Int[np.ndarray, "collision"]
    """The pedestrian touched (of several, the nearest)."""
    contact: Int[np.ndarray, "collision"]
    moving: Bool[np.ndarray, "collision"]
    entered: Bool[np.ndarray, "collision"]
    """It was hit on a roadway, which it had entered after frame 0."""
    start: Int[np.ndarray, "collision"]
    """Frame of its road entry; of who was hit on a sidewalk, from when the driver does otherwise."""

    def some(self, rows: slice | Shaped[np.ndarray, "row"]) -> Hits:
        """Return the rows chosen by a slice, indices or a mask."""
        columns = {name: x[rows] for name, x in vars(self).items() if isinstance(x, np.ndarray)}
        return replace(self, **columns)

    def first(self, count: int | None) -> Hits:
        """Return the first ``count`` collisions; None: all. Raise ValueError if it is negative."""
        if (count or 0) < 0:
            raise ValueError(f"the number of collisions must be 0 or more, not {count}")
        return self.some(slice(count))

    def among(self, scenarios: Collection[int]) -> Hits:
        """Return the collisions in the scenarios of these numbers."""
        return self.some(np.isin(self.scenario, list(scenarios)))


def find_hits(rows: Rows) -> Hits:
    """The collisions of an evaluation, in the order of its episodes."""
    table, crossings = rows[OUTCOMES], rows[CROSSINGS]
    whose = crossings.episode
    hit = (crossings.ped == table.contact_ped[whose]) & (crossings.last == table.steps[whose])
    enter = np.full(len(table.steps), -1)
    enter[whose[hit]] = crossings.enter[hit]
    earlier = np.maximum(table.steps - round(LEAD / rows.dt), 0)
    every = Hits(
        collisions=int(table.collision.sum()),
        dt=rows.dt,
        scenario=table.scenario,
        steps=table.steps,
        ped=table.contact_ped,
        contact=table.contact,
        moving=table.moving,
        entered=enter > 0,
        start=np.where(enter >= 0, enter, earlier),
    )
    return every.some(table.collision)


def _replay(
    street: Street, policies: Roles[Policy], source: Source, hits: Hits
) -> dict[str, Bool[np.ndarray, "collision"]]:
    """Return whether each change avoids each collision of a batch (false where it does not apply)."""
    scenarios, keys = source.take(hits.scenario)
    unchanged = play(street, policies, scenarios, keys, until=hits.steps)
    _check_same(measure_outcomes(unchanged, moving_speed=street.config.moving_speed), hits)
    crossing = unchanged.decisions[hits.steps, np.arange(len(hits.ped)), hits.ped] - 1
    watched = hits.steps + round(WATCHED / street.world.rules.dt)

    def avoids(change: Roles[Policy], scenarios: Scenario = scenarios) -> Bool[np.ndarray, "collision"]:
        return ~play(street, policies | change, scenarios, keys, until=watched).collision

    driver, people = policies["driver"], policies["pedestrian"]
    ped, start = jnp.asarray(hits.ped, jnp.int32), jnp.asarray(hits.start, jnp.int32)
    return {
        "crosswalk": avoids({}, on_the_crosswalk(scenarios, hits.ped, crossing)) & (hits.contact == JAYWALK),
        "wait": avoids({"pedestrian": Wait(people, ped, start - 1)}) & hits.entered,
        "brake": avoids({"driver": Brake(driver, start)}),
        "planner": avoids({"driver": TakeOver(driver, Oracle(), start)}),
        "planner_from_start": avoids({"driver": TakeOver(driver, Oracle(), jnp.zeros_like(start))}),
    }


def _check_same(replayed: Episodes, hits: Hits) -> None:
    """Raise ReplayError for the first collision that did not come back at the same step with the same pedestrian."""
    wrong = ~replayed.collision | (replayed.steps != hits.steps) | (replayed.contact_ped != hits.ped)
    for i in np.flatnonzero(wrong)[:1]:
        ends = f"with pedestrian {replayed.contact_ped[i]}" if replayed.collision[i] else "without a collision"
        raise ReplayError(
            f"scenario {hits.scenario[i]}: the rows have a collision with pedestrian {hits.ped[i]} at step "
            f"{hits.steps[i]}, but a replay without any change is at step {replayed.steps[i]} {ends}; are street, "
            "driver, pedestrians, seed and batch those of the evaluation?"
        )


@dataclass(frozen=True)
class Avoidable:
    """Some replayed collisions."""

    collisions: int
    labels: Mapping[str, Rate]
    """The share of each of `LABELS`."""
    avoided: Mapping[str, Rate]
    """For each of `CHANGES`, the share that it avoids of those to which it applies."""


@dataclass(frozen=True)
class CounterfactualSummary:
    """Shares of the replayed collisions, with Wilson intervals; what does not exist is None."""

    collisions: int
    """Of the evaluation, replayed or not."""
    replayed: int
    all: Avoidable
    crosswalk: Avoidable
    jaywalk: Avoidable
    sidewalk: Avoidable

    def as_dict(self) -> dict[str, Any]:
        """Plain nested dicts, numbers and None: ready for JSON."""
        return asdict(self)


def summarise_counterfactuals(table: Counterfactuals) -> CounterfactualSummary:
    """Who could have avoided the collisions, in all and by contact type."""
    return CounterfactualSummary(
        collisions=table.collisions,
        replayed=len(table.scenario),
        all=_avoidable(table, table.contact > 0),
        crosswalk=_avoidable(table, table.contact == CROSSWALK),
        jaywalk=_avoidable(table, table.contact == JAYWALK),
        sidewalk=_avoidable(table, table.contact == SIDEWALK),
    )


def _avoidable(table: Counterfactuals, mine: Bool[np.ndarray, "collision"]) -> Avoidable:
    """Those in ``mine``."""
    count = int(mine.sum())
    avoided = {}
    for change in CHANGES:
        applies = mine & getattr(table, f"{change}_applies", True)
        avoided[change] = wilson((getattr(table, change) & applies).sum(), applies.sum())
    labels = {label: wilson((mine & (table.label == label)).sum(), count) for label in LABELS}
    return Avoidable(count, labels, avoided)
