"""A training that begins where another one is."""

from __future__ import annotations

import shutil
from dataclasses import replace

import pytest

from jaxwalk.learning import checkpoint
from jaxwalk.recipes import with_training
from jaxwalk.runs.binding import EditedConfigError
from jaxwalk.runs.branching import begin_at
from jaxwalk.runs.folder import Run
from jaxwalk.runs.progress import Display
from jaxwalk.runs.training import is_finished, train_in, train_until


@pytest.fixture(scope="module")
def half(tiny, tmp_path_factory):
    """The run of a training that has ended after three of its six updates."""
    import io

    from rich.console import Console

    run = Run.create(tmp_path_factory.mktemp("runs") / "half", tiny)
    ended = train_until(run, 3, display=Display(Console(file=io.StringIO())))
    assert (ended.updates, ended.interrupted, ended.stopped) == (3, False, False)
    return run


def told(run):
    return [{**line, "seconds": 0} for line in run.metrics()]


def test_a_training_ends_before_its_plan_and_is_the_same_so_far(half, whole):
    assert told(half) == told(whole)[:3]
    assert is_finished(half, 3) and not is_finished(half)


def test_a_branch_with_the_same_numbers_becomes_the_same(half, whole, tmp_path, quiet):
    branch = Run.create(tmp_path / "branch", half.experiment)
    begin_at(branch, half, 3)
    train_in(branch, resume=True, display=Display(quiet))
    assert told(branch) == told(whole)[3:]
    assert branch.policy.read_bytes() == whole.policy.read_bytes()


def test_a_branch_has_its_own_numbers_and_leaves_its_parent_alone(half, whole, tmp_path, quiet):
    before = {path: path.read_bytes() for path in half.path.rglob("*") if path.is_file()}
    branch = Run.create(tmp_path / "branch", with_training(half.experiment, learning_rate=2e-3))
    begin_at(branch, half, 3)
    begin_at(branch, half, 3)  # once is enough
    assert train_until(Run.open(branch.path), 4, resume=True, display=Display(quiet)).updates == 4
    assert branch.metrics()[0]["learning_rate"] == pytest.approx(2e-3 * (1 - 3 / 6))
    assert told(branch)[0]["reward/driver"] == told(whole)[3]["reward/driver"]  # played before anything is learned
    assert {path: path.read_bytes() for path in half.path.rglob("*") if path.is_file()} == before


def test_a_checkpoint_that_is_not_there_or_of_another_street_is_refused(half, tiny, tmp_path, quiet):
    branch = Run.create(tmp_path / "branch", half.experiment)
    with pytest.raises(checkpoint.DamagedError, match="checkpoint 2 is missing or can't be read"):
        begin_at(branch, half, 2)
    assert checkpoint.latest(branch.checkpoints) is None
    shutil.rmtree(branch.path)
    other = Run.create(tmp_path / "other", replace(tiny, maps=("test-track",)))
    begin_at(other, half, 3)
    with pytest.raises(EditedConfigError, match="the content of the maps"):
        train_in(other, resume=True, display=Display(quiet))
