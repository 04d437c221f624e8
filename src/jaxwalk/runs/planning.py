"""The number of updates of a training: the number asked for, or as many as fit into the time asked for."""

from __future__ import annotations

import math
import time
from collections import deque
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
OVERRUN, WINDOW = 1.1, 0.2
"""A plan is shortened if the rest of it would take more than this many times the time that is left, and one more
update; it is lengthened again if this many times its rest would take less. The pace is that of the newest updates:
this share of the first plan."""


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
    shortened later, one that is too short stays (`UpdatePlan`). Of several processes, the first one measures for all.
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


class UpdatePlan:
    """The number of updates that a session plans to have made: fewer while the machine is too slow for its time."""

    def __init__(self, made: int, planned: int, cycle: int = 1) -> None:
        """Begin after ``made`` updates; ``planned`` is the most that it will ever be.

        Updates of one ``cycle`` may take different times, so the pace is measured over whole ones.
        """
        self.updates = self._most = planned
        self._window = cycle * max(1, math.ceil(WINDOW * (planned - made) / cycle))
        self._newest = deque([(made, time.monotonic())], maxlen=self._window + 1)
        """Numbers of updates made, and when that was so [s]."""
        self._changed = made

    def follow(self, made: int, left: float) -> int:
        """Return the number planned from now on, which is above ``made`` until the plan is done.

        Call it before or after each update; ``left`` is the time that is left [s]. The plan becomes what fits, if it
        would overrun its time, or if more would fit after it was shortened.
        """
        if made > self._newest[-1][0]:
            self._newest.append((made, time.monotonic()))
        if len(self._newest) <= self._window or made >= self.updates:
            return self.updates
        each = max(self._newest[-1][1] - self._newest[0][1], 1e-9) / self._window
        rest = self.updates - made
        too_long = rest * each > OVERRUN * left + each
        settled = made - self._changed >= self._window / 2 or rest == 1  # a pace that still rises is waited for
        too_short = self.updates < self._most and OVERRUN * rest * each < left
        if too_long or (too_short and settled):
            self.updates, self._changed = min(self._most, made + max(1, int(left / each))), made
        return self.updates
