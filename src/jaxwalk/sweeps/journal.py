"""The journal of a sweep: Optuna's file of all trials, and which of them this process works on.

Processes, also of other machines, share a journal through the folder that it is in. A process locks the folder while it
chooses a trial, and the trial's folder while it works on it. The operating system frees both locks when a process dies;
so a trial that is begun, not ended and not locked was interrupted, and the next process that looks for work resumes it.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Container, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from filelock import FileLock

from jaxwalk.runs.lock import InUseError, held
from jaxwalk.sweeps.population import EndedMember, ExtinctError, Population
from jaxwalk.sweeps.study_file import SweepPlan
from jaxwalk.sweeps.varied import ListedValues

if TYPE_CHECKING:
    from optuna import Study
    from optuna.samplers import BaseSampler
    from optuna.storages import JournalStorage
    from optuna.trial import FrozenTrial, Trial

JOURNAL, TRIALS, NAME = "journal.log", "trials", "sweep"
"""The journal's file, the folder of the trials, and the study's name in the journal."""
PATIENCE = 600.0
"""Longest wait for another process that chooses a trial [s]; that takes well below a second."""
WHY, PARENT = "why", "parent"
"""Notes in the journal: why a trial failed, and the trial from whose end a member of a population goes on."""
STARTED = 10
"""Trials that TPE draws at random before it has something to go by (Optuna's default)."""


class OptunaError(ValueError):
    """Optuna is missing. The message says how to install it."""


class JournalError(ValueError):
    """A journal that can't be read. The message names it and says what to do."""


def check_optuna() -> None:
    """Raise OptunaError if Optuna is missing."""
    if importlib.util.find_spec("optuna") is None:
        raise OptunaError('jaxwalk sweep needs Optuna; install it with: pip install "jaxwalk[sweep]"')


@dataclass(frozen=True)
class Journal:
    """The journal in a sweep's folder."""

    folder: Path
    plan: SweepPlan

    @cached_property
    def storage(self) -> JournalStorage:
        """Return Optuna's storage, which reads and writes the file. Raise JournalError if it is damaged."""
        import optuna
        from optuna.storages import JournalStorage
        from optuna.storages.journal import JournalFileBackend

        optuna.logging.set_verbosity(optuna.logging.ERROR)
        path = self.folder / JOURNAL
        try:
            return JournalStorage(JournalFileBackend(str(path), lock_obj=_lock_of(path)))
        except (ValueError, KeyError, AssertionError) as error:
            raise JournalError(
                f"{path}: damaged ({error}); restore it from a copy, or begin again in another folder"
            ) from error

    @cached_property
    def study(self) -> Study:
        """Return Optuna's study, which is made if there is none. Call this first while no other process can."""
        import optuna

        return optuna.create_study(
            storage=self.storage,
            study_name=NAME,
            direction="maximize" if self.plan.objective.maximised else "minimize",
            load_if_exists=True,
        )

    def trials(self) -> list[FrozenTrial]:
        """Return all trials in the order of their numbers, as the journal has them now."""
        return self.study.get_trials(deepcopy=False)

    def trial_folder(self, number: int) -> Path:
        """Return the folder of a trial."""
        return self.folder / TRIALS / str(number)

    @contextmanager
    def claimed(self, skipped: Container[int] = ()) -> Iterator[Trial | None]:
        """Yield a trial to work on: an interrupted one, else a new one, which no other process has meanwhile.

        ``skipped`` are the numbers of those that this process can't work on.

        None if all trials are ended, or other processes work on them, or on those that decide what comes next.
        """
        with ExitStack() as mine:
            with held(self.folder, seconds=PATIENCE):
                trial = self._interrupted(mine, skipped) or self._new(mine)
            yield trial

    def _interrupted(self, mine: ExitStack, skipped: Container[int]) -> Trial | None:
        """Return the first trial that was begun, isn't ended and that nobody works on."""
        for number in (each.number for each in self.trials() if each.state.name == "RUNNING"):
            if number not in skipped and self._locked(number, mine):
                return self._with_values(number)
        return None

    def _locked(self, number: int, mine: ExitStack) -> bool:
        """Lock a trial that was begun; return False if another process works on it or has ended it."""
        with ExitStack() as tried:
            try:
                tried.enter_context(held(self.trial_folder(number)))
            except InUseError:
                return False
            if self.trials()[number].state.name == "RUNNING":  # it may have ended before it could be locked
                mine.push(tried.pop_all())
                return True
        return False

    def _new(self, mine: ExitStack) -> Trial | None:
        """Return a trial that nobody has begun."""
        trials = self.trials()
        waiting = [each.number for each in trials if each.state.name == "WAITING"]
        number = waiting[0] if waiting else len(trials)
        if number >= self.plan.count:
            return None
        if not waiting and self.plan.sampler == "grid":
            self.study.enqueue_trial(self.plan.grid[number])
        if not waiting and self.plan.population and not self._enqueued(self.plan.population, number):
            return None
        mine.enter_context(held(self.trial_folder(number)))
        self.study.sampler = self._sampler(number)
        self.study.ask()
        return self._with_values(number)

    def waits(self) -> bool:
        """Return whether trials will come that other processes' present ones decide: the next generation."""
        return self.plan.pbt is not None and len(self.trials()) < self.plan.count

    def _enqueued(self, population: Population, number: int) -> bool:
        """Note what a member begins with; return False if the generation before hasn't ended.

        Raises ExtinctError if all trainings of that failed.
        """
        first = (population.plan.generation(number) - 1) * population.plan.members
        before = self.trials()[first : first + population.plan.members] if first >= 0 else []
        if not all(each.state.is_finished() for each in before):
            return False
        ended = [EndedMember(each.number, each.params, each.value) for each in before]
        try:
            next_one = population.next_member(number, ended)
        except ExtinctError as error:
            advice = "narrow the ranges, and begin in another folder"
            raise ExtinctError(f"{self.folder}: {error} ({before[0].user_attrs.get(WHY)}); {advice}") from None
        self.study.enqueue_trial(dict(next_one.labels), {} if next_one.parent is None else {PARENT: next_one.parent})
        return True

    def _with_values(self, number: int) -> Trial:
        """Return a trial with all its values: those of the journal, and new ones if it was killed before it had all."""
        from optuna.trial import Trial

        study = self.storage.get_study_id_from_name(NAME)
        trial = Trial(self.study, self.storage.get_trial_id_from_study_id_trial_number(study, number))
        self.study.sampler = self._sampler(number)
        _ = trial.relative_params  # those that TPE draws together, before any other sampler is set
        for place, (name, varied) in enumerate(self.plan.fields.items()):
            self.study.sampler = self._sampler(number, place)
            if self.plan.sampler == "grid" or isinstance(varied, ListedValues):
                trial.suggest_categorical(name, varied.grid())
            elif varied.whole:
                trial.suggest_int(name, int(varied.low), int(varied.high), log=varied.log)
            else:
                trial.suggest_float(name, varied.low, varied.high, log=varied.log)
        return trial

    def _sampler(self, number: int, place: int = 0) -> BaseSampler:
        """Return what chooses a value of a trial, that of the field at this place.

        It has a seed of its own, so that the value is the same whichever process asks, and after whatever kill.
        """
        from optuna.samplers import RandomSampler, TPESampler

        seed = int(np.random.SeedSequence([self.plan.sampler_seed, number, place]).generate_state(1)[0])
        return TPESampler(n_startup_trials=STARTED, seed=seed) if self.plan.sampler == "tpe" else RandomSampler(seed)


def _lock_of(path: Path) -> Any:
    """Return the lock of a journal's file: the operating system's, which a killed process doesn't leave behind.

    Optuna's own locks are files, which it waits for half a minute after their process was killed.
    """
    from optuna.storages.journal import JournalFileOpenLock

    class FreedLock(JournalFileOpenLock):
        """Locks a file beside the journal."""

        def __init__(self) -> None:
            self._file = FileLock(f"{path}.lock")

        def acquire(self) -> bool:
            self._file.acquire()
            _drop_half_line(path)
            return True

        def release(self) -> None:
            self._file.release()

    return FreedLock()


def _drop_half_line(path: Path) -> None:
    """Remove what a process that died while it wrote left at the end; call it while nobody else writes."""
    with path.open("rb+") as file:
        size = file.seek(0, 2)
        if not size:
            return
        file.seek(size - 1)
        if file.read(1) == b"\n":
            return
        file.seek(0)
        file.truncate(file.read().rfind(b"\n") + 1)
