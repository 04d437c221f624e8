"""The number of updates of a training: the number asked for, or as many as fit into the time asked for."""

from __future__ import annotations

import time
from dataclasses import replace

import equinox as eqx
import jax
import numpy as np

from jaxwalk.learning.mappo import Learner
from jaxwalk.peers import ask, is_first
from jaxwalk.runs.session import Session

TRIAL_SECONDS, TRIAL_CYCLES = 3.0, 4
"""The rate is measured over at least this many seconds and cycles; their updates are then discarded. A cycle is one
update, or one with each number of people."""
OVERRUN = 1.1
"""A plan that turns out to take more than this many times its minutes is shortened."""


def with_plan(learner: Learner, updates: int) -> Learner:
    """Return the same learner with that number of updates planned."""
    planned = jax.make_array_from_callback((), learner.planned.sharding, lambda _: np.asarray(updates, np.int32))
    return eqx.tree_at(lambda x: x.planned, learner, planned)


def replan(session: Session, learner: Learner, updates: int) -> Learner:
    """Return the learner with a new plan; write the plan into the run folder and show it."""
    experiment = session.run.experiment
    planned = replace(experiment, train=replace(experiment.train, updates=updates), minutes=None)
    session.run.describe(planned, write=is_first())
    session.progress.restart(updates)
    return with_plan(learner, updates)


def plan_by_time(session: Session, learner: Learner, limit: float) -> Learner:
    """Return the learner with as many updates planned as fit into the rest of the ``limit`` [s].

    The rate is measured on updates that are discarded, so the run equals one for which that number of updates was
    asked, on any machine. The quickest cycle counts, since other work may slow some down: a plan that is too long is
    shortened later, one that is too short would stay. Of several processes, the first one measures for all.
    """
    trial = _cycle(session, learner)  # compiles here
    times: list[float] = []

    def enough() -> tuple[int, ...]:
        late = session.seconds > limit or session.stop.requested
        known = len(times) >= TRIAL_CYCLES and sum(times) >= min(TRIAL_SECONDS, 0.1 * limit)
        return (int(is_first() and bool(times) and (late or known)),)

    while not any(ask(enough)()):
        begun = time.monotonic()
        trial = _cycle(session, trial)
        times.append(time.monotonic() - begun)
    each = min(times) / len(session.turns)
    fitting = max(1, int((limit - session.seconds) / each))
    return replan(session, learner, *ask(lambda: [fitting if is_first() else 0])())


def _cycle(session: Session, learner: Learner) -> Learner:
    """Return the learner after an update with each number of people."""
    for turn in range(len(session.turns)):
        learner, metrics = session.update(learner, turn)
        jax.block_until_ready(metrics)
    return learner


def shortened(planned: int, made: int, *, each: float, left: float) -> int | None:
    """Return a smaller number of updates if the planned one would overrun its time; None if it would not.

    Args:
        planned: updates planned for this session.
        made: those already made by it.
        each: time of an update so far [s].
        left: time that is left [s].
    """
    overruns = (planned - made) * each > OVERRUN * max(left, 0.0) + each
    if made < 0.2 * planned or made >= planned or not overruns:
        return None
    return made + max(1, int(left / each))
