"""The number of updates of a training: the number asked for, or as many as fit into the time asked for."""

from __future__ import annotations

import time
from dataclasses import replace

import equinox as eqx
import jax
import numpy as np

from jaxwalk.learning.mappo import Learner
from jaxwalk.runs.session import Session

TRIAL_SECONDS, TRIAL_UPDATES = 3.0, 4
"""The rate is measured over at least this many seconds and updates; those updates are then discarded."""
OVERRUN = 1.1
"""A plan that turns out to take more than this many times its minutes is shortened."""


def with_plan(learner: Learner, updates: int) -> Learner:
    """Return the same learner with that number of updates planned."""
    planned = jax.device_put(np.int32(updates), learner.planned.sharding)
    return eqx.tree_at(lambda x: x.planned, learner, planned)


def replan(session: Session, learner: Learner, updates: int) -> Learner:
    """Return the learner with a new plan; write the plan into the run folder and show it."""
    experiment = session.run.experiment
    session.run.describe(replace(experiment, train=replace(experiment.train, updates=updates), minutes=None))
    session.progress.restart(updates)
    return with_plan(learner, updates)


def plan_by_time(session: Session, learner: Learner, limit: float) -> Learner:
    """Return the learner with as many updates planned as fit into the rest of the ``limit`` [s].

    The rate is measured on updates that are discarded, so the run equals one for which that number of updates was
    asked, on any machine. The quickest update counts, since other work may slow some down: a plan that is too long is
    shortened later, one that is too short would stay.
    """
    trial, metrics = session.update(learner)
    jax.block_until_ready(metrics)  # compiles here
    times: list[float] = []
    while len(times) < TRIAL_UPDATES or sum(times) < min(TRIAL_SECONDS, 0.1 * limit):
        begun = time.monotonic()
        trial, metrics = session.update(trial)
        jax.block_until_ready(metrics)
        times.append(time.monotonic() - begun)
        if session.seconds > limit or session.stop.requested:
            break
    return replan(session, learner, max(1, int((limit - session.seconds) / min(times))))


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
