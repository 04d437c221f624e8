"""`jaxwalk.train` and `jaxwalk.resume`: what they take, what they tell, what they leave."""

import tempfile
from pathlib import Path

import pytest

import jaxwalk
from jaxwalk import resume, train
from jaxwalk.recipes import ExperimentFileError
from jaxwalk.runs.entry import Upkeep
from jaxwalk.runs.folder import Run, RunError
from jaxwalk.runs.session import CallbackError, DivergedError


@pytest.fixture
def upkeep(quiet):
    return Upkeep(quiet)


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """The folder for temporary ones."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def _without_times(lines):
    return [{name: value for name, value in line.items() if name != "seconds"} for line in lines]


def test_a_training_without_a_folder_leaves_nothing_but_what_it_returns(tiny, whole, temporary, upkeep):
    told = []
    trained = train(tiny, on_update=told.append, upkeep=upkeep)
    assert (trained.updates, trained.steps, trained.folder) == (6, 384, None)
    assert not trained.interrupted and not trained.stopped
    assert told == list(trained.metrics)
    assert _without_times(told) == _without_times(whole.metrics())  # as the command trains
    assert [trained.policies[role].sample for role in ("driver", "pedestrian")] == [False, True]
    assert list(temporary.iterdir()) == []


def test_a_training_that_is_told_to_stop_can_be_resumed(tiny, whole, tmp_path, upkeep):
    told = []

    def stop_after_two(metrics):
        told.append(metrics["update"])
        metrics.clear()  # a callback has its own copy
        return told[-1] == 2

    stopped = train(tiny, tmp_path / "run", on_update=stop_after_two, upkeep=upkeep)
    assert stopped.stopped and not stopped.interrupted
    assert told == [1, 2, 3] and stopped.updates == 3  # the update in progress is made, and told
    went_on = resume(tmp_path / "run", on_update=lambda metrics: told.append(metrics["update"]), upkeep=upkeep)
    assert told == [1, 2, 3, 4, 5, 6]
    assert not went_on.stopped and went_on.folder == tmp_path / "run"
    assert _without_times(went_on.metrics) == _without_times(whole.metrics())


def test_seed_and_updates_replace_those_of_the_recipe(tiny, tmp_path, upkeep):
    trained = train(tiny, tmp_path / "run", seed=3, updates=1, upkeep=upkeep)
    experiment = Run.open(tmp_path / "run").experiment
    assert (experiment.seed, experiment.train.updates, trained.updates) == (3, 1, 1)
    assert sorted(trained.policies) == ["driver", "pedestrian"]


def test_an_answer_that_is_none_and_no_truth_value_is_an_error_and_leaves_no_folder(tiny, temporary, upkeep):
    with pytest.raises(CallbackError, match=r"on_update must return True to end the training, or None .* not 'yes'"):
        train(tiny, on_update=lambda _: "yes", upkeep=upkeep)
    assert list(temporary.iterdir()) == []


def test_what_the_callback_raises_passes_through(tiny, tmp_path, upkeep):
    class Pruned(Exception):
        pass

    def prune(metrics):
        raise Pruned

    with pytest.raises(Pruned):
        train(tiny, tmp_path / "run", on_update=prune, upkeep=upkeep)
    assert resume(tmp_path / "run", upkeep=upkeep).updates == 6


def test_numbers_that_diverge_leave_the_temporary_folder_that_the_message_names(tiny, temporary, upkeep, monkeypatch):
    def diverge(self, metrics, updates, before):
        self.save(before)
        raise DivergedError(f"{self.run.path}: update 1 gave numbers that are not finite")

    monkeypatch.setattr("jaxwalk.runs.session.Session.record", diverge)
    with pytest.raises(DivergedError) as error:
        train(tiny, upkeep=upkeep)
    (folder,) = temporary.iterdir()
    assert str(error.value).startswith(f"{folder}: ")
    assert (folder / "policy.safetensors").is_file()


@pytest.mark.parametrize(
    ("recipe", "changes", "message"),
    [
        ("fsat", {}, r"fsat: no recipe of that name \(fast, paper"),
        (Path("no/such.toml"), {}, r"no/such\.toml: no recipe of that name"),
        ("fast", {"seed": -1}, "seed must lie in"),
        ("fast", {"updates": 0}, "updates must be"),
    ],
)
def test_what_cannot_be_trained_is_named_before_anything_is_written(recipe, changes, message, tmp_path, upkeep):
    with pytest.raises(ValueError, match=message):
        train(recipe, tmp_path / "run", upkeep=upkeep, **changes)
    assert list(tmp_path.iterdir()) == []


def test_folders_are_not_mixed_up(whole, tiny, tmp_path, upkeep):
    with pytest.raises(RunError, match="the folder is not empty"):
        train(tiny, whole.path, upkeep=upkeep)
    with pytest.raises(RunError, match="no such run folder"):
        resume(tmp_path / "nowhere", upkeep=upkeep)


def test_a_wrong_file_is_an_error_of_the_file(tmp_path, upkeep):
    (tmp_path / "mine.toml").write_text("recipe = 'fsat'\n")
    with pytest.raises(ExperimentFileError, match="recipe: there is no 'fsat'"):
        train(tmp_path / "mine.toml", upkeep=upkeep)


def test_they_are_public():
    assert {"train", "resume"} <= set(jaxwalk.__all__)
