"""Sweeps go on where they were interrupted, and processes share them; trainings are pretended."""

from __future__ import annotations

import csv
import json
import time

import pytest

from jaxwalk.cli import main
from jaxwalk.runs.folder import RunError
from jaxwalk.runs.lock import InUseError, held
from jaxwalk.runs.session import DivergedError
from jaxwalk.runs.street import WorldError
from jaxwalk.runs.study import Interrupted
from jaxwalk.shards import ShardsError
from jaxwalk.sweeps import sweeping, trial_work
from jaxwalk.sweeps.journal import JOURNAL, TRIALS, Journal, JournalError
from jaxwalk.sweeps.study_file import load_sweep
from jaxwalk.sweeps.sweeping import as_plan, begin_sweep, sweep
from jaxwalk.sweeps.trial_work import mean_of_last


def values(results):
    return [trial.values["driver_weights.time"] for trial in results.trials]


def test_every_trial_is_a_run_folder_and_has_the_mean_of_its_seeds(pretended, study, tmp_path, quiet):
    results = sweep(tmp_path / "out", load_sweep(study(**{"trials = 4": "trials = 3\nseeds = 2"})), console=quiet)
    assert pretended.trained == [(str(n), f"seed-{seed}", 0) for n in range(3) for seed in range(2)]
    for trial in results.trials:
        near = (trial.values["driver_weights.time"] + 0.1) ** 2
        assert trial.seeds == pytest.approx({"seed-0": near, "seed-1": near + 1})
        assert trial.value == pytest.approx(near + 0.5)
        assert -0.25 <= trial.values["driver_weights.time"] <= -0.02
    assert [trial.number for trial in results.best] == sorted(range(3), key=lambda n: abs(values(results)[n] + 0.1))
    document = json.loads((tmp_path / "out" / "study.json").read_text())
    assert document["best"] == [trial.number for trial in results.best] and document["plan"]["trials"] == 3
    rows = list(csv.DictReader((tmp_path / "out" / "trials.csv").read_text().splitlines()))
    assert [float(row["driver_weights.time"]) for row in rows] == values(results)
    assert [row["state"] for row in rows] == ["complete"] * 3


def test_an_interrupted_trial_is_resumed_and_none_is_trained_twice(pretended, study, tmp_path, quiet):
    """10 updates each: interrupted in the third trial, as by a kill, which leaves the journal as it is."""
    plan, out = load_sweep(study()), tmp_path / "out"
    pretended.stop_after = 23
    with pytest.raises(KeyboardInterrupt):
        sweep(out, plan, console=quiet)
    pretended.stop_after = None
    results = sweep(out, plan, console=quiet)
    assert pretended.trained == [
        ("0", "seed-0", 0),
        ("1", "seed-0", 0),
        ("2", "seed-0", 0),
        ("2", "seed-0", 3),
        ("3", "seed-0", 0),
    ]
    assert [trial.state for trial in results.trials] == ["complete"] * 4 and results.left == 0
    whole = sweep(tmp_path / "whole", plan, console=quiet)
    assert values(whole) == values(results)
    before = len(pretended.trained)
    assert sweep(out, plan, console=quiet).best == results.best and len(pretended.trained) == before


class Killed(BaseException):
    """Ends a process without a word: it leaves the journal as it is, and the locks free."""


def dying(pretended, monkeypatch, how, begun, checkpoints=False):
    """Let the training of trial 1 end its process, which may have written another checkpoint before."""

    def train_in(run, **words):
        if run.path.parent.name != "1":
            return pretended.train_in(run, **words)
        begun.append(1)
        if checkpoints:
            (run.checkpoints / str(len(begun))).mkdir(parents=True)
        raise how

    monkeypatch.setattr(trial_work, "train_in", train_in)


def test_a_trial_that_ends_its_process_three_times_fails_and_the_others_go_on(
    pretended, study, tmp_path, quiet, monkeypatch
):
    plan, out, begun = load_sweep(study()), tmp_path / "out", []
    dying(pretended, monkeypatch, Killed, begun)
    for _ in range(3):
        with pytest.raises(Killed):
            sweep(out, plan, console=quiet)
    results = sweep(out, plan, console=quiet)
    assert [trial.state for trial in results.trials] == ["complete", "failed", "complete", "complete"]
    assert results.trials[1].why == (
        f"{out}/trials/1: its process ended 3 times before it came further; the memory may not suffice for it"
    )
    assert len(begun) == 3 and "its process ended 3 times" in (out / "study.html").read_text()


@pytest.mark.parametrize(
    ("how", "checkpoints"),
    [
        (Killed, True),
        (KeyboardInterrupt, False),
        (Interrupted, False),
        (OSError("full"), False),
        (ShardsError("8"), False),
    ],
)
def test_a_trial_may_end_often_if_it_comes_further_or_is_not_to_blame(
    how, checkpoints, pretended, study, tmp_path, quiet, monkeypatch
):
    plan, out, begun = load_sweep(study()), tmp_path / "out", []
    dying(pretended, monkeypatch, how, begun, checkpoints=checkpoints)
    for _ in range(5):
        with pytest.raises(type(how) if isinstance(how, Exception) else how):
            sweep(out, plan, console=quiet)
    assert len(begun) == 5


def test_a_trial_that_was_killed_before_it_had_its_values_gets_the_same_ones(pretended, study, tmp_path, quiet):
    plan, out = load_sweep(study()), tmp_path / "out"
    out.mkdir()
    Journal(out, plan).study.ask()  # a number, and nothing else
    (out / "plan.json").write_text(json.dumps(as_plan(plan)))
    assert values(sweep(out, plan, console=quiet)) == values(sweep(tmp_path / "whole", plan, console=quiet))


def test_processes_have_different_trials_and_leave_each_other_alone(study, tmp_path):
    plan = load_sweep(study(**{"trials = 4": "trials = 2"}))
    one, other, third = (Journal(tmp_path, plan) for _ in range(3))
    with one.claimed() as mine, other.claimed() as theirs:
        assert (mine.number, theirs.number) == (0, 1)
        with third.claimed() as nothing:
            assert nothing is None
    with third.claimed() as resumed:  # both have ended without a result
        assert resumed.number == 0 and resumed.params == mine.params
        with other.claimed() as next_one:
            assert next_one.number == 1


def test_a_trial_that_ended_meanwhile_is_not_worked_on_again(study, tmp_path):
    plan = load_sweep(study(**{"trials = 4": "trials = 1"}))
    one, other = Journal(tmp_path, plan), Journal(tmp_path, plan)
    with one.claimed() as mine:
        assert other.trials()[0].state.name == "RUNNING"
        one.study.tell(mine.number, 1.0)
    with other.claimed() as nothing:
        assert nothing is None


def test_half_a_line_of_a_process_that_died_is_dropped(study, tmp_path):
    plan = load_sweep(study())
    with Journal(tmp_path, plan).claimed() as trial:
        params = trial.params
    with (tmp_path / JOURNAL).open("a") as file:
        file.write('{"op_code":6,"wor')
    later = Journal(tmp_path, plan)
    with later.claimed() as trial:
        assert trial.number == 0 and trial.params == params
        later.study.tell(0, 2.0)
    assert Journal(tmp_path, plan).trials()[0].value == 2.0
    (tmp_path / JOURNAL).write_text("nonsense\n" * 3)
    with pytest.raises(JournalError, match=r"journal\.log: damaged"):
        Journal(tmp_path, plan).trials()


def test_a_grid_is_gone_through_in_its_order(pretended, study, tmp_path, quiet):
    plan = load_sweep(study(**{"trials = 4\n": "", '"random"': '"grid"', "high = -0.02": "high = -0.05, points = 5"}))
    results = sweep(tmp_path / "out", plan, console=quiet)
    assert values(results) == pytest.approx([-0.25, -0.2, -0.15, -0.1, -0.05])
    assert results.best[0].number == 3


def test_tpe_comes_nearer_than_its_first_random_trials(pretended, study, tmp_path, quiet):
    plan = load_sweep(study(**{"trials = 4": "trials = 24", '"random"': '"tpe"', "updates = 10": "updates = 1"}))
    results = sweep(tmp_path / "out", plan, console=quiet)
    off = [abs(value + 0.1) for value in values(results)]
    assert sum(off[10:]) / 14 < sum(off[:10]) / 10 and results.importance == {"driver_weights.time": 1.0}


def test_bad_trials_are_pruned_and_those_that_cannot_be_trained_fail(pretended, study, tmp_path, quiet, monkeypatch):
    changes = {"trials = 4": "trials = 12\nprune = true", "updates = 10": "updates = 40"}
    plan, train_in = load_sweep(study(**changes)), pretended.train_in

    def diverging(run, **how):
        if run.path.parent.name == "7":
            raise DivergedError(f"{run.path}: numbers are not finite")
        if run.path.parent.name == "8":
            raise WorldError("no such street with so few people")
        return train_in(run, **how)

    monkeypatch.setattr(trial_work, "train_in", diverging)
    results = sweep(tmp_path / "out", plan, console=quiet)
    assert results.trials[7].state == "failed" and "not finite" in results.trials[7].why
    assert results.trials[8].state == "failed" and "no such street" in results.trials[8].why
    pruned = [trial for trial in results.trials if trial.state == "pruned"]
    complete = sorted(trial.value for trial in results.best)
    assert pruned and all(trial.why.startswith("after update ") and trial.value is None for trial in pruned)
    assert all((trial.values["driver_weights.time"] + 0.1) ** 2 > complete[0] for trial in pruned)
    assert results.left == 0 and "2 failed" in results.in_words()


def test_a_changed_file_is_refused_but_for_more_trials(pretended, study, tmp_path, quiet):
    out = tmp_path / "out"
    sweep(out, load_sweep(study()), console=quiet)
    for old, new, named in (("-0.02", "-0.03", "vary"), ("updates = 10", "updates = 11", "training")):
        with pytest.raises(RunError, match=f"was begun with another value of {named}; undo the change"):
            sweep(out, load_sweep(study(**{old: new})), console=quiet)
    with pytest.raises(RunError, match="was begun with 4 trials; ask for no fewer"):
        sweep(out, load_sweep(study(**{"trials = 4": "trials = 3"})), console=quiet)
    assert len(sweep(out, load_sweep(study(**{"trials = 4": "trials = 5"})), console=quiet).trials) == 5
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "mine.txt").write_text("mine")
    with pytest.raises(RunError, match="not empty and no `jaxwalk sweep` made it"):
        sweep(tmp_path / "other", load_sweep(study()), console=quiet)


def test_a_process_that_chooses_a_trial_is_waited_for(study, tmp_path, monkeypatch):
    monkeypatch.setattr("jaxwalk.sweeps.journal.PATIENCE", 0.0)
    journal = Journal(tmp_path, load_sweep(study()))
    with held(tmp_path), pytest.raises(ValueError, match="another process is writing into it"), journal.claimed():
        pass


def test_who_joins_leaves_the_files_alone_that_another_process_is_writing(study, tmp_path, monkeypatch):
    plan, out = load_sweep(study()), tmp_path / "out"
    begin_sweep(out, plan)
    unfinished = out / ".study.json.123.part"
    unfinished.write_text("half")
    monkeypatch.setattr(sweeping, "PATIENCE", 0.0)
    with held(out / TRIALS), pytest.raises(InUseError):
        begin_sweep(out, plan)
    assert unfinished.exists()
    begin_sweep(out, plan)
    assert not unfinished.exists()


def test_results_are_written_while_others_choose_and_not_after_each_of_many_trials(
    pretended, study, tmp_path, quiet, monkeypatch
):
    plan, written = load_sweep(study(**{"trials = 4": "trials = 8"})), []

    def write(folder, results):
        with held(folder):  # raises if the lock for choosing a trial is held
            written.append(results.counts["complete"])
        time.sleep(0.1)

    monkeypatch.setattr(sweeping, "write_results", write)
    monkeypatch.setattr(sweeping, "BETWEEN", 1000)  # no trial takes that long here
    sweep(tmp_path / "out", plan, console=quiet)
    assert written == [1, 8]


def test_the_command_says_what_is_best_and_how_to_evaluate_it(pretended, study, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["sweep", str(study()), "--out", str(out)]) == 0
    said = capsys.readouterr().out
    assert said.startswith("4 of 4 trials ended: 4 complete\ntrial ")
    assert "The best of 4 is partly lucky" in said
    best = json.loads((out / "study.json").read_text())["best"][0]
    assert f"jaxwalk evaluate --driver {out}/trials/{best}/seed-0 --seed 1234" in said
    assert said.endswith(f"Open {out / 'study.html'}\n")


def test_interrupted_the_command_says_that_it_goes_on(pretended, study, tmp_path, capsys):
    pretended.stop_after = 5
    assert main(["sweep", str(study()), "--out", str(tmp_path / "out")]) == 130
    assert "The same command goes on where this one stopped" in capsys.readouterr().err


def test_only_updates_in_which_an_episode_ended_count_for_shares():
    lines = [
        {"update": n, "goal_rate": rate, "episodes": count}
        for n, (rate, count) in enumerate([(1, 5), (0, 0), (0.5, 2)])
    ]
    assert mean_of_last(lines, "goal_rate", 30) == 0.75
    assert mean_of_last(lines, "goal_rate", 10) == 0.5
    assert mean_of_last(lines[1:2], "goal_rate", 10) is None


def test_processes_may_begin_a_sweep_at_the_same_moment(study, tmp_path, monkeypatch):
    """The other one makes the folder after this one has looked for a plan."""
    plan, out, read = load_sweep(study()), tmp_path / "out", sweeping.read_json
    out.mkdir()

    def read_and_be_overtaken(path, command):
        found = read(path, command)
        monkeypatch.setattr(sweeping, "read_json", read)
        begin_sweep(out, plan)
        return found

    monkeypatch.setattr(sweeping, "read_json", read_and_be_overtaken)
    begin_sweep(out, plan)
    assert json.loads((out / "plan.json").read_text()) == as_plan(plan)
