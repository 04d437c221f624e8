"""Sweeps by population-based training; trainings are pretended. A pretended checkpoint is a number, the skill."""

from __future__ import annotations

import csv
import json
import random
from concurrent.futures import ThreadPoolExecutor

import pytest

from jaxwalk.cli import main
from jaxwalk.runs.folder import Run
from jaxwalk.runs.session import DivergedError
from jaxwalk.runs.training import TrainingEnd
from jaxwalk.sweeps import journal, sweeping, trial_work
from jaxwalk.sweeps.population import ExtinctError
from jaxwalk.sweeps.study_file import load_sweep
from jaxwalk.sweeps.sweep_results import SweepResults, write_results
from jaxwalk.sweeps.sweeping import sweep

PBT = {
    'sampler = "random"\ntrials = 4\n': 'sampler = "pbt"\n',
    "minimise": "maximise",
    "[training.train]": "[pbt]\nmembers = 4\ngenerations = 3\n[training.train]",
    "updates = 10": "updates = 6",
}
SKILL = "checkpoints/skill.json"


class Learning:
    """Trainings whose reward is the skill: it grows by 1 an update at the best price of time, and by less elsewhere."""

    def __init__(self) -> None:
        self.calls = 0
        self.killed_at: int | None = None
        self.begun: list[tuple[str, int]] = []
        """Folders of trials, with the update after which they began or were resumed."""

    def may_be_killed(self):
        self.calls += 1
        if self.calls == self.killed_at:
            raise KeyboardInterrupt

    def train_until(self, run, updates, *, resume, display):
        made, skill = json.loads((run.path / SKILL).read_text()) if (run.path / SKILL).is_file() else (0, 0.0)
        assert resume or made == 0
        self.begun.append((run.path.parent.name, made))
        price = run.experiment.driver_weights["time"]
        lines = [line for line in run.metrics() if line["update"] <= made]
        (run.path / "checkpoints").mkdir(exist_ok=True)
        for update in range(made + 1, updates + 1):
            skill += 1.0 - 10 * abs(price + 0.1)
            lines.append({"update": update, "seconds": 1.0, "episodes": 3.0, "reward/driver": skill})
            (run.path / "metrics.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
            self.may_be_killed()
            (run.path / SKILL).write_text(json.dumps([update, skill]))
            self.may_be_killed()
        return TrainingEnd(updates, updates, 1.0, False)

    def begin_at(self, run, parent, updates):
        self.may_be_killed()
        if not (run.path / SKILL).is_file():
            made, skill = json.loads((parent.path / SKILL).read_text())
            assert made == updates, "a parent is copied at its end"
            (run.path / "checkpoints").mkdir(exist_ok=True)
            (run.path / SKILL).write_text(json.dumps([made, skill]))
        self.may_be_killed()

    @staticmethod
    def is_finished(run, updates):
        return (run.path / SKILL).is_file() and json.loads((run.path / SKILL).read_text())[0] >= updates


@pytest.fixture
def learning(monkeypatch):
    """Trainings are pretended, and may be killed in many places."""
    found = Learning()
    for name in ("train_until", "begin_at", "is_finished"):
        monkeypatch.setattr(trial_work, name, getattr(found, name))
    monkeypatch.setattr(sweeping, "make_street", lambda experiment: None)
    monkeypatch.setattr(sweeping, "write_results", lambda folder, results: None)  # it takes most of the time

    def killable(place, name):
        plain = getattr(place, name)

        def call(*args, **how):
            found.may_be_killed()
            result = plain(*args, **how)
            found.may_be_killed()
            return result

        monkeypatch.setattr(place, name, call)

    for place, name in ((trial_work, "score_of"), (journal.Journal, "_enqueued"), (journal.Journal, "_with_values")):
        killable(place, name)
    killable(sweeping, "_end")
    return found


def history(results):
    """What a population did."""
    return [(trial.number, trial.parent, dict(trial.values), trial.value, trial.state) for trial in results.trials]


@pytest.fixture
def untouched(learning, study, tmp_path, quiet):
    """The results of a sweep that nothing interrupted."""
    return sweep(tmp_path / "untouched", load_sweep(study(**PBT)), console=quiet)


def test_the_best_member_is_copied_and_the_skill_goes_with_its_checkpoint(untouched, tmp_path):
    trials = untouched.trials
    assert len(trials) == 12 and untouched.left == 0 and [trial.parent for trial in trials[:4]] == [None] * 4
    for generation in range(2):
        before, after = trials[4 * generation : 4 * generation + 4], trials[4 * generation + 4 : 4 * generation + 8]
        order = sorted(before, key=lambda trial: trial.value)
        for member, trial in enumerate(after):
            worst = before[member] is order[0]
            assert trial.parent == (order[-1].number if worst else before[member].number)
            assert (trial.values != trials[trial.parent].values) == worst
            growth = 2 * (1.0 - 10 * abs(trial.values["driver_weights.time"] + 0.1))  # two updates a generation
            assert trial.value == pytest.approx(trials[trial.parent].value + growth)
    assert [trial.number for trial in untouched.best] == sorted(range(8, 12), key=lambda n: -trials[n].value)
    run = Run.open(tmp_path / "untouched" / "trials" / "8" / "seed-0")
    assert [line["update"] for line in run.metrics()] == [5, 6] and run.experiment.train.updates == 6


@pytest.mark.parametrize(
    "chance", [random.Random(0), pytest.param(random.Random(1), marks=pytest.mark.long)], ids=["once", "again"]
)
def test_a_sweep_that_is_killed_again_and_again_ends_as_if_nothing_had_happened(
    chance, untouched, learning, study, tmp_path, quiet
):
    """It is killed before and after each kind of step, such as half-way between a copy and the note about it."""
    plan, out, kills = load_sweep(study(**PBT)), tmp_path / "killed", 0
    while True:
        learning.calls, learning.killed_at = 0, chance.randint(1, 24)
        try:
            results = sweep(out, plan, console=quiet)
            break
        except KeyboardInterrupt:
            kills += 1
    assert kills > 10
    assert history(results) == history(untouched)


def test_processes_share_a_population_and_wait_for_each_other(untouched, learning, study, tmp_path, quiet, monkeypatch):
    monkeypatch.setattr(sweeping, "LOOKS", 0.01)
    plan = load_sweep(study(**PBT))
    learning.begun.clear()
    with ThreadPoolExecutor(2) as pool:
        ends = [pool.submit(sweep, tmp_path / "shared", plan, console=quiet) for _ in range(2)]
    assert all(isinstance(end.result(), SweepResults) for end in ends)
    assert len(learning.begun) == 12, "nothing is trained twice"
    assert history(sweep(tmp_path / "shared", plan, console=quiet)) == history(untouched)


def test_who_finds_no_work_says_what_it_waits_for(learning, study, tmp_path, quiet, monkeypatch):
    """Another process has the fourth member; when it is gone, its trial is resumed."""
    plan = load_sweep(study(**PBT))
    other = journal.Journal(tmp_path / "out", plan)
    sweeping.begin_sweep(tmp_path / "out", plan)
    with other.claimed() as trial:
        assert trial.number == 0

        def gone(seconds):
            raise TimeoutError

        monkeypatch.setattr(sweeping.time, "sleep", gone)
        with pytest.raises(TimeoutError):
            sweep(tmp_path / "out", plan, console=quiet)
        assert [name for name, _ in learning.begun] == ["1", "2", "3"]
        assert "waiting for other processes: their trials decide the next generation" in quiet.file.getvalue()
    assert len(sweep(tmp_path / "out", plan, console=quiet).trials) == 12


def test_a_failed_member_is_replaced_and_without_any_left_the_sweep_ends(
    learning, study, tmp_path, quiet, monkeypatch, capsys
):
    train_until, doomed = learning.train_until, {"1"}

    def diverging(run, updates, **how):
        if run.path.parent.name in doomed:
            raise DivergedError(f"{run.path}: numbers are not finite")
        return train_until(run, updates, **how)

    monkeypatch.setattr(trial_work, "train_until", diverging)
    results = sweep(tmp_path / "out", load_sweep(study(**PBT)), console=quiet)
    assert results.trials[1].state == "failed" and results.trials[5].parent in (0, 2, 3)
    assert results.trials[5].value is not None and results.counts["complete"] == 11
    doomed |= {"4", "5", "6", "7"}
    with pytest.raises(ExtinctError, match=r"every training of generation 1 failed; .*numbers are not finite"):
        sweep(tmp_path / "extinct", load_sweep(study(**PBT)), console=quiet)
    assert main(["sweep", str(study(**PBT)), "--out", str(tmp_path / "extinct")]) == 2
    assert "there is none to go on from" in capsys.readouterr().err


def test_the_tables_say_generation_member_and_parent(untouched, tmp_path):
    write_results(tmp_path / "untouched", untouched)
    rows = list(csv.DictReader((tmp_path / "untouched" / "trials.csv").read_text().splitlines()))
    assert [(row["generation"], row["member"]) for row in rows[:5]] == [("0", str(k)) for k in range(4)] + [("1", "0")]
    assert [row["parent"] for row in rows] == ["" if x.parent is None else str(x.parent) for x in untouched.trials]
    document = json.loads((tmp_path / "untouched" / "study.json").read_text())
    assert document["plan"]["pbt"]["members"] == 4 and document["plan"]["trials"] == 12
    assert [trial["parent"] for trial in document["trials"]] == [trial.parent for trial in untouched.trials]
