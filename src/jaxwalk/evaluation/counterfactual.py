"""Who could have avoided a collision? Replay every collision of an evaluation with one thing changed.

``docs/metrics.md``, Counterfactuals, explains the changes and the labels. A scenario holds all randomness and a step is
deterministic, so everything else stays the same until the change makes a difference.
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
from jaxwalk.metrics import CROSSINGS, OUTCOMES, Rate, Rows, proportion
from jaxwalk.metrics.outcomes import SIDEWALK, Episodes, measure_outcomes
from jaxwalk.policies import Oracle
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.relief import relieve
from jaxwalk.scenarios import Source
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario

SMALL_BATCH = 64
"""Default number of collisions replayed at once."""
WATCHED = 5.0
"""A collision is avoided if nobody is touched up to this long after it [s]; a later one is a different collision."""
LEAD = 3.0
"""A person hit on a sidewalk entered no road: the driver's action changes this long before, or from the start [s]."""
CHANGES = ("crosswalk", "wait", "brake", "planner", "planner_from_start")
"""The changes; each has its own replay."""
LABELS = ("either", "driver", "pedestrian", "unavoidable")
"""Who could have avoided a collision."""


class ReplayError(ValueError):
    """Raised if a collision does not recur in a replay without any change."""


@dataclass(frozen=True)
class Counterfactuals:
    """One row per replayed collision. Each column named in `CHANGES` says whether that change avoids the collision."""

    collisions: int
    """All collisions of the evaluation, replayed or not."""
    scenario: Int[np.ndarray, "collision"]
    contact: Int[np.ndarray, "collision"]
    """CROSSWALK, JAYWALK or SIDEWALK: what the touched pedestrian was doing."""
    moving: Bool[np.ndarray, "collision"]
    """Whether the car was moving."""
    notice: Float[np.ndarray, "collision"]
    """Time from road entry (on a sidewalk: from the driver's changed action) to the collision [s]."""
    crosswalk_applies: Bool[np.ndarray, "collision"]
    """Whether the pedestrian was a jaywalker."""
    wait_applies: Bool[np.ndarray, "collision"]
    """Whether the pedestrian had stepped into the road."""
    crosswalk: Bool[np.ndarray, "collision"]
    """The pedestrian crosses on the crosswalk (false if that does not apply)."""
    wait: Bool[np.ndarray, "collision"]
    """The pedestrian waits at the kerb (false if that does not apply)."""
    brake: Bool[np.ndarray, "collision"]
    """The car brakes fully from road entry on."""
    planner: Bool[np.ndarray, "collision"]
    """The oracle drives from road entry on."""
    planner_from_start: Bool[np.ndarray, "collision"]
    """The oracle drives all the way; the label does not use it."""

    @property
    def label(self) -> Shaped[np.ndarray, "collision"]:
        """The label of each collision as text: one of `LABELS`."""
        driver, pedestrian = self.brake | self.planner, self.crosswalk | self.wait
        return np.select([driver & pedestrian, driver, pedestrian], LABELS[:3], LABELS[3])


def counterfactuals(
    street: Street, policies: Roles[Policy], source: Source, hits: Hits, *,
    batch: int | None = None, progress: Progress | None = None,
) -> Counterfactuals:  # fmt: skip
    """Replay collisions of an evaluation, both unchanged and with each of `CHANGES`.

    Args:
        street: the world; this and the following must be the same as in the evaluation.
        policies: the policy of each role.
        source: the scenarios.
        hits: the collisions, from `find_hits`.
        batch: episodes played at once. By default `SMALL_BATCH`, which is quicker for few collisions; if rounding
            makes those replays differ, `BATCH`, which `evaluate` uses.
        progress: called after every batch with the number of collisions replayed so far, and the total.

    Raises:
        ReplayError: an unchanged replay ends differently from its row.
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
    relieve()
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
        full = np.resize(some, batch)  # repeated to a full batch, so that nothing is compiled again
        for change, answer in _replay(street, policies, source, hits.some(full)).items():
            avoided[change][some] = answer[: len(some)]
        if progress is not None:
            progress(int(some[-1]) + 1, count)
    return avoided


@dataclass(frozen=True)
class Hits:
    """Collisions of an evaluation, one row each."""

    collisions: int
    """All collisions of the evaluation, selected or not."""
    dt: float
    """Duration of a step [s]."""
    scenario: Int[np.ndarray, "collision"]
    steps: Int[np.ndarray, "collision"]
    """Frame of the contact."""
    ped: Int[np.ndarray, "collision"]
    """The pedestrian touched (the nearest if there are several)."""
    contact: Int[np.ndarray, "collision"]
    moving: Bool[np.ndarray, "collision"]
    entered: Bool[np.ndarray, "collision"]
    """Whether the pedestrian was hit on a roadway, and had entered it after frame 0."""
    start: Int[np.ndarray, "collision"]
    """Frame of the road entry; if hit on a sidewalk, the frame from which the driver's action changes."""

    def some(self, rows: slice | Shaped[np.ndarray, "row"]) -> Hits:
        """Return the rows selected by a slice, indices or a mask."""
        columns = {name: x[rows] for name, x in vars(self).items() if isinstance(x, np.ndarray)}
        return replace(self, **columns)

    def first(self, count: int | None) -> Hits:
        """Return the first ``count`` collisions, or all if it is None. Raise ValueError if it is negative."""
        if (count or 0) < 0:
            raise ValueError(f"the number of collisions must be 0 or more, not {count}")
        return self.some(slice(count))

    def among(self, scenarios: Collection[int]) -> Hits:
        """Return the collisions in the scenarios with these numbers."""
        return self.some(np.isin(self.scenario, list(scenarios)))


def find_hits(rows: Rows) -> Hits:
    """Return the collisions of an evaluation, in the order of its episodes."""
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
    """Return whether each change avoids each collision of a batch (false if it does not apply)."""
    scenarios, keys = source.take(hits.scenario)
    unchanged = play(street, policies, scenarios, keys, until=hits.steps)
    _check_same(measure_outcomes(unchanged, moving_speed=street.config.moving_speed), hits)
    crossing = unchanged.decisions[hits.steps, np.arange(len(hits.ped)), hits.ped] - 1
    watched = hits.steps + round(WATCHED / street.world.rules.dt)

    def avoids(change: Roles[Policy], scenarios: Scenario = scenarios) -> Bool[np.ndarray, "collision"]:
        return ~play(street, policies | change, scenarios, keys, until=watched).collision

    driver, people, oracle = policies["driver"], policies["pedestrian"], with_limits(Oracle(), street.config)
    ped, start = jnp.asarray(hits.ped, jnp.int32), jnp.asarray(hits.start, jnp.int32)
    return {
        "crosswalk": avoids({}, on_the_crosswalk(scenarios, hits.ped, crossing)) & (hits.contact == JAYWALK),
        "wait": avoids({"pedestrian": Wait(people, ped, start - 1)}) & hits.entered,
        "brake": avoids({"driver": Brake(driver, start)}),
        "planner": avoids({"driver": TakeOver(driver, oracle, start)}),
        "planner_from_start": avoids({"driver": TakeOver(driver, oracle, jnp.zeros_like(start))}),
    }


def _check_same(replayed: Episodes, hits: Hits) -> None:
    """Raise ReplayError for the first collision that does not recur at the same step with the same pedestrian."""
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
    """Who could have avoided a group of replayed collisions."""

    collisions: int
    labels: Mapping[str, Rate]
    """The share of each of `LABELS`."""
    avoided: Mapping[str, Rate]
    """For each of `CHANGES`, the share of collisions that it avoids among those to which it applies."""


@dataclass(frozen=True)
class CounterfactualSummary:
    """Shares of the replayed collisions, with `proportion`'s intervals; None: a number that does not exist."""

    collisions: int
    """All collisions of the evaluation, replayed or not."""
    replayed: int
    all: Avoidable
    crosswalk: Avoidable
    jaywalk: Avoidable
    sidewalk: Avoidable

    def as_dict(self) -> dict[str, Any]:
        """Return plain nested dicts, numbers and None: ready for JSON."""
        return asdict(self)


def summarise_counterfactuals(table: Counterfactuals) -> CounterfactualSummary:
    """Return who could have avoided the collisions, in total and by contact type."""
    return CounterfactualSummary(
        collisions=table.collisions,
        replayed=len(table.scenario),
        all=_avoidable(table, table.contact > 0),
        crosswalk=_avoidable(table, table.contact == CROSSWALK),
        jaywalk=_avoidable(table, table.contact == JAYWALK),
        sidewalk=_avoidable(table, table.contact == SIDEWALK),
    )


def _avoidable(table: Counterfactuals, mine: Bool[np.ndarray, "collision"]) -> Avoidable:
    """Summarise the collisions selected by ``mine``."""
    count = int(mine.sum())
    avoided = {}
    for change in CHANGES:
        applies = mine & getattr(table, f"{change}_applies", True)
        avoided[change] = proportion((getattr(table, change) & applies).sum(), applies.sum())
    labels = {label: proportion((mine & (table.label == label)).sum(), count) for label in LABELS}
    return Avoidable(count, labels, avoided)
