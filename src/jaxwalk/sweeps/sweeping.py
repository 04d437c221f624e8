"""A sweep in a folder: trials are worked on until none is left, by this process and by others that share the folder.

plan.json          what the file said
journal.log        all trials (`jaxwalk.sweeps.journal`)
trials/N/seed-S    a run folder: trial N, trained with seed S
study.json, trials.csv, study.html    what came of it (`jaxwalk.sweeps.sweep_results`)
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console

from jaxwalk.learning.checkpoint import CheckpointError
from jaxwalk.policies.learned import PolicyError
from jaxwalk.runs.folder import RunError, as_json, check_writable, is_empty
from jaxwalk.runs.kept_archives import KeptArchiveError
from jaxwalk.runs.kept_maps import KeptMapsError
from jaxwalk.runs.lock import held
from jaxwalk.runs.street import make_street
from jaxwalk.runs.study import PLAN, read_json
from jaxwalk.runs.training import UnwrittenError
from jaxwalk.sweeps.attempts import attempted
from jaxwalk.sweeps.evaluated import check_objective
from jaxwalk.sweeps.journal import PATIENCE, TRIALS, WHY, Journal, check_optuna
from jaxwalk.sweeps.study_file import SweepPlan
from jaxwalk.sweeps.sweep_results import SweepResults, read_results, write_results
from jaxwalk.sweeps.trial_work import TrialWork, UselessTrialError
from jaxwalk.sweeps.varied import single_changes
from jaxwalk.writing import remove_unfinished, write_whole

LOOKS = 1.0
"""Time between looks at whether the generation that others work on has ended [s]."""
MAY_GROW = "trials"
"""The one field that may have another value when a sweep goes on: a larger one."""
FILES = "files"
"""The field with the SHA-256 of each map and archive that is a file."""
DAMAGED = (RunError, CheckpointError, PolicyError, KeptMapsError, KeptArchiveError)
"""Errors of one trial's files, if they aren't an `UnwrittenError`."""

BETWEEN = 20
"""The results are written again after this many times as long as writing them took, and at the end."""


def sweep(folder: Path, plan: SweepPlan, *, console: Console | None = None) -> SweepResults:
    """Work on the trials of a sweep until none is left for this process; return what there is then.

    Args:
        folder: made if missing; what is there is kept, and interrupted trials are resumed.
        plan: what the file says (`load_sweep`).
        console: where progress is shown (default: standard error).

    Raises:
        Interrupted: on Ctrl-C; the same call goes on later.
        RunError: the folder was begun with another plan, or isn't a sweep's.
        OptunaError, JournalError, SweepFileError, ContestantError: Optuna is missing, the journal is damaged, or the
            objective doesn't exist.
        ExtinctError: all trainings of a generation failed.
    """
    begin_sweep(folder, plan)
    console = console or Console(stderr=True)
    journal = Journal(folder, plan)
    with held(folder, seconds=PATIENCE):
        journal.trials()  # makes the journal, while no other process does
    try:
        _work_on_all(journal, console)
    finally:
        results = _write(journal)
    return results


def _work_on_all(journal: Journal, console: Console) -> None:
    """Work on trials until there is none for this process, now or later.

    A trial whose files are damaged doesn't stop the others; its error is raised when they are done.
    """
    told, due = False, 0.0
    damaged: dict[int, ValueError] = {}
    while True:
        if _work(journal, console, damaged):
            due = _written(journal, due)
            told = False
            continue
        for error in damaged.values():
            raise error
        if not journal.waits():
            return
        if not told:
            console.print("waiting for other processes: their trials decide the next generation", soft_wrap=True)
            told = True
        time.sleep(LOOKS)


def _written(journal: Journal, due: float) -> float:
    """Write the results if they are due; return when they are next: that grows with the trials."""
    begun = time.monotonic()
    if begun < due:
        return due
    _write(journal)
    return time.monotonic() + BETWEEN * (time.monotonic() - begun)


def begin_sweep(folder: Path, plan: SweepPlan) -> None:
    """Check everything that a sweep needs, and make its folder with the plan, unless it is there.

    Raises what `sweep` raises before it trains.
    """
    check_optuna()
    check_folder(folder, plan)
    check_objective(plan)
    _check_streets(plan)
    with held(folder, seconds=PATIENCE):
        check_folder(folder, plan)  # check again: another process may have been quicker
        with _nobody_writes_results(folder):
            remove_unfinished(folder)
        write_whole(folder / PLAN, json.dumps(as_plan(plan), indent=2, allow_nan=False) + "\n")


def _check_streets(plan: SweepPlan) -> None:
    """Raise the error of `make_street` for a name that doesn't exist, before anything is written."""
    make_street(plan.base)
    for labels in single_changes(plan.fields):
        if any(isinstance(label, str) for label in labels.values()):  # numbers are checked with the file
            make_street(plan.experiment(plan.first | labels))


def _work(journal: Journal, console: Console, damaged: dict[int, ValueError]) -> bool:
    """Work on one trial to its end, or note in ``damaged`` why that can't be; return False if there is none."""
    with journal.claimed(damaged) as trial:
        if trial is None:
            return False
        work = TrialWork(trial, journal.plan, journal.trial_folder(trial.number), console)
        try:
            score = _attempt(work)
        except UselessTrialError as error:
            trial.set_user_attr(WHY, str(error))
            console.print(f"trial {trial.number} failed: {error}", soft_wrap=True, markup=False)
            _end(journal, trial.number, "FAIL")
            return True
        except UnwrittenError:  # the disk is full for the others too
            raise
        except DAMAGED as error:
            damaged[trial.number] = error
            console.print(f"trial {trial.number} is left: {error}", soft_wrap=True, markup=False)
            return True
        if score is None:
            _end(journal, trial.number, "PRUNED")
            said = "pruned"
        else:
            _end(journal, trial.number, "COMPLETE", score)
            said = f"{journal.plan.objective.metric} {score:.6g}"
        console.print(f"trial {trial.number}: {said}", soft_wrap=True, markup=False)
        return True


def _attempt(work: TrialWork) -> float | None:
    """Return the trial's score, unless too many attempts at it have ended their process."""
    with attempted(work.trial, work.folder):
        return work.score()


def _end(journal: Journal, number: int, state: str, score: float | None = None) -> None:
    """Note in the journal how a trial ended."""
    from optuna.trial import TrialState

    journal.study.tell(number, score, TrialState[state])


@contextmanager
def _nobody_writes_results(folder: Path) -> Iterator[None]:
    """Hold the lock of who writes the results. It is one of its own, as other processes choose trials meanwhile."""
    with held(folder / TRIALS, seconds=PATIENCE) if (folder / TRIALS).is_dir() else nullcontext():
        yield


def _write(journal: Journal) -> SweepResults:
    """Write the results, while no other process does: not an older state over a newer one."""
    with _nobody_writes_results(journal.folder):
        results = read_results(journal)
        write_results(journal.folder, results)
    return results


def check_folder(folder: Path, plan: SweepPlan) -> None:
    """Raise RunError unless the folder can be made, or was begun with the same plan. Writes nothing."""
    if folder.exists() and not folder.is_dir():
        raise RunError(f"{folder}: is a file, not a folder; name another one")
    filled = folder.is_dir() and not is_empty(folder)  # before the plan is read: another process may just write it
    there = read_json(folder / PLAN, "sweep")
    if there is None and filled:
        raise RunError(f"{folder}: the folder is not empty and no `jaxwalk sweep` made it; name another folder")
    if there is not None:
        _check_plan(folder, there if isinstance(there, dict) else {}, plan)
    check_writable(folder)


def _check_plan(folder: Path, there: Mapping[str, Any], plan: SweepPlan) -> None:
    """Raise RunError unless a folder was begun with the same plan, perhaps of fewer trials."""
    asked, other = as_plan(plan), "or name another folder"
    for path, digest in there.get(FILES, {}).items():
        if asked[FILES].get(path, digest) != digest:
            raise RunError(f"{folder}: {path} was changed since the sweep began; restore it, {other}")
    name = next((name for name in asked if name not in (MAY_GROW, FILES) and there.get(name) != asked[name]), None)
    if name is not None:
        raise RunError(f"{folder}: was begun with another value of {name}; undo the change in {plan.path}, {other}")
    if plan.trials is not None and there.get(MAY_GROW, 0) > plan.trials:
        raise RunError(f"{folder}: was begun with {there[MAY_GROW]} trials; ask for no fewer, {other}")


def as_plan(plan: SweepPlan) -> dict[str, Any]:
    """Return what the folder keeps of a plan, as JSON has it."""
    document = {name: value for name, value in asdict(plan).items() if name != "path"}
    files = [Path(name) for name in (*plan.base.maps, *plan.base.archives) if Path(name).is_file()]
    digests = {str(path): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
    return json.loads(json.dumps(document | {"training": as_json(plan.base), FILES: digests}))
