"""What came of a sweep: each trial, the best ones, and which field mattered; as JSON, as a table and as a page."""

from __future__ import annotations

import csv
import io
import json
import warnings
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jaxwalk.provenance import provenance
from jaxwalk.runs.folder import Run, RunError
from jaxwalk.sweeps.journal import PARENT, WHY, Journal
from jaxwalk.sweeps.study_file import SweepPlan
from jaxwalk.sweeps.sweep_page import sweep_page
from jaxwalk.sweeps.trial_curves import TrialCurve, curve_of
from jaxwalk.sweeps.trial_work import PRUNED
from jaxwalk.wording import counted
from jaxwalk.writing import together, write_whole

if TYPE_CHECKING:
    from optuna import Study
    from optuna.trial import FrozenTrial

SCHEMA = 1
"""Version of the JSON document."""
STATES = {"COMPLETE": "complete", "PRUNED": "pruned", "FAIL": "failed", "RUNNING": "unfinished"}
"""Optuna's states in our words; a waiting trial hasn't begun and isn't listed."""
FEWEST_JUDGED = 4
"""With fewer complete trials nothing is said about which field matters."""


@dataclass(frozen=True)
class TrialResult:
    """One trial."""

    number: int
    state: str
    """complete, pruned, failed or unfinished."""
    value: float | None
    """The mean of its seeds' numbers; None unless it is complete."""
    seeds: Mapping[str, float]
    """The number of each seed that is trained, by the name of its run folder."""
    values: Mapping[str, Any]
    """The value of each field that varies."""
    why: str | None
    """Why it failed or was pruned."""
    parent: int | None = None
    """With a population: the trial of the generation before from whose end it went on; None in the first one."""


@dataclass(frozen=True)
class SweepResults:
    """All trials of a sweep so far."""

    plan: SweepPlan
    trials: tuple[TrialResult, ...]
    """By number."""
    importance: Mapping[str, float]
    """How much each field mattered, in shares of 1, the largest first; empty while too few trials are complete."""
    curves: Mapping[int, TrialCurve]
    """The learning curve of each trial that has one, by number."""

    @property
    def best(self) -> list[TrialResult]:
        """Return the complete trials, the best first; of equal ones the earlier.

        With a population: those of the newest generation that has any, as earlier ones are parts of their trainings.
        """
        sign = -1 if self.plan.objective.maximised else 1
        complete = [trial for trial in self.trials if trial.value is not None]
        if self.plan.pbt and complete:
            newest = self.plan.pbt.generation(complete[-1].number)
            complete = [trial for trial in complete if self.plan.pbt.generation(trial.number) == newest]
        return sorted(complete, key=lambda trial: sign * (trial.value or 0.0))

    @property
    def counts(self) -> Counter[str]:
        """Return the number of trials in each state."""
        return Counter(trial.state for trial in self.trials)

    @property
    def count(self) -> int:
        """Return the number of all trials. Another process may have begun more than this one's file asks for."""
        return max(self.plan.count, len(self.trials))

    @property
    def left(self) -> int:
        """Return the number of trials that aren't ended."""
        return self.count - sum(trial.state != "unfinished" for trial in self.trials)

    def in_words(self) -> str:
        """Return how many trials there are, as in ``17 of 20 trials: 12 complete, 5 pruned``."""
        states = ", ".join(f"{self.counts[state]} {state}" for state in STATES.values() if self.counts[state])
        ended = self.count - self.left
        return f"{ended} of {counted(self.count, 'trial')} ended" + (f": {states}" if states else "")


def read_results(journal: Journal) -> SweepResults:
    """Return what the journal and the run folders say."""
    trials = tuple(_result(each, journal.plan) for each in journal.trials() if each.state.name in STATES)
    curves = {trial.number: _curve(journal, trial) for trial in trials}
    return SweepResults(
        journal.plan,
        trials,
        {} if journal.plan.pbt else _importance(journal.study),  # members' values depend on each other
        {number: curve for number, curve in curves.items() if curve},
    )


def _result(trial: FrozenTrial, plan: SweepPlan) -> TrialResult:
    notes = trial.user_attrs
    return TrialResult(
        number=trial.number,
        state=STATES[trial.state.name],
        value=trial.value if trial.state.name == "COMPLETE" else None,
        seeds={name: value for name, value in notes.items() if name.startswith("seed-")},
        values={name: plan.fields[name].value(label) for name, label in trial.params.items() if name in plan.fields},
        why=notes.get(WHY, notes.get(PRUNED)),
        parent=notes.get(PARENT),
    )


def _curve(journal: Journal, trial: TrialResult) -> TrialCurve | None:
    """Return a trial's learning curve; None if no update is made."""
    lines = []
    for path in sorted(journal.trial_folder(trial.number).glob("seed-*/metrics.jsonl")):
        try:
            lines.append(Run.open(path.parent).metrics())
        except RunError:  # another process is making the folder
            continue
    return curve_of(lines, journal.plan.objective)


def _importance(study: Study) -> dict[str, float]:
    """Return Optuna's PED-ANOVA importances (Watanabe et al. 2023); {} while there is too little to say."""
    from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances

    complete = [trial.value for trial in study.get_trials(deepcopy=False) if trial.state.name == "COMPLETE"]
    if len(complete) < FEWEST_JUDGED or len(set(complete)) < 2:
        return {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = get_param_importances(study, evaluator=PedAnovaImportanceEvaluator())
    return {name: float(share) for name, share in found.items()}


def as_results_document(results: SweepResults) -> dict[str, Any]:
    """Return the results as JSON has them."""
    plan = asdict(results.plan) | {"trials": results.count}
    del plan["path"]
    return {
        "schema": SCHEMA,
        "plan": plan,
        "trials": [asdict(trial) for trial in results.trials],
        "best": [trial.number for trial in results.best],
        "importance": dict(results.importance),
        "made": asdict(provenance()),
    }


def write_results(folder: Path, results: SweepResults) -> None:
    """Write ``study.json``, ``trials.csv`` and ``study.html``: all of them or none."""
    with together():
        document = as_results_document(results)
        write_whole(folder / "study.json", json.dumps(document, indent=1, allow_nan=False) + "\n")
        write_whole(folder / "trials.csv", _table(results))
        write_whole(folder / "study.html", sweep_page(folder, results))


def _table(results: SweepResults) -> str:
    """Return a row for each trial."""
    fields, seeds = list(results.plan.fields), sorted({name for trial in results.trials for name in trial.seeds})
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    plan, place = results.plan.pbt, ["generation", "member", "parent"] if results.plan.pbt else []
    rows.writerow(["trial", *place, "state", results.plan.objective.metric, *seeds, *fields, "why"])
    for trial in results.trials:
        at = [plan.generation(trial.number), plan.member(trial.number), trial.parent] if plan else []
        own = [trial.seeds.get(name) for name in seeds] + [_cell(trial.values.get(name)) for name in fields]
        rows.writerow([trial.number, *at, trial.state, trial.value, *own, trial.why])
    return text.getvalue()


def _cell(value: Any) -> Any:
    """Return a value for a table: a list as JSON."""
    return json.dumps(value) if isinstance(value, list) else value
