"""The host's side of training: updates in a loop, with a plan, progress, metrics on disk and checkpoints."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import Any

import equinox as eqx
import jax
import numpy as np
from rich.console import Console

from jaxwalk.learning import checkpoint, mappo
from jaxwalk.learning.config import TrainConfig
from jaxwalk.learning.mappo import Learner
from jaxwalk.policies import read_metadata, save_policy
from jaxwalk.rollout import TRAINING, seed_key
from jaxwalk.runs.folder import MetricsLog, Run, RunError
from jaxwalk.runs.lock import held
from jaxwalk.runs.progress import Pace, TrainingProgress
from jaxwalk.runs.provenance import provenance
from jaxwalk.runs.stop import Stop
from jaxwalk.runs.street import fixed_policies, make_street
from jaxwalk.runs.watch import WatchPage, there_is_one
from jaxwalk.sim.environment import Street
from jaxwalk.writing import remove_unfinished

CHECKPOINT_MINUTES = 2.0
"""Minutes between checkpoints."""
TRIAL_SECONDS, TRIAL_UPDATES = 3.0, 4
"""The rate is that of the quickest of at least so many seconds' and so many updates, which are then thrown away."""
OVERRUN = 1.1
"""A plan that turns out to take more than this times its minutes is shortened."""


@dataclass(frozen=True)
class Trained:
    """How a training ended."""

    updates: int
    """Made in all."""
    steps: int
    """Environment steps in all."""
    seconds: float
    """Spent training, over all its sessions, compiling included."""
    interrupted: bool
    """Somebody pressed Ctrl-C; it can be resumed."""


class DivergedError(RunError):
    """Training met a number that is not finite."""


class UnwrittenError(RunError):
    """Training could not write into its folder, as on a full disk."""


@dataclass
class Session:
    """One sitting of a training."""

    run: Run
    config: TrainConfig
    """The run's, but with 1 planned update, since the learner holds the plan: so a new plan compiles nothing anew."""
    street: Street
    log: MetricsLog
    progress: TrainingProgress
    stop: Stop
    page: WatchPage | None = None
    """Where it can be watched."""
    begun: float = field(default_factory=time.monotonic)
    earlier: float = 0.0
    """Seconds spent by earlier sessions."""
    saved: float = field(default_factory=time.monotonic)
    """When the last checkpoint was written."""

    @property
    def seconds(self) -> float:
        """Spent in all sessions."""
        return self.earlier + time.monotonic() - self.begun

    def update(self, learner: Learner) -> tuple[Learner, Any]:
        """One update; on its way when this returns."""
        return mappo.update(self.street, self.config, learner)

    def record(self, metrics: Any, updates: int, before: Learner) -> None:
        """Write and show the metrics of an update, waiting for it if need be.

        If it gave numbers that are not finite, the learner of ``before`` is saved and DivergedError raised.
        """
        values = {name: float(value) for name, value in jax.device_get(metrics).items()}
        if not values.pop("finite"):
            self.save(before)
            raise DivergedError(
                f"{self.run.path}: update {updates} gave numbers that are not finite; checkpoint and policy of update "
                f"{updates - 1} are kept. Train anew with a lower --learning-rate or --reward-scale, or another --seed"
            )
        values["steps"] = updates * self.run.experiment.steps_per_update
        line = {"update": updates, "seconds": round(self.seconds, 3), **values}
        self.log.write(line)
        self.progress.show(updates, values)
        if self.page is not None:
            self.page.show(line)

    def save(self, learner: Learner) -> None:
        """Write a checkpoint and the policy of a learner whose last update was recorded: its numbers are finite."""
        updates = int(learner.updates)
        self.log.to_disk()  # a checkpoint without its metrics would leave a gap
        if checkpoint.latest(self.run.checkpoints) != updates:
            checkpoint.save(self.run.checkpoints, learner, updates=updates)
        save_policy(self.run.policy, learner, policy_metadata(self.run, updates))
        self.saved = time.monotonic()


def is_finished(run: Run) -> bool:
    """Whether the planned updates are made and the policy is the last one's."""
    if run.experiment.minutes is not None or not run.policy.is_file():
        return False
    return read_metadata(run.policy).get("updates", 0) >= run.experiment.train.updates


def policy_metadata(run: Run, updates: int) -> dict[str, Any]:
    """Where a policy comes from."""
    experiment = run.experiment
    made = {"updates": updates, "steps": updates * experiment.steps_per_update}
    chosen = {"recipe": experiment.recipe, "single_agent": experiment.single_agent, "seed": experiment.seed}
    chosen["maps"] = list(experiment.maps)
    return chosen | made | asdict(provenance())


def train(
    run: Run,
    *,
    resume: bool = False,
    console: Console | None = None,
    name: str = "training",
    checkpoint_minutes: float = CHECKPOINT_MINUTES,
    watch: bool = False,
    street: Street | None = None,
) -> Trained:
    """Train until the run's planned number of updates, or go on until there.

    Where the experiment says minutes, as many updates are planned as fit into them, compiling included.

    Args:
        run: a folder made by `Run.create`, or an opened one to resume.
        resume: go on from the newest checkpoint.
        console: where progress goes; standard error by default.
        name: what to call this training there.
        checkpoint_minutes: minutes between checkpoints.
        watch: write a page into the run folder that shows how it goes; one that is there is gone on with anyway.
        street: `make_street` of the run's experiment, if it is made already.

    Raises:
        DivergedError: numbers are not finite any more.
        InUseError: another process trains there.
        UnwrittenError: the disk is full, or the like.
        CheckpointError: no checkpoint can be gone on from.
    """
    console = console or Console(stderr=True)
    with held(run.path), _telling_what_is_kept(run):
        remove_unfinished(run.path)
        return _train(run, street or make_street(run.experiment), resume, console, name, checkpoint_minutes, watch)


@contextmanager
def _telling_what_is_kept(run: Run) -> Iterator[None]:
    """While inside, an OSError says what there is to go on from."""
    try:
        yield
    except OSError as error:
        what = f"{error.filename}: {error.strerror}" if error.filename else str(error)
        raise UnwrittenError(
            f"{run.path}: training stopped ({what}); {_kept(run)}. "
            f"Mend that, then go on with: jaxwalk train --resume {run.path}"
        ) from error


def _kept(run: Run) -> str:
    updates = checkpoint.latest(run.checkpoints)
    return "there is no checkpoint yet" if updates is None else f"the checkpoint of update {updates} is kept"


def _train(
    run: Run, street: Street, resume: bool, console: Console, name: str, checkpoint_minutes: float, watch: bool
) -> Trained:  # fmt: skip
    """`train`, alone in the folder."""
    begun, minutes = time.monotonic(), run.experiment.minutes
    config = replace(run.experiment.train, updates=1)
    learner = begin(run, street, config, resume=resume, tell=partial(console.print, soft_wrap=True, markup=False))
    done, planned = int(learner.updates), int(learner.planned)
    per_update = run.experiment.steps_per_update
    pace = Pace(done, planned, per_update)
    progress, stop = TrainingProgress(console, name, pace), Stop()
    if config.shards > 1:
        console.print(f"{name}: {config.environments:,} environments on {config.shards} devices", markup=False)
    with MetricsLog(run, updates=done) as log, stop.listening(), progress, _page(run, name, pace, log, watch) as page:
        if page is not None:
            console.print(f"Watch it: open {page.path.absolute()} in a browser", soft_wrap=True, markup=False)
        earlier = log.kept[-1]["seconds"] if log.kept else 0.0
        session = Session(run, config, street, log, progress, stop, page, begun=begun, earlier=earlier)
        if minutes is not None:
            learner = _planned(session, learner, 60 * minutes)
        learner = _loop(session, learner, 60 * minutes if minutes else math.inf, 60 * checkpoint_minutes)
    updates = int(learner.updates)
    interrupted = updates < int(learner.planned)
    return Trained(updates, updates * per_update, session.seconds, interrupted)


def _page(run: Run, name: str, pace: Pace, log: MetricsLog, watch: bool) -> AbstractContextManager[WatchPage | None]:
    """The page to watch, if it is wanted or there: nobody should be told that a training that goes on has stopped."""
    return WatchPage(run, name, pace, log.kept) if watch or there_is_one(run.path) else nullcontext()


def begin(
    run: Run, street: Street, config: TrainConfig, *, resume: bool, tell: Callable[[str], None] = print
) -> Learner:
    """An untrained learner, or the one of the newest checkpoint that can be read; with the run's plan.

    The plan may have been shortened after the checkpoint. ``tell`` is called with a line about each damaged checkpoint.
    """
    experiment = run.experiment
    learner = mappo.init(street, config, seed_key(experiment.seed, TRAINING), others=fixed_policies(experiment))
    if resume:
        found = checkpoint.restore_newest(run.checkpoints, learner, tell=tell)
        learner = learner if found is None else found
    return _plan(learner, experiment.train.updates)


def _loop(session: Session, learner: Learner, limit: float, checkpoint_seconds: float) -> Learner:
    """Update after update; each one's metrics are fetched while the next one runs."""
    waiting: tuple[Any, int, Learner] | None = None
    done = int(learner.updates)
    begun, first, planned = time.monotonic(), done, int(learner.planned)
    while done < planned and not session.stop.requested:
        before = learner
        learner, metrics = session.update(before)
        done += 1
        if waiting:
            session.record(*waiting)
        waiting = (metrics, done, before)
        if time.monotonic() - session.saved > checkpoint_seconds:
            session.record(*waiting)
            waiting = None
            session.save(learner)
        shorter = _shortened(session, begun, done - first, planned - first, limit)
        if shorter is not None:
            planned = first + shorter
            learner = _with_plan(session, learner, planned)
    if waiting:
        session.record(*waiting)
    session.save(learner)
    return learner


def _planned(session: Session, learner: Learner, limit: float) -> Learner:
    """The same learner, with as many updates planned as fit into what is left of the ``limit`` [s].

    The rate is measured on updates that are thrown away: so the run is the same as one with that number of updates
    asked for, whatever the machine. The quickest one counts, since a machine may falter: too long a plan is shortened
    later, too short a one would stay.
    """
    trial, metrics = session.update(learner)
    jax.block_until_ready(metrics)  # compiled now
    times: list[float] = []
    while len(times) < TRIAL_UPDATES or sum(times) < min(TRIAL_SECONDS, 0.1 * limit):
        begun = time.monotonic()
        trial, metrics = session.update(trial)
        jax.block_until_ready(metrics)
        times.append(time.monotonic() - begun)
        if session.seconds > limit or session.stop.requested:
            break
    return _with_plan(session, learner, max(1, int((limit - session.seconds) / min(times))))


def _with_plan(session: Session, learner: Learner, planned: int) -> Learner:
    experiment = session.run.experiment
    session.run.describe(replace(experiment, train=replace(experiment.train, updates=planned), minutes=None))
    session.progress.restart(planned)
    return _plan(learner, planned)


def _plan(learner: Learner, updates: int) -> Learner:
    planned = jax.device_put(np.int32(updates), learner.planned.sharding)
    return eqx.tree_at(lambda x: x.planned, learner, planned)


def _shortened(session: Session, begun: float, made: int, planned: int, limit: float) -> int | None:
    """A smaller number of updates in all, if at the present rate the plan would overrun the limit [s]."""
    if made < 0.2 * planned or made >= planned:
        return None
    each = (time.monotonic() - begun) / made
    left = limit - session.seconds
    if (planned - made) * each <= OVERRUN * max(left, 0.0) + each:
        return None
    return made + max(1, int(left / each))
