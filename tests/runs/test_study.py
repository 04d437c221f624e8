"""A study's folder: a training that is there already must be the one that the study asks for."""

from __future__ import annotations

from dataclasses import replace

import pytest

from jaxwalk.recipes import with_training
from jaxwalk.runs.effort import Effort
from jaxwalk.runs.folder import Run, RunError
from jaxwalk.runs.study import Work
from jaxwalk.runs.training import is_finished


@pytest.fixture
def work(tmp_path, quiet, tiny):
    return Work(tmp_path / "out", Effort(updates=1), quiet, tiny)


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
    monkeypatch.setattr("jaxwalk.runs.study.is_finished", lambda found: not is_finished(found))
    work.train("car", replace(tiny, minutes=2.0), 3)


def test_the_machine_on_which_it_began_does_not_matter(work, tiny, monkeypatch):
    """Copied from another machine, it has other shards; names of many maps are those of each."""
    here = replace(tiny, maps=("training:2",), seed=3)
    run = Run.create(work.run("car", 3), with_training(here, shards=2, chunk_rows=64))
    assert run.experiment.maps != here.maps
    monkeypatch.setattr("jaxwalk.runs.study.is_finished", lambda found: not is_finished(found))
    work.train("car", here, 3)
