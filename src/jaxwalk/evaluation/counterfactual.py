"""Who could have avoided a collision? Replay every collision of an evaluation with one thing changed.

``docs/metrics.md``, Counterfactuals, explains the changes and the labels. A scenario holds all randomness and a step is
deterministic, so everything else stays the same until the change makes a difference.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Bool, Float, Int, Shaped

from jaxwalk.evaluation.batches import Progress, episodes_at_once
from jaxwalk.evaluation.hits import Hits
from jaxwalk.evaluation.interventions import Since, on_the_crosswalk, with_changes
from jaxwalk.evaluation.playing import play
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.metrics.outcomes import Episodes, measure_outcomes
from jaxwalk.relief import relieve
from jaxwalk.scenarios import Source
from jaxwalk.sim.crossing_kind import JAYWALK
from jaxwalk.sim.environment import Street
from jaxwalk.sim.events import distance
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.trajectory import Trajectory

SMALL_BATCH = 64
"""Default number of collisions replayed at once."""
WATCHED = 5.0
"""A collision is avoided if nobody is touched up to this long after it [s]; a later one is a different collision."""
CHANGES = (
    "crosswalk", "wait", "brake", "planner", "planner_from_start",
    "human_when_seen", "human_from_start", "brake_when_seen", "planner_when_seen",
)  # fmt: skip
"""The changes; each has its own replay. The planner is the `Oracle`."""
LABELS = ("either", "driver", "pedestrian", "unavoidable")
"""Who could have avoided a collision."""
JUDGEMENTS = ("human", "oracle", "unavoidable")
"""Which driver in the car's place could have avoided a collision: a careful human, or only one who knows the future."""


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
    seen_for: Float[np.ndarray, "collision"]
    """Time from the moment at which the car first perceived the pedestrian to the collision [s]."""
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
    human_when_seen: Bool[np.ndarray, "collision"]
    """The careful human drives from the moment at which the car first perceived the pedestrian."""
    human_from_start: Bool[np.ndarray, "collision"]
    """The careful human drives all the way."""
    brake_when_seen: Bool[np.ndarray, "collision"]
    """The car brakes fully from the moment at which it first perceived the pedestrian."""
    planner_when_seen: Bool[np.ndarray, "collision"]
    """The oracle drives from that moment."""

    @property
    def label(self) -> Shaped[np.ndarray, "collision"]:
        """The label of each collision as text: one of `LABELS`."""
        driver, pedestrian = self.brake | self.planner, self.crosswalk | self.wait
        return np.select([driver & pedestrian, driver, pedestrian], LABELS[:3], LABELS[3])

    @property
    def judged(self) -> Shaped[np.ndarray, "collision"]:
        """The judgement of each collision, one of `JUDGEMENTS`, with others at the wheel once the person was seen."""
        return judgements(self.human_when_seen, self.planner_when_seen | self.brake_when_seen)

    @property
    def judged_from_start(self) -> Shaped[np.ndarray, "collision"]:
        """The same with others at the wheel all the way."""
        return judgements(self.human_from_start, self.planner_from_start)


def judgements(
    human: Bool[np.ndarray, "collision"], oracle: Bool[np.ndarray, "collision"]
) -> Shaped[np.ndarray, "collision"]:
    """Return the judgements, given which collisions each driver avoids."""
    return np.select([human, oracle], JUDGEMENTS[:2], JUDGEMENTS[2])


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
            makes those replays differ, as many as `evaluate` plays.
        progress: called after every batch with the number of collisions replayed so far, and the total.

    Raises:
        ReplayError: an unchanged replay ends differently from its row.
        ValueError: ``batch`` is below 1.
    """
    if batch is not None and batch < 1:
        raise ValueError(f"batch must be at least 1, not {batch}")
    replayed = partial(_replay_all, street, policies, source, hits, progress)
    try:
        found = replayed(batch or SMALL_BATCH)
    except ReplayError:
        usual = episodes_at_once(street, policies)
        if batch is not None or usual == SMALL_BATCH:
            raise
        found = replayed(usual)
    relieve()
    return Counterfactuals(
        collisions=hits.collisions,
        scenario=hits.scenario,
        contact=hits.contact,
        moving=hits.moving,
        notice=(hits.steps - hits.start) * hits.dt,
        crosswalk_applies=hits.contact == JAYWALK,
        wait_applies=hits.entered,
        **found,
    )


def _replay_all(
    street: Street, policies: Roles[Policy], source: Source, hits: Hits, progress: Progress | None, batch: int
) -> dict[str, Shaped[np.ndarray, "collision"]]:
    """Return what `_replay` does of all collisions; ``batch`` of them are replayed at once."""
    count = len(hits.scenario)
    found: dict[str, np.ndarray] = {"seen_for": np.zeros(count)} | {change: np.zeros(count, bool) for change in CHANGES}
    for first in range(0, count, batch):
        some = np.arange(first, min(first + batch, count))
        full = np.resize(some, batch)  # repeated to a full batch, so that nothing is compiled again
        for column, answer in _replay(street, policies, source, hits.some(full)).items():
            found[column][some] = answer[: len(some)]
        if progress is not None:
            progress(int(some[-1]) + 1, count)
    return found


def _replay(
    street: Street, policies: Roles[Policy], source: Source, hits: Hits
) -> dict[str, Shaped[np.ndarray, "collision"]]:
    """Return for how long each pedestrian of a batch had been seen, and whether each change avoids the collision.

    A change that doesn't apply avoids nothing.
    """
    scenarios, keys = source.take(hits.scenario)

    def replayed(since: Since, until: Int[np.ndarray, "collision"], scenarios: Scenario = scenarios) -> Trajectory:
        return play(street, with_changes(street, policies, hits.ped, since), scenarios, keys, until=until)

    unchanged = replayed(Since(), hits.steps)
    _check_same(measure_outcomes(unchanged, moving_speed=street.config.moving_speed), hits)
    crossing = unchanged.decisions[hits.steps, np.arange(len(hits.ped)), hits.ped] - 1
    seen = first_seen_frame(street, unchanged, hits.ped, hits.steps)
    watched = hits.steps + round(WATCHED / street.world.rules.dt)

    def avoids(since: Since, scenarios: Scenario = scenarios) -> Bool[np.ndarray, "collision"]:
        return ~replayed(since, watched, scenarios).collision

    on_crosswalk = on_the_crosswalk(scenarios, hits.ped, crossing)
    return {
        "seen_for": (hits.steps - seen) * hits.dt,
        "crosswalk": avoids(Since(), on_crosswalk) & (hits.contact == JAYWALK),
        "wait": avoids(Since(wait=hits.start - 1)) & hits.entered,
        "brake": avoids(Since(brake=hits.start)),
        "planner": avoids(Since(oracle=hits.start)),
        "planner_from_start": avoids(Since(oracle=0 * hits.start)),
        "human_when_seen": avoids(Since(human=seen)),
        "human_from_start": avoids(Since(human=0 * hits.start)),
        "brake_when_seen": avoids(Since(brake=seen)),
        "planner_when_seen": avoids(Since(oracle=seen)),
    }


def first_seen_frame(
    street: Street, played: Trajectory, ped: Int[np.ndarray, "episode"], frame: Int[np.ndarray, "episode"]
) -> Int[np.ndarray, "episode"]:
    """Return the first frame in which the car perceived a pedestrian of each episode; at the latest a given one.

    In a world where everybody is visible, it is the first frame with the pedestrian within the range of sight of the
    car's eye, which is at its front axle.
    """
    episode = np.arange(len(ped))
    if played.perceived is not None:
        seen = played.perceived[:, episode, ped]
    else:
        eye = street.config.wheelbase / 2
        dx = played.ped_x[:, episode, ped] - (played.car_x + eye * played.car_cos)
        dy = played.ped_y[:, episode, ped] - (played.car_y + eye * played.car_sin)
        seen = distance(dx, dy) <= street.config.sight
    at_the_latest = np.arange(len(seen))[:, None] >= frame
    return (seen | at_the_latest).argmax(axis=0)


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
