"""Could it have been avoided, and by whom? Every collision of an evaluation, replayed with one thing changed.

What is changed, and what a label means: ``docs/metrics.md``, Counterfactuals. A scenario holds all chance and a step
none, so everything else is as it was until the change makes a difference.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from jaxwalk.evaluation.game import play
from jaxwalk.evaluation.interventions import Brake, Intervention, TakeOver, Wait, on_the_crosswalk
from jaxwalk.evaluation.scenarios import BATCH, choose_scenarios
from jaxwalk.interfaces import Policy
from jaxwalk.metrics import Rate, Rows, wilson
from jaxwalk.metrics.outcomes import SIDEWALK, Episodes, measure_outcomes
from jaxwalk.policies import Oracle
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.trajectory import CROSSWALK, JAYWALK

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
    street: Street,
    driver: Policy,
    pedestrians: Policy,
    rows: Rows,
    *,
    seed: int,
    batch: int = BATCH,
    at_most: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Counterfactuals:
    """Replay the collisions of an evaluation, unchanged and with each of `CHANGES`.

    Args:
        street: the world; this and the following as they were for the evaluation.
        driver: decides for the car.
        pedestrians: decides for all people.
        rows: what `evaluate` gave.
        seed: of the scenarios.
        batch: episodes played at once.
        at_most: replay only so many collisions, the first ones of ``rows``.
        progress: called after every batch with the collisions replayed so far and those to replay.

    Raises:
        ReplayError: an unchanged replay ends otherwise than the row says.
        ValueError: ``at_most`` is negative.
    """
    if at_most is not None and at_most < 0:
        raise ValueError(f"at_most must be 0 or more, not {at_most}")
    table, enter = rows.episodes, _entries(rows)
    chosen = np.flatnonzero(table.collision)[:at_most]
    start = np.where(enter >= 0, enter, np.maximum(table.steps - round(LEAD / rows.dt), 0))
    avoided = {change: np.zeros(len(chosen), bool) for change in CHANGES}
    for first in range(0, len(chosen), batch):
        some = slice(first, first + batch)
        these = np.resize(chosen[some], batch)  # always a full batch, so that nothing is compiled twice
        found = _replay(street, driver, pedestrians, table, these, start[these], seed)
        for change in CHANGES:
            avoided[change][some] = found[change][: len(chosen[some])]
        if progress is not None:
            progress(min(first + batch, len(chosen)), len(chosen))
    jaywalked, entered = table.contact[chosen] == JAYWALK, enter[chosen] > 0
    return Counterfactuals(
        collisions=int(table.collision.sum()),
        scenario=table.scenario[chosen],
        contact=table.contact[chosen],
        moving=table.moving[chosen],
        notice=(table.steps - start)[chosen] * rows.dt,
        crosswalk_applies=jaywalked,
        wait_applies=entered,
        **avoided | {"crosswalk": avoided["crosswalk"] & jaywalked, "wait": avoided["wait"] & entered},
    )


def _entries(rows: Rows) -> Int[np.ndarray, "episode"]:
    """First frame of the crossing in which the pedestrian touched was hit; -1 on a sidewalk and without a collision."""
    crossings, table = rows.crossings, rows.episodes
    whose = crossings.episode
    hit = (crossings.ped == table.contact_ped[whose]) & (crossings.last == table.steps[whose])
    enter = np.full(len(table.steps), -1)
    enter[whose[hit]] = crossings.enter[hit]
    return enter


def _replay(
    street: Street,
    driver: Policy,
    pedestrians: Policy,
    table: Episodes,
    these: Int[np.ndarray, "episode"],
    start: Int[np.ndarray, "episode"],
    seed: int,
) -> dict[str, Bool[np.ndarray, "episode"]]:
    """A batch of collisions, rows ``these`` of the table: whether each change avoids them; it begins at ``start``."""
    scenarios, keys = choose_scenarios(street, seed=seed, numbers=table.scenario[these])
    steps, ped = table.steps[these], table.contact_ped[these]
    unchanged = play(street, driver, pedestrians, scenarios, keys, until=steps)
    _check_same(measure_outcomes(unchanged, moving_speed=street.config.moving_speed), table, these)
    decided = unchanged.decisions[steps, np.arange(len(steps)), ped] - 1

    def avoids(scenarios: Scenario, change: Intervention | None) -> Bool[np.ndarray, "episode"]:
        watched = steps + round(WATCHED / street.config.dt)
        return ~play(street, driver, pedestrians, scenarios, keys, intervention=change, until=watched).collision

    from_step = jnp.asarray(start, jnp.int32)
    return {
        "crosswalk": avoids(on_the_crosswalk(scenarios, ped, decided), None),
        "wait": avoids(scenarios, Wait(jnp.asarray(ped, jnp.int32), from_step - 1)),
        "brake": avoids(scenarios, Brake(from_step)),
        "planner": avoids(scenarios, TakeOver(Oracle(), from_step)),
        "planner_from_start": avoids(scenarios, TakeOver(Oracle(), jnp.zeros_like(from_step))),
    }


def _check_same(replayed: Episodes, table: Episodes, these: Int[np.ndarray, "episode"]) -> None:
    """Raise ReplayError for the first collision that did not come back at the same step with the same pedestrian."""
    steps, ped = table.steps[these], table.contact_ped[these]
    wrong = ~replayed.collision | (replayed.steps != steps) | (replayed.contact_ped != ped)
    if wrong.any():
        i = int(np.flatnonzero(wrong)[0])
        again = "none"
        if replayed.collision[i]:
            again = f"one with pedestrian {replayed.contact_ped[i]} at step {replayed.steps[i]}"
        raise ReplayError(
            f"scenario {table.scenario[these[i]]}: the rows have a collision with pedestrian {ped[i]} at step "
            f"{steps[i]}, a replay without any change has {again}; are street, driver, pedestrians, seed and batch "
            "those of the evaluation?"
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
