"""The work of one trial: a training with each seed, each in a run folder of its own, and the trial's number."""

from __future__ import annotations

import math
import shutil
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from jaxwalk.recipes import Experiment, ExperimentFileError, with_training
from jaxwalk.relief import relieve
from jaxwalk.runs.branching import begin_at
from jaxwalk.runs.folder import CONFIG, Run, RunError
from jaxwalk.runs.kept_maps import MAPS
from jaxwalk.runs.progress import Display
from jaxwalk.runs.session import DivergedError
from jaxwalk.runs.street import WorldError, shared_out, whole_minibatches
from jaxwalk.runs.study import Interrupted, is_same_training
from jaxwalk.runs.training import TrainingEnd, is_finished, train_in, train_until
from jaxwalk.sweeps.evaluated import evaluated
from jaxwalk.sweeps.journal import PARENT
from jaxwalk.sweeps.study_file import PERCENT, SweepObjective, SweepPlan

if TYPE_CHECKING:
    from optuna.trial import Trial

REPORTS = 20
"""Numbers that a training reports on its way, for pruning."""
LAST = 10
"""The number of a training is the mean over its last tenth of updates."""
FEWEST_BEFORE, FIRST_JUDGED = 5, 5
"""Trials that have to be complete, and twentieths of a trial that pass, before any is pruned."""
PRUNED = "pruned"
"""Note in the journal that a trial was pruned."""


class UselessTrialError(ValueError):
    """A trial that has no number. The message says why."""


@dataclass(frozen=True)
class TrialWork:
    """A trial that this process has to itself."""

    trial: Trial
    plan: SweepPlan
    folder: Path
    """The trial's folder."""
    console: Console

    def score(self) -> float | None:
        """Train with every seed what isn't trained yet; return the mean of their numbers, None if it is pruned.

        Raises:
            UselessTrialError: a training diverged, its values are impossible, or it has no number.
            Interrupted: on Ctrl-C, or another signal that asks to end.
        """
        try:
            experiment = self.plan.experiment(self.trial.params)
            seeds = self.plan.training_seeds(experiment)
            self._train_all([replace(experiment, seed=seed) for seed in seeds])
        except (DivergedError, ExperimentFileError, WorldError) as error:
            raise UselessTrialError(str(error)) from error
        if self._noted(PRUNED):
            return None
        return math.fsum(self._noted(_name(seed)) for seed in seeds) / len(seeds)

    def _noted(self, name: str) -> Any:
        """Return a note of the journal; None if there is none."""
        return self.trial.user_attrs.get(name)

    def _train_all(self, experiments: Sequence[Experiment]) -> None:
        """Train what has no number yet, until the trial is pruned."""
        for index, experiment in enumerate(experiments):
            if self._noted(PRUNED) is None and self._noted(_name(experiment.seed)) is None:
                self._train(experiment, index)

    def _train(self, experiment: Experiment, index: int) -> None:
        """Train with a seed, or resume that, and note its number."""
        run, begun = _begun(self.folder / _name(experiment.seed), experiment, self._parent(experiment.seed))
        updates = run.experiment.train.updates
        end = self.plan.pbt.end(self.trial.number, updates) if self.plan.pbt else updates
        ended = None if is_finished(run, end) else self._trained(run, begun, index, end)
        heard = ended is not None and ended.heard
        if ended is not None and (ended.interrupted or (heard and self.plan.objective.of == "evaluation")):
            raise Interrupted  # the number takes long then: the next process finds the training finished
        if self._noted(PRUNED) is None:
            self.trial.set_user_attr(_name(experiment.seed), score_of(run, self.plan.objective))
        if heard:
            raise Interrupted

    def _trained(self, run: Run, begun: bool, index: int, end: int) -> TrainingEnd:
        """Train up to an update, and return how that ended."""
        relieve()
        display = Display(self.console, f"trial {self.trial.number}, seed {run.experiment.seed}")
        if not self.plan.pbt:
            tell = self._pruner(run, index) if self.plan.prune else None
            return train_in(run, resume=begun, display=display, on_update=tell)
        parent = self._parent(run.experiment.seed)
        if parent is None:
            return train_until(run, end, resume=begun, display=display)
        begin_at(run, parent, self.plan.pbt.end(self._noted(PARENT), run.experiment.train.updates))
        return train_until(run, end, resume=True, display=display)

    def _parent(self, seed: int) -> Run | None:
        """Return the run from whose end the training with a seed goes on; None if it begins anew."""
        number = self._noted(PARENT)
        return None if number is None else Run.open(self.folder.parent / str(number) / _name(seed))

    def _pruner(self, run: Run, index: int) -> Callable[[Mapping[str, Any]], bool]:
        """Return what is told each update: it reports the number so far, and says whether to end the trial."""
        updates, metric = run.experiment.train.updates, self.plan.objective.metric
        earlier = [self._noted(_name(run.experiment.seed - k)) for k in range(1, index + 1)]
        reported = set(self.trial.study.get_trials(deepcopy=False)[self.trial.number].intermediate_values)
        lines = run.metrics()

        def tell(line: Mapping[str, Any]) -> bool:
            lines[line["update"] - 1 :] = [dict(line)]  # after a kill, some updates come again
            part = REPORTS * line["update"] // updates
            step, now = REPORTS * index + part, mean_of_last(lines, metric, updates)
            if part == REPORTS * (line["update"] - 1) // updates or step in reported or now is None:
                return False
            value = (math.fsum(earlier) + now) / (len(earlier) + 1)
            self.trial.report(value, step)
            if self._is_worse(value, step):
                self.trial.set_user_attr(PRUNED, f"after update {line['update']} of seed {run.experiment.seed}")
                return True
            return False

        return tell

    def _is_worse(self, value: float, step: int) -> bool:
        """Return whether a number is worse than the median of the complete trials at the same point."""
        complete = [trial for trial in self.trial.study.get_trials(deepcopy=False) if trial.state.name == "COMPLETE"]
        before = [trial.intermediate_values[step] for trial in complete if step in trial.intermediate_values]
        if len(before) < FEWEST_BEFORE or step < FIRST_JUDGED:
            return False
        middle = statistics.median(before)
        return value < middle if self.plan.objective.maximised else value > middle


def _name(seed: int) -> str:
    """Return the name of a seed's run folder, and of its number in the journal."""
    return f"seed-{seed}"


def _begun(folder: Path, experiment: Experiment, parent: Run | None) -> tuple[Run, bool]:
    """Return the run in a folder, and whether it was there. One with a parent has its maps, archives and devices."""
    if (folder / CONFIG).is_file() and (parent is None or (folder / MAPS).is_file()):
        run = Run.open(folder)
        if not is_same_training(run.experiment, experiment):
            raise RunError(f"{folder}: holds another training than this trial's; remove it and run the command again")
        return run, True
    if folder.is_dir():  # a process was killed before it had written what a run begins with
        shutil.rmtree(folder)
    if parent is not None:
        train = parent.experiment.train
        experiment = with_training(experiment, shards=train.shards, chunk_rows=train.chunk_rows)
        archives = [path.read_bytes() for path in parent.archives]
        return Run.create(folder, experiment, parent.maps(), archives), False
    several = experiment.train.shards > 1
    return Run.create(folder, whole_minibatches(experiment) if several else shared_out(experiment)), False


def score_of(run: Run, objective: SweepObjective) -> float:
    """Return the number of a finished training. Raise UselessTrialError if it has none."""
    if objective.of == "evaluation":
        found = evaluated(run, objective)
    else:
        found = mean_of_last(run.metrics(), objective.metric, run.experiment.train.updates)
    if found is None or not math.isfinite(found):
        raise UselessTrialError(f"{run.path}: has no {objective.metric}; train longer, or choose another metric")
    return float(found)


def mean_of_last(lines: Sequence[Mapping[str, Any]], metric: str, updates: int) -> float | None:
    """Return the mean of a number over the last tenth of a training's updates, so far as they are made.

    For shares of episodes only updates count in which one ended. None if there are none.
    """
    last = lines[-max(1, updates // LAST) :]
    values = [line[metric] for line in last if metric in line and (metric not in PERCENT or line["episodes"])]
    return math.fsum(values) / len(values) if values else None
