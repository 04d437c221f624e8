"""A sweep's file: what it says, and one message for each mistake."""

from __future__ import annotations

from importlib import resources

import pytest

from jaxwalk.cli import main
from jaxwalk.recipes import RECIPES
from jaxwalk.sweeps.study_file import load_sweep
from jaxwalk.sweeps.varied import ListedValues, ValueRange, VariedError, changes_of, grid_of

EVALUATION = '[objective]\nmetric = "reward/driver"\n'
EVALUATED = '[objective]\nof = "evaluation"\nmetric = "outcomes.goal"\n'
WRONG = {
    "sampler": ("random", "bohb", "sampler: must be 'tpe', 'random', 'grid' or 'pbt', not 'bohb'"),
    "no trials": ("trials = 4", "", "trials is needed with random"),
    "trials of a grid": ('"random"', '"grid"', "trials is decided by the grid; leave it out"),
    "unknown": ("trials = 4", "trials = 4\nsees = 2", "sees: there is no such field; perhaps seeds is meant"),
    "its own path": ("trials = 4", 'trials = 4\npath = "x"', "path: there is no such field"),
    "seeds": ("trials = 4", "trials = 4\nseeds = 0", "seeds must lie in [1, 1,000], not 0"),
    "objective": ("reward/driver", "reward/drover", "objective.metric: there is no 'reward/drover' of a training"),
    "direction": ("minimise", "min", "objective.direction: must be 'maximise' or 'minimise', not 'min'"),
    "no direction": ('direction = "minimise"', "", "objective.direction is missing"),
    "of training": ("[objective]", "[objective]\nepisodes = 9", "objective: episodes belongs to an evaluation"),
    "pruned evaluation": (
        '[objective]\nmetric = "reward/driver"',
        'prune = true\n[objective]\nof = "evaluation"\nmetric = "outcomes.goal"',
        "prune needs an objective of the training",
    ),
    "episodes": (EVALUATION, f"{EVALUATED}episodes = 0\n", "objective: episodes must lie in [1, 10,000,000], not 0"),
    "seed of scenarios": (EVALUATION, f"{EVALUATED}seed = -1\n", "objective: seed must lie in [0, 2^31), not -1"),
    "suite": (EVALUATION, f'{EVALUATED}suite = "moon"\n', "objective: suite must be one of paper, "),
    "no trial": ("trials = 4", "trials = 0", "trials must lie in [1, 100,000], not 0"),
    "sampler seed": ("trials = 4", "trials = 4\nsampler_seed = -1", "sampler_seed must lie in [0, 2^31), not -1"),
    "last seed": (
        "trials = 4",
        "trials = 4\nseeds = 2\ntraining.seed = 4294967295",
        "seeds: training.seed + seeds must be at most 2^32",
    ),
    "nothing varies": (
        "[vary.driver_weights]\ntime = { low = -0.25, high = -0.02 }",
        "[vary]",
        "vary must name at least one field",
    ),
    "one point": (
        "high = -0.02",
        "high = -0.02, points = 1",
        "vary.driver_weights.time: points must lie in [2, 10,000]",
    ),
    "tables": (
        "{ low = -0.25, high = -0.02 }",
        "[{ a = 1 }, { a = 2 }]",
        "vary.driver_weights.time: a value can't be a table; name the fields inside it",
    ),
    "a grid without points": (
        'sampler = "random"\ntrials = 4',
        'sampler = "grid"',
        "vary.driver_weights.time: a grid needs points, the number of values of the range",
    ),
    "training": ("updates = 10", "updats = 10", "training.train.updats: there is no such field; perhaps updates"),
    "minutes": ("[training.train]", "[training]\nminutes = 3.0\n[training.train]", "training.minutes: trials are"),
    "value": ("high = -0.02", 'high = "a"', "vary.driver_weights.time: high: must be"),
    "order": ("high = -0.02", "high = -0.3", "vary.driver_weights.time: low must be below high"),
    "log": ("high = -0.02", "high = -0.02, log = true", "vary.driver_weights.time: low must be above 0 with log"),
    "points": ("high = -0.02", "high = -0.02, points = 3", "vary.driver_weights.time: points belongs to a grid"),
    "one value": ("{ low = -0.25, high = -0.02 }", "[-0.1]", "vary.driver_weights.time: needs at least two values"),
    "no range": ("{ low = -0.25, high = -0.02 }", "-0.1", "vary.driver_weights.time: -0.1 doesn't vary; give a list"),
    "seed": ("[vary.driver_weights]\ntime = {", "[vary]\nseed = {", "vary.seed can't vary: each trial is trained"),
    "impossible": (
        "[vary.driver_weights]",
        "[vary.train]\nminibatches = [2, 3]\n[vary.driver_weights]",
        "vary.train: minibatches must divide steps (8), not 3",
    ),
}

POPULATION = 'sampler = "pbt"\n[pbt]\nmembers = 4\ngenerations = 5\n'
"""In the place of the sampler and the number of trials."""
WRONG_POPULATION = {
    "no table": ("[pbt]\nmembers = 4\ngenerations = 5\n", "", "pbt is needed with the sampler pbt: a table that says"),
    "no members": ("members = 4\n", "", "pbt.members is missing"),
    "members": ("members = 4", "members = 1", "pbt: members must lie in [2, 1,000], not 1"),
    "generations": ("generations = 5", "generations = 3", "pbt.generations must divide training.train.updates (10)"),
    "unknown": (
        "members = 4",
        "members = 4\ntruncate = 0.5",
        "pbt.truncate: there is no such field; perhaps truncation",
    ),
    "truncation": ("members = 4", "members = 4\ntruncation = 0.6", "pbt: truncation must be above 0 and at most 0.5"),
    "factors": ("members = 4", "members = 4\nfactors = [1, 1.2]", "pbt: factors must be finite numbers above 0 other"),
    "too many": (
        "members = 4\ngenerations = 5",
        "members = 1000\ngenerations = 1000",
        "pbt has 1,000,000 trials, members x generations; at most 100,000",
    ),
    "resample": ("members = 4", "members = 4\nresample = 2.0", "pbt: resample must lie in [0, 1], not 2"),
    "trials": ("[pbt]", "trials = 4\n[pbt]", "trials is decided by the population; leave it out"),
    "pruned": ("[pbt]", "prune = true\n[pbt]", "prune doesn't go with pbt"),
    "another sampler": ('"pbt"', '"grid"', "pbt goes with sampler = \"pbt\", not 'grid'; leave it out"),
    "a network": (
        "[vary.driver_weights]",
        "[vary.train.roles.driver]\nactor_hidden = [[8], [16]]\n[vary.driver_weights]",
        "vary.train.roles.driver.actor_hidden can't change in the middle of a training",
    ),
    "a world": (
        "[vary.driver_weights]",
        "[vary.sim]\npedestrians = [4, 8]\n[vary.driver_weights]",
        "vary.sim.pedestrians can't change in the middle of a training",
    ),
}


@pytest.mark.parametrize("name", WRONG_POPULATION)
def test_a_mistake_about_a_population_is_one_message_too(name, study, tmp_path, capsys):
    path = study(**{'sampler = "random"\ntrials = 4\n': POPULATION})
    old, new, said = WRONG_POPULATION[name]
    assert path.read_text().count(old) == 1
    path.write_text(path.read_text().replace(old, new))
    assert main(["sweep", str(path), "--out", str(tmp_path / "out")]) == 2
    err = capsys.readouterr().err
    assert said in err and err.startswith(f"jaxwalk: {path}: ") and err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_what_changes_no_checkpoint_may_change_in_a_population(study):
    fields = "[vary.train]\nlearning_rate = { low = 1e-4, high = 1e-2, log = true }\nminibatches = [1, 2]\n"
    roles = "[vary.train.roles.pedestrian]\nentropy = [0.0, 0.1]\n"
    plan = load_sweep(
        study(**{'sampler = "random"\ntrials = 4\n': POPULATION, "[vary.driver": fields + roles + "[vary.driver"})
    )
    assert plan.count == 20 and len(plan.fields) == 4 and plan.pbt.factors == (0.8, 1.2)


@pytest.mark.parametrize("name", WRONG)
def test_a_mistake_is_one_message_that_names_the_field(name, study, tmp_path, capsys):
    old, new, said = WRONG[name]
    assert main(["sweep", str(study(**{old: new})), "--out", str(tmp_path / "out")]) == 2
    err = capsys.readouterr().err
    assert said in err and err.startswith(f"jaxwalk: {tmp_path / 'study.toml'}: ") and err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_name_that_only_the_street_knows_is_refused_before_anything_is_written(study, tmp_path, capsys):
    names = '[vary.train.roles.driver]\nobserves = ["route-footprint", "rout"]\n'
    path = study(**{"[vary.driver_weights]": names + "[vary.driver_weights]"})
    assert main(["sweep", str(path), "--out", str(tmp_path / "out")]) == 2
    assert "train.roles.driver.observes must be one of " in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_value_that_is_always_varied_need_not_fit_before(study):
    """The recipe's 32 minibatches don't divide 8 steps."""
    changed = {
        "minibatches = 2\n": "",
        "[vary.driver_weights]": "[vary.train]\nminibatches = [4, 8]\n[vary.driver_weights]",
    }
    plan = load_sweep(study(**changed))
    assert plan.base.train.minibatches == 4
    assert plan.experiment({"train.minibatches": 8, "driver_weights.time": -0.1}).train.minibatches == 8


def test_a_trial_is_the_training_with_its_values(study):
    plan = load_sweep(study())
    found = plan.experiment({"driver_weights.time": -0.125})
    assert found.driver_weights == {**RECIPES["fast"].driver_weights, "time": -0.125}
    assert (found.train.updates, found.train.environments) == (10, 8)
    assert list(plan.training_seeds(found)) == [0] and plan.count == 4


def test_the_example_is_a_sweep(tmp_path, capsys):
    assert main(["sweep", "--example"]) == 0
    path = tmp_path / "study.toml"
    path.write_text(capsys.readouterr().out)
    assert path.read_text() == resources.files("jaxwalk.sweeps").joinpath("example.toml").read_text(encoding="utf-8")
    plan = load_sweep(path)
    assert list(plan.fields) == [
        "train.learning_rate", "train.minibatches", "train.roles.driver.entropy", "driver_weights.time"
    ]  # fmt: skip


def test_without_a_file_the_example_is_named(capsys):
    assert main(["sweep"]) == 2
    assert "jaxwalk sweep --example prints one" in capsys.readouterr().err


def test_a_grid_has_all_combinations():
    fields = {"train.roles.driver.actor_hidden": ListedValues(([8], [8, 8])), "x": ValueRange(1e-4, 1e-2, True, 3)}
    grid = grid_of(fields)
    assert [list(labels.values()) for labels in grid[:2]] == [["[8]", 1e-4], ["[8]", pytest.approx(1e-3)]]
    assert len(grid) == 6 and grid[-1] == {"train.roles.driver.actor_hidden": "[8, 8]", "x": 1e-2}
    nested = {"train": {"roles": {"driver": {"actor_hidden": [8, 8]}}}, "x": 1e-2}
    assert changes_of(fields, grid[-1]) == nested


def test_a_grid_of_too_many_combinations_is_refused():
    fields = {"a": ValueRange(0.0, 1.0, points=101), "b": ListedValues(tuple(range(100)))}
    with pytest.raises(VariedError, match="a: the grid has 10,100 combinations; at most 10,000"):
        grid_of(fields)


def test_whole_ends_have_whole_numbers_between_them():
    assert ValueRange(1, 8, log=True, points=4).grid() == (1, 2, 4, 8)
    assert ValueRange(1, 4, points=7).grid() == (1, 2, 3, 4)
    assert ValueRange(0.0, 1.0, points=3).grid() == (0.0, 0.5, 1.0)
