"""The host's side of training: runs updates in a loop, with a plan, progress, metrics on disk and checkpoints."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
from rich.console import Console

from jaxwalk.learning import checkpoint
from jaxwalk.learning.mappo import Learner
from jaxwalk.learning.turns import init_in_turns
from jaxwalk.peers import ask, is_first, several, wait_for_all
from jaxwalk.policies import read_metadata
from jaxwalk.rollout import TRAINING, seed_key
from jaxwalk.runs.binding import check_bound
from jaxwalk.runs.folder import MetricsLog, NoLog, Run, RunError
from jaxwalk.runs.kept_archives import archive_hashes, said_of_archives
from jaxwalk.runs.kept_maps import MAPS, keep_maps
from jaxwalk.runs.lock import held
from jaxwalk.runs.peer_lost import explaining_lost_peers
from jaxwalk.runs.planning import UpdatePlan, plan_by_time, replan, with_plan
from jaxwalk.runs.progress import Display, Pace, TrainingProgress
from jaxwalk.runs.session import OnUpdate, Routine, Session
from jaxwalk.runs.stop import Stop
from jaxwalk.runs.street import crowded, fixed_policies, make_street
from jaxwalk.runs.watch import WatchPage, there_is_one
from jaxwalk.runs.watchdog import Watchdog
from jaxwalk.sim.environment import Street
from jaxwalk.writing import remove_unfinished

CHECKPOINT_MINUTES = 2.0
"""Minutes between checkpoints."""


@dataclass(frozen=True)
class TrainingEnd:
    """How a training ended."""

    updates: int
    """Updates made by all sessions of the training."""
    steps: int
    """Environment steps made by all sessions of the training."""
    seconds: float
    """Time spent by all sessions of the training, including compiling [s]."""
    interrupted: bool
    """Whether Ctrl-C or another signal ended it; it can be resumed."""
    stopped: bool = False
    """Whether ``on_update`` ended it before the plan was done; it can be resumed."""
    heard: bool = False
    """Whether a signal came, perhaps too late to interrupt it: who trains several should begin no other one."""


class UnwrittenError(RunError):
    """Training could not write into its folder, for example because the disk is full."""


def is_finished(run: Run, updates: int | None = None) -> bool:
    """Return whether all planned updates are made and the saved policy is the last one's, of this configuration.

    With a number of updates: whether that many are made.
    """
    if run.experiment.minutes is not None or not run.policy.is_file():
        return False
    made, wanted = read_metadata(run.policy), updates or run.experiment.train.updates
    return made.get("updates", 0) >= wanted and made.get("config_hash", run.hash) == run.hash


def train_in(
    run: Run,
    *,
    resume: bool = False,
    display: Display | None = None,
    checkpoint_minutes: float = CHECKPOINT_MINUTES,
    on_update: OnUpdate | None = None,
    street: Street | None = None,
) -> TrainingEnd:
    """Train in a run folder until its planned number of updates is made.

    Where the experiment says minutes, as many updates are planned as fit into them, compiling included. Of several
    processes (`jaxwalk.peers`), all call it, and the first one's arguments count; it alone writes and shows anything.

    Args:
        run: a folder made by `Run.create`, or an opened one to resume.
        resume: continue from the newest checkpoint.
        display: how progress is shown; by default on standard error.
        checkpoint_minutes: minutes between checkpoints.
        on_update: is told each update, and may end the training.
        street: `make_street` of the run's experiment, if it is made already.

    Raises:
        DivergedError: numbers are not finite any more.
        InUseError: another process trains there.
        UnwrittenError: the disk is full, or the like.
        CheckpointError: no checkpoint can be read.
        EditedConfigError: the configuration isn't that of the checkpoint.
        PeerLostError: another process of the training ended, or can't be reached any more.
    """
    shown = display or Display()
    street = street or make_street(run.experiment, run.maps(shown.say), run.archives)
    if not is_first():
        with _explaining_lost_peers():
            return _train(run, street, resume, Display(Console(quiet=True)), Routine(60 * checkpoint_minutes))
    with _alone(run, street), _explaining_lost_peers():
        return _train(run, street, resume, shown, Routine(60 * checkpoint_minutes, on_update))


def train_until(run: Run, updates: int, *, resume: bool = False, display: Display | None = None) -> TrainingEnd:
    """Train as `train_in` does, in one process, but end once that many updates are made.

    The plan stays that of the run, and with it how the learning rate falls: `train_in` would make the other updates.
    """
    shown = display or Display()
    street = make_street(run.experiment, run.maps(shown.say), run.archives)
    with _alone(run, street):
        return _train(run, street, resume, shown, Routine(60 * CHECKPOINT_MINUTES, until=updates))


@contextmanager
def _alone(run: Run, street: Street) -> Iterator[None]:
    """Let no other process write into the folder while the block runs, and put it in order."""
    with held(run.path), _saying_what_is_kept(run):
        remove_unfinished(run.path)
        if not (run.path / MAPS).is_file():  # a folder of an older version, or killed while it was made
            keep_maps(run.path, street.maps)
        yield


def _explaining_lost_peers() -> AbstractContextManager[None]:
    """Return a context in which an error of the connection is raised as PeerLostError, if there are other processes."""
    return explaining_lost_peers() if several() else nullcontext()


def meet() -> None:
    """Wait until every process of the training is here. Raises PeerLostError if one can't be reached."""
    with _explaining_lost_peers():
        wait_for_all()


@contextmanager
def _saying_what_is_kept(run: Run) -> Iterator[None]:
    """Add to an OSError raised inside what has been saved and can be resumed."""
    try:
        yield
    except OSError as error:
        what = f"{error.filename}: {error.strerror}" if error.filename else str(error)
        raise UnwrittenError(
            f"{run.path}: training stopped ({what}); {_kept(run)}. "
            f"Remove the cause, then resume with: jaxwalk train --resume {run.path}"
        ) from error


def _kept(run: Run) -> str:
    updates = checkpoint.latest(run.checkpoints)
    return "there is no checkpoint yet" if updates is None else f"the checkpoint of update {updates} is kept"


def _train(run: Run, street: Street, resume: bool, display: Display, routine: Routine) -> TrainingEnd:
    """Do what `train_in` does, while no other process can write into the folder."""
    begun, minutes, train = time.monotonic(), run.experiment.minutes, run.experiment.train
    learner = begin(run, street, resume=resume, tell=display.say)
    done, per_update = int(learner.updates), run.experiment.steps_per_update
    pace = Pace(done, routine.end(int(learner.planned)), per_update)
    progress, stop = TrainingProgress(display, pace), Stop()
    if train.shards > 1:
        processes = f" of {jax.process_count()} processes" if several() else ""
        display.say(f"{display.name}: {train.environments:,} environments on {train.shards} devices{processes}")
    for line in said_of_archives(street, run.experiment):
        display.say(f"{display.name}: {line}")
    page_of = partial(_page, run, display, pace)
    with _log(run, done) as log, stop.listening(), progress, page_of(log) as page, _watchdog(routine) as watchdog:
        if page is not None:
            display.say(f"Watch it: open {page.path.absolute()} in a browser")
        earlier = log.kept[-1]["seconds"] if log.kept else 0.0
        session = Session(run, street, log, progress, stop, page, routine, watchdog, begun=begun, earlier=earlier)
        if minutes is not None:
            learner = plan_by_time(session, learner, 60 * minutes)
        learner = _loop(session, learner, 60 * minutes if minutes else math.inf)
        wait_for_all()
    updates = int(learner.updates)
    ended_early = updates < routine.end(int(learner.planned))
    stopped = ended_early and session.told_to_stop
    return TrainingEnd(updates, updates * per_update, session.seconds, ended_early and not stopped, stopped, stop.heard)


def _watchdog(routine: Routine) -> AbstractContextManager[Watchdog | None]:
    """Return what ends a training in which a process hangs; none where a function may take long between updates.

    The first process alone has such a function; the others wait for it.
    """
    if not several() or any(ask(lambda: [routine.on_update is not None])()):
        return nullcontext()
    return Watchdog()


def _log(run: Run, done: int) -> MetricsLog | NoLog:
    """Return where the metrics after that many updates are written."""
    return MetricsLog(run, updates=done) if is_first() else NoLog()


def _page(run: Run, display: Display, pace: Pace, log: MetricsLog | NoLog) -> AbstractContextManager[WatchPage | None]:
    """Return the progress page, if it is wanted or exists: an existing page must not keep saying "stopped"."""
    wanted = is_first() and (display.watch or there_is_one(run.path))
    return WatchPage(run, display.name, pace, log.kept) if wanted else nullcontext()


def begin(run: Run, street: Street, *, resume: bool, tell: Callable[[str], None] = print) -> Learner:
    """Return an untrained learner, or the newest readable checkpoint, with the run's plan.

    The plan may have changed since the checkpoint. ``tell`` is called with a line about each damaged checkpoint,
    and about one of an older version, which doesn't say with which configuration it was made.

    Raises:
        EditedConfigError: the configuration isn't that of the checkpoint.
    """
    experiment = run.experiment
    key, others = seed_key(experiment.seed, TRAINING), fixed_policies(experiment)
    if resume and is_first():
        check_bound(run, street.maps, tell, archive_hashes(street))
    learner = init_in_turns(crowded(street, experiment), experiment.train, key, others=others)
    return with_plan(_restored(run, learner, tell, resume=resume), experiment.train.updates)


def _restored(run: Run, learner: Learner, tell: Callable[[str], None], *, resume: bool) -> Learner:
    """Return the newest readable checkpoint, or the learner itself. The first process chooses, and all read it."""
    found = checkpoint.restore_newest(run.checkpoints, learner, tell=tell) if resume and is_first() else None
    (updates,) = ask(lambda: [0 if found is None else int(found.updates)])()
    if updates and not is_first():
        return checkpoint.restore(run.checkpoints, learner, updates=updates)
    return learner if found is None else found


def _loop(session: Session, learner: Learner, limit: float) -> Learner:
    """Make update after update; fetch the metrics of each one while the next one runs."""
    waiting: tuple[Any, int, Learner] | None = None
    done = int(learner.updates)
    planned, end = int(learner.planned), session.routine.end
    plan = UpdatePlan(done, planned, len(session.turns))

    def wishes() -> tuple[int, int, int]:
        if not is_first():
            return session.stop.requested, False, 0
        due = time.monotonic() - session.saved > session.routine.checkpoint_seconds
        return session.stop.requested, due, plan.follow(done, limit - session.seconds)

    stops = any(ask(lambda: [session.stop.requested])())
    while done < end(planned) and not stops and (several() or not session.stop.requested):  # alone, asked once more
        before, wished = learner, ask(wishes)
        session.progress.begin(done)
        learner, metrics = session.update(before, done)
        done += 1
        if waiting:
            session.record(*waiting)
        waiting = (metrics, done, before)
        stops, due, fitting = wished()
        if due:
            session.record(*waiting)
            waiting = None
            session.save(learner)
        if fitting != planned:
            planned = fitting
            learner = replan(session, learner, planned)
    if waiting:
        session.record(*waiting)
    session.save(learner)
    return learner
