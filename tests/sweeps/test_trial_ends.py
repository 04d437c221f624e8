"""How a trial ends when signals, damaged files or other processes come between; trainings are pretended."""

from __future__ import annotations

import io
import json
import shutil
from dataclasses import replace
from importlib import resources
from types import SimpleNamespace

import pytest
from rich.console import Console

from jaxwalk import writing
from jaxwalk.learning.checkpoint import DamagedError
from jaxwalk.policies.learned import PolicyError
from jaxwalk.runs.folder import RunError
from jaxwalk.runs.lock import held
from jaxwalk.runs.study import Interrupted
from jaxwalk.runs.training import UnwrittenError, is_finished
from jaxwalk.sweeps import journal, trial_work
from jaxwalk.sweeps.journal import Journal, OptunaError
from jaxwalk.sweeps.study_file import load_sweep
from jaxwalk.sweeps.sweep_results import read_results
from jaxwalk.sweeps.sweeping import begin_sweep, sweep
from jaxwalk.sweeps.trial_work import TrialWork


class Gone(BaseException):
    """Ends a process at once."""


def ending(pretended, monkeypatch, trial, end):
    """Let ``end`` be called with the run of one trial, instead of training."""

    def train_in(run, **words):
        return end(run, **words) if run.path.parent.name == trial else pretended.train_in(run, **words)

    monkeypatch.setattr(trial_work, "train_in", train_in)


def test_a_process_that_a_signal_ends_at_once_is_no_attempt(pretended, study, tmp_path, quiet, monkeypatch):
    """What it was writing is removed then, as `Signals.end_now` does, and with it the mark of the attempt."""
    plan, ends = load_sweep(study()), []

    def end_now(run, **_):
        ends.append(run)
        writing.remove_own_unfinished()
        raise Gone

    ending(pretended, monkeypatch, "1", end_now)
    for _ in range(5):
        with pytest.raises(Gone):
            sweep(tmp_path / "out", plan, console=quiet)
    assert len(ends) == 5


def test_a_signal_during_the_last_update_begins_no_other_training(pretended, study, tmp_path, quiet, monkeypatch):
    """The training is complete and has its number; the same command goes on with the next one."""
    plan, out = load_sweep(study(**{"trials = 4": "trials = 2\nseeds = 2"})), tmp_path / "out"
    ending(pretended, monkeypatch, "0", lambda run, **how: replace(pretended.train_in(run, **how), heard=True))
    for seeds in (1, 2):
        with pytest.raises(Interrupted):
            sweep(out, plan, console=quiet)
        assert len(read_results(Journal(out, plan)).trials[0].seeds) == seeds
    results = sweep(out, plan, console=quiet)
    assert [made for _, _, made in pretended.trained] == [0] * 4, "nothing is trained twice"
    assert [trial.state for trial in results.trials] == ["complete"] * 2


def test_a_damaged_trial_is_left_and_the_others_go_on(pretended, study, tmp_path, monkeypatch):
    plan, out, told = load_sweep(study()), tmp_path / "out", Console(file=io.StringIO(), width=500)

    def damaged(run, **_):
        raise DamagedError(f"{run.path}: no checkpoint can be read")

    ending(pretended, monkeypatch, "1", damaged)
    with pytest.raises(DamagedError, match=r"trials/1/seed-0: no checkpoint can be read"):
        sweep(out, plan, console=told)
    assert "trial 1 is left: " in told.file.getvalue()
    states = [trial.state for trial in read_results(Journal(out, plan)).trials]
    assert states == ["complete", "unfinished", "complete", "complete"]
    monkeypatch.setattr(trial_work, "train_in", pretended.train_in)
    assert sweep(out, plan, console=told).left == 0


def test_a_trial_whose_policy_is_damaged_is_left(pretended, study, tmp_path, quiet, monkeypatch):
    plan, out, finished = load_sweep(study()), tmp_path / "out", trial_work.is_finished

    def read(run, updates):
        return is_finished(run, updates) if run.path.parent.name == "1" else finished(run, updates)

    begin_sweep(out, plan)
    monkeypatch.setattr(trial_work, "is_finished", read)
    ending(pretended, monkeypatch, "1", lambda run, **_: (run.policy.write_bytes(b"half"), 1 / 0))
    with pytest.raises(ZeroDivisionError):
        sweep(out, plan, console=quiet)
    with pytest.raises(PolicyError):
        sweep(out, plan, console=quiet)
    states = [trial.state for trial in read_results(Journal(out, plan)).trials]
    assert states == ["complete", "unfinished", "complete", "complete"]


def test_a_full_disk_ends_the_process(pretended, study, tmp_path, quiet, monkeypatch):
    def full(run, **_):
        raise UnwrittenError("no space left")

    ending(pretended, monkeypatch, "1", full)
    with pytest.raises(UnwrittenError):
        sweep(tmp_path / "out", load_sweep(study()), console=quiet)
    assert [name for name, _, _ in pretended.trained] == ["0"]


def test_a_run_of_other_values_is_not_taken_for_a_trials(pretended, study, tmp_path, quiet):
    """As after a journal was restored from an older copy: trials are drawn anew, their folders are there."""
    plan, out = load_sweep(study()), tmp_path / "out"
    sweep(tmp_path / "other", load_sweep(study(**{"trials = 4\n": "trials = 4\nsampler_seed = 1\n"})), console=quiet)
    begin_sweep(out, plan)
    shutil.copytree(tmp_path / "other" / "trials", out / "trials")
    with pytest.raises(RunError, match=r"trials/0/seed-0: holds another training than this trial's; remove it"):
        sweep(out, plan, console=quiet)
    shutil.rmtree(out / "trials")
    assert sweep(out, plan, console=quiet).left == 0


@pytest.mark.parametrize(
    ("value", "step", "before", "worse"),
    [
        (0.9, 5, [0.2] * 5, True),
        (0.2, 5, [0.2] * 5, False),
        (0.9, 4, [0.2] * 5, False),
        (0.9, 5, [0.2] * 4, False),
        (0.3, 5, [0.1, 0.2, 0.25, 0.8, 0.9], True),
    ],
)
def test_a_trial_is_judged_by_the_median_at_the_same_point(study, tmp_path, quiet, value, step, before, worse):
    """Minimised, whatever it reported earlier: the first numbers of a training may be small for other reasons."""
    trials = [SimpleNamespace(state=SimpleNamespace(name="COMPLETE"), intermediate_values={5: x}) for x in before]
    if step == 4:
        trials = [SimpleNamespace(state=each.state, intermediate_values={4: 0.2}) for each in trials]
    ours = SimpleNamespace(state=SimpleNamespace(name="RUNNING"), intermediate_values={1: 0.0, 5: 0.0})
    trial = SimpleNamespace(study=SimpleNamespace(get_trials=lambda deepcopy: [*trials, ours]))
    assert TrialWork(trial, load_sweep(study()), tmp_path, quiet)._is_worse(value, step) == worse  # pyright: ignore


@pytest.mark.parametrize(("sampler", "ended"), [("random", 0), ("tpe", 12)])
def test_a_trial_killed_between_two_values_gets_the_same_ones(sampler, ended, pretended, study, tmp_path):
    """After ten trials TPE draws the values of a trial together."""
    end = "high = -0.02 }"
    changes = {
        end: f"{end}\nspeed = {{ low = 0.0, high = 1.0 }}",
        "trials = 4": "trials = 20",
        '"random"': f'"{sampler}"',
    }
    plan, whole = load_sweep(study(**changes)), []
    name, varied = next(iter(plan.fields.items()))
    for killed in (False, True):
        journal = Journal(tmp_path / str(killed), plan)
        begin_sweep(journal.folder, plan)
        for number in range(ended):
            with journal.claimed() as trial:
                journal.study.tell(number, trial.params[name] ** 2)
        if killed:
            journal.study.sampler = journal._sampler(ended)
            journal.study.ask().suggest_float(name, varied.low, varied.high)
        with journal.claimed() as trial:
            assert trial.number == ended
            whole.append(dict(trial.params))
    assert whole[0] == whole[1] and len(set(whole[0].values())) == 2


def test_a_process_with_an_older_file_counts_all_trials(pretended, study, tmp_path, quiet):
    few, many = load_sweep(study()), load_sweep(study(**{"trials = 4": "trials = 6"}))
    sweep(tmp_path / "out", many, console=quiet)
    results = read_results(Journal(tmp_path / "out", few))
    assert results.left == 0 and results.in_words() == "6 of 6 trials ended: 6 complete"


def test_a_folder_that_was_only_begun_is_made_anew(pretended, study, tmp_path, quiet):
    """A process was killed before it had written what a run begins with."""
    plan, half = load_sweep(study(**{"trials = 4": "trials = 1"})), tmp_path / "out/trials/0/seed-0/half.json"
    begin_sweep(tmp_path / "out", plan)
    half.parent.mkdir(parents=True)
    half.write_text("{")
    assert sweep(tmp_path / "out", plan, console=quiet).left == 0
    assert not half.exists() and half.parent.exists()


def test_a_file_is_no_folder_of_a_sweep(study, tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(RunError, match="out: is a file, not a folder; name another one"):
        begin_sweep(tmp_path / "out", load_sweep(study()))


def test_without_optuna_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setattr(journal.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(OptunaError, match=r'install it with: pip install "jaxwalk\[sweep\]"'):
        journal.check_optuna()


def test_a_trial_that_ends_before_it_can_be_locked_is_left(study, tmp_path, monkeypatch):
    """Its process tells its number and frees it between the look at the journal and the lock."""
    one, other = (Journal(tmp_path, load_sweep(study(**{"trials = 4": "trials = 1"}))) for _ in range(2))
    with one.claimed() as mine:
        pass

    def late(folder, **how):
        if folder == other.trial_folder(0):
            one.study.tell(mine.number, 1.0)
        return held(folder, **how)

    monkeypatch.setattr(journal, "held", late)
    with other.claimed() as nothing:
        assert nothing is None


def test_a_range_between_whole_numbers_has_whole_numbers(study, tmp_path):
    fields = "[vary.train.roles.driver]\nepochs = { low = 2, high = 5 }\n[vary.driver_weights]"
    with Journal(tmp_path, load_sweep(study(**{"[vary.driver_weights]": fields}))).claimed() as trial:
        assert trial.params["train.roles.driver.epochs"] in (2, 3, 4, 5)


def test_a_map_that_was_changed_meanwhile_is_refused(pretended, study, tmp_path):
    path, out = tmp_path / "street.toml", tmp_path / "out"
    path.write_text(resources.files("jaxwalk.maps").joinpath("paper.toml").read_text())
    plan = load_sweep(study(**{"[training.train]": '[training]\nmaps = ["street.toml"]\n[training.train]'}))
    begin_sweep(out, plan)
    begin_sweep(out, plan)
    path.write_text(path.read_text() + "\n")
    with pytest.raises(RunError, match=r"street\.toml was changed since the sweep began; restore it"):
        begin_sweep(out, plan)
    document = json.loads((out / "plan.json").read_text())
    del document["files"]  # of an older version
    (out / "plan.json").write_text(json.dumps(document))
    begin_sweep(out, plan)
