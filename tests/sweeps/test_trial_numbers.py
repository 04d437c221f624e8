"""The number of a trial: of its training, or of an evaluation, by its name."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from jaxwalk.metrics import Summary
from jaxwalk.metrics.statistics import Estimate, Rate
from jaxwalk.runs.study import Interrupted
from jaxwalk.sweeps import trial_work
from jaxwalk.sweeps.evaluated import check_objective, number_named
from jaxwalk.sweeps.study_file import SweepFileError, SweepObjective, load_sweep
from jaxwalk.sweeps.sweeping import sweep
from jaxwalk.sweeps.trial_work import UselessTrialError, score_of

BY_EVALUATION = {
    '[objective]\nmetric = "reward/driver"': '[objective]\nof = "evaluation"\nmetric = "outcomes.goal"',
}


@pytest.fixture
def run(tmp_path):
    """A finished training of 20 updates, whose reward is the number of the update."""
    train = SimpleNamespace(updates=20)
    lines = [{"update": n, "episodes": 1, "reward/driver": float(n), "goal_rate": None} for n in range(1, 21)]
    return SimpleNamespace(path=tmp_path, metrics=lambda: lines, experiment=SimpleNamespace(train=train))


def test_the_number_of_a_training_is_the_mean_of_its_last_tenth(run):
    assert score_of(run, SweepObjective("reward/driver", "maximise")) == 19.5


def test_the_number_of_an_evaluation_is_asked_of_an_evaluation(run, monkeypatch):
    monkeypatch.setattr(trial_work, "evaluated", lambda run, objective: 0.25)
    assert score_of(run, SweepObjective("outcomes.goal", "maximise", of="evaluation")) == 0.25


@pytest.mark.parametrize("found", [None, float("nan"), float("inf")])
def test_a_trial_without_a_number_is_of_no_use(run, monkeypatch, found):
    monkeypatch.setattr(trial_work, "evaluated", lambda run, objective: found)
    with pytest.raises(UselessTrialError, match=r"has no delay\.mean; train longer, or choose another metric"):
        score_of(run, SweepObjective("delay.mean", "minimise", of="evaluation"))


def test_a_training_without_its_metric_is_of_no_use(run):
    with pytest.raises(UselessTrialError, match="has no reward/driver/time; train longer"):
        score_of(run, SweepObjective("reward/driver/time", "minimise"))


def test_numbers_of_an_evaluation_are_found_by_their_names():
    """Of a number with an interval, its value."""
    moving = SimpleNamespace(per_episode=Estimate(0.125, 0.1, 0.15, 40))
    outcomes = SimpleNamespace(goal=Rate(0.5, 0.1, 0.9, 1, 2), kilometres=3.5, moving=moving)
    summary = Summary(2, {"outcomes": outcomes})
    names = ("outcomes.goal", "outcomes.kilometres", "outcomes.moving.per_episode")
    assert [number_named(summary, name) for name in names] == [0.5, 3.5, 0.125]


def test_an_objective_of_an_evaluation_is_one_of_its_numbers(study):
    check_objective(load_sweep(study(**BY_EVALUATION)))
    wrong = {name: text.replace("outcomes.goal", "outcomes.goals") for name, text in BY_EVALUATION.items()}
    with pytest.raises(SweepFileError, match=r"an evaluation has no 'outcomes\.goals'; it has outcomes\.goal"):
        check_objective(load_sweep(study(**wrong)))


def test_a_signal_comes_before_an_evaluation(pretended, study, tmp_path, quiet, monkeypatch):
    """That takes long: the next process finds the training finished, and evaluates it."""
    plan, train_in, asked = load_sweep(study(**BY_EVALUATION | {"trials = 4": "trials = 1"})), pretended.train_in, []
    monkeypatch.setattr(trial_work, "train_in", lambda run, **how: replace(train_in(run, **how), heard=True))
    monkeypatch.setattr(trial_work, "evaluated", lambda run, objective: asked.append(run.path.name) or 0.5)
    with pytest.raises(Interrupted):
        sweep(tmp_path / "out", plan, console=quiet)
    assert asked == []
    results = sweep(tmp_path / "out", plan, console=quiet)
    assert asked == ["seed-0"] and results.best[0].value == 0.5 and len(pretended.trained) == 1
