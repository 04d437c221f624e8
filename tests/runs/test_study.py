"""A study's folder: a training that is there already must be the one that the study asks for."""

from __future__ import annotations

import io
from dataclasses import asdict, replace

import pytest
from rich.console import Console

from jaxwalk.recipes import with_training
from jaxwalk.runs.effort import Effort
from jaxwalk.runs.folder import Run, RunError
from jaxwalk.runs.study import Interrupted, Work, read_json
from jaxwalk.runs.training import TrainingEnd


@pytest.fixture
def work(tmp_path, tiny):
    return Work(tmp_path / "out", Effort(updates=1), Console(file=io.StringIO(), width=200), tiny)


def _is_taken_for_finished(work, experiment, monkeypatch):
    """Return whether the study takes the training that is there, if it is finished, for its own."""
    monkeypatch.setattr("jaxwalk.runs.study.is_finished", lambda found: True)
    work.train("car", experiment, 3)
    return "car, seed 3: there already" in work.console.file.getvalue()


@pytest.mark.parametrize("other", [{"updates": 7}, {"learning_rate": 0.5}], ids=str)
def test_another_training_in_its_place_is_refused(work, tiny, other):
    folder = work.run("car", 3)
    Run.create(folder, replace(with_training(tiny, **other), seed=3))
    with pytest.raises(RunError, match=r"out/runs/car/seed-3: holds another training than this study's; remove it"):
        work.train("car", tiny, 3)


def test_another_seed_in_its_place_is_refused(work, tiny):
    Run.create(work.run("car", 3), replace(tiny, seed=4))
    with pytest.raises(RunError, match="holds another training"):
        work.train("car", tiny, 3)


def test_a_training_of_some_minutes_is_itself_once_it_is_planned(work, tiny, monkeypatch):
    """Its updates stand instead of the minutes then."""
    Run.create(work.run("car", 3), with_training(replace(tiny, seed=3), updates=1234))
    assert _is_taken_for_finished(work, replace(tiny, minutes=2.0), monkeypatch)


def test_the_machine_on_which_it_began_does_not_matter(work, tiny, monkeypatch):
    """Copied from another machine, it has other shards; names of many maps are those of each."""
    here = replace(tiny, maps=("training:2",), seed=3)
    run = Run.create(work.run("car", 3), with_training(here, shards=2, chunk_rows=64))
    assert run.experiment.maps != here.maps
    assert _is_taken_for_finished(work, here, monkeypatch)


def test_processes_may_begin_a_study_at_the_same_moment(work, monkeypatch):
    """The other one makes the folder after this one has looked for a plan."""
    monkeypatch.setattr(Work, "command", "study", raising=False)  # a study's own class names it
    work.folder.mkdir()

    def read_and_be_overtaken(path, command):
        monkeypatch.setattr("jaxwalk.runs.study.read_json", read_json)
        work.do([])
        return None

    monkeypatch.setattr("jaxwalk.runs.study.read_json", read_and_be_overtaken)
    work.do([])
    assert work.json("plan.json") == asdict(work.plan)


def test_a_signal_during_the_last_update_begins_no_other_training(work, tiny, monkeypatch):
    monkeypatch.setattr("jaxwalk.runs.study.train_in", lambda run, **_: TrainingEnd(6, 48, 1.0, False, heard=True))
    with pytest.raises(Interrupted):
        work.train("car", tiny, 3)
    assert "car, seed 3: 48 steps in 0.0 minutes" in work.console.file.getvalue()


def test_a_damaged_plan_is_not_to_be_deleted(tmp_path):
    """Without it, the folder would be refused as a stranger's."""
    for name, advice in (("plan.json", "restore it from a copy, or name another folder"), ("a.json", "delete it")):
        (tmp_path / name).write_text("{")
        with pytest.raises(RunError, match=advice):
            read_json(tmp_path / name, "study")
