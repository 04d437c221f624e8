"""Would a careful human or the oracle have avoided a failure? As `jaxwalk.evaluation.counterfactual` asks it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int, Shaped

from jaxwalk.evaluation.counterfactual import WATCHED, ReplayError, judgements
from jaxwalk.evaluation.interventions import Since, with_changes
from jaxwalk.evaluation.playing import play
from jaxwalk.scenarios.archived import keys_of, scenarios_at
from jaxwalk.search.critical import CriticalMoments
from jaxwalk.search.cube import Candidates
from jaxwalk.search.driving import SMALL_PART, Driving
from jaxwalk.sim.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Avoidability:
    """Who would have avoided each failure: one of `JUDGEMENTS`."""

    when_seen: Shaped[np.ndarray, "failure"]
    """With others at the wheel from when the car first perceived the person."""
    from_start: Shaped[np.ndarray, "failure"]
    """With others at the wheel all the way."""


def judge(
    game: Driving,
    failures: Candidates,
    moments: CriticalMoments,
    *,
    batch: int = SMALL_PART,
    tell: Callable[[int], None] = lambda judged: None,
) -> Avoidability:
    """Play failures again with others at the wheel; avoided is what touches nobody up to `WATCHED` after the contact.

    ``tell`` is called with how many have been judged. If rounding makes replays in small batches differ, they are
    played in those of an evaluation.

    Raises:
        ReplayError: a failure doesn't recur.
    """
    try:
        parts = []
        for first in range(0, len(failures), batch):
            tell(first)
            rows = np.arange(first, min(first + batch, len(failures)))
            parts.append(_judge(game, failures, moments, rows, batch))
    except ReplayError:
        if batch == game.at_once:
            raise
        return judge(game, failures, moments, batch=game.at_once, tell=tell)
    return Avoidability(
        *(np.concatenate([getattr(one, name) for one in parts]) for name in ("when_seen", "from_start"))
    )


def _judge(
    game: Driving, failures: Candidates, moments: CriticalMoments, rows: Int[np.ndarray, "row"], batch: int
) -> Avoidability:
    full = np.resize(rows, batch)  # repeated to a full batch, so that nothing is compiled again
    some, street = moments.some(full), game.street
    scenarios = scenarios_at(street, failures.points[full])
    keys = keys_of(game.seed, failures.keys[full])
    watched = some.frame + round(WATCHED / street.world.rules.dt)

    def replayed(since: Since, until: Int[np.ndarray, "row"]) -> Trajectory:
        return play(street, with_changes(street, game.policies, some.ped, since), scenarios, keys, until=until)

    def avoids(since: Since) -> Bool[np.ndarray, "row"]:
        return ~replayed(since, watched).collision[: len(rows)]

    again = replayed(Since(), some.frame)
    touched = again.touched[np.arange(batch), some.ped]
    if not (again.collision & (again.length == some.frame) & touched).all():
        raise ReplayError("a failure doesn't recur when it is played again; is the driver the same in every run?")
    seen, start = some.seen, 0 * some.seen
    return Avoidability(
        judgements(avoids(Since(human=seen)), avoids(Since(oracle=seen)) | avoids(Since(brake=seen))),
        judgements(avoids(Since(human=start)), avoids(Since(oracle=start))),
    )
