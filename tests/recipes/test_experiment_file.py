"""A training from a file: every field of a recipe can be written, and a mistake is one message that names the field."""

from __future__ import annotations

import dataclasses
import json
import tomllib
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from jaxwalk.cli import main
from jaxwalk.cli.options import Train
from jaxwalk.cli.train import make_experiment
from jaxwalk.recipes import RECIPES, Experiment, ExperimentFileError, load_experiment
from jaxwalk.sim.sim_config import WORLDS


def toml(value):
    """A value in TOML; JSON's own form but for tables."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(name)} = {toml(inner)}" for name, inner in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def without_none(value):
    if isinstance(value, dict):
        return {name: without_none(inner) for name, inner in value.items() if inner is not None}
    return [without_none(inner) for inner in value] if isinstance(value, list) else value


def written(path, table):
    path.write_text("".join(f"{name} = {toml(value)}\n" for name, value in without_none(table).items()))
    return path


@pytest.mark.parametrize("name", RECIPES)
def test_a_whole_recipe_can_be_written(name, tmp_path):
    """From another recipe: so each field that the file has is read."""
    content = TypeAdapter(Experiment).dump_python(RECIPES[name], mode="json")
    other = "paper" if name != "paper" else "town"
    begin = RECIPES[other]
    emptied = {
        weights: dict.fromkeys(getattr(begin, weights), 0.0) for weights in ("driver_weights", "pedestrian_weights")
    }
    table = {**content, "recipe": other, **{key: emptied[key] | content[key] for key in emptied}}
    found = load_experiment(written(tmp_path / "x.toml", table), RECIPES)
    kept = {key: {k: v for k, v in getattr(found, key).items() if v} for key in emptied}
    assert dataclasses.replace(found, recipe=name, **kept) == RECIPES[name]


def test_what_is_not_written_is_the_recipes(tmp_path):
    path = written(tmp_path / "x.toml", {"train": {"updates": 7, "roles": {"driver": {"entropy": 0.5}}}, "seed": 3})
    found, fast = load_experiment(path, RECIPES), RECIPES["fast"]
    driver = dataclasses.replace(fast.train.roles["driver"], entropy=0.5)
    train = dataclasses.replace(fast.train, updates=7, roles={**fast.train.roles, "driver": driver})
    assert found == dataclasses.replace(fast, train=train, seed=3)


def test_maps_are_beside_the_file_and_make_contacts_by_footprint(tmp_path):
    (tmp_path / "deep").mkdir()
    path = written(tmp_path / "deep" / "x.toml", {"recipe": "paper", "maps": ["mine.toml", "test:2"]})
    found = load_experiment(path, RECIPES)
    assert found.maps == (str(tmp_path / "deep" / "mine.toml"), "test:2") and found.sim.contact == "footprint"
    path = written(path, {"recipe": "paper", "maps": ["test:2"], "sim": {"contact": "disc"}})
    assert load_experiment(path, RECIPES).sim.contact == "disc"


def test_a_world_comes_before_its_numbers(tmp_path):
    path = written(tmp_path / "x.toml", {"world": "town", "sim": {"max_speed": 11.0}})
    assert load_experiment(path, RECIPES).sim == dataclasses.replace(WORLDS["town"], max_speed=11.0)


def test_options_change_what_the_file_says(tmp_path):
    path = written(tmp_path / "x.toml", {"seed": 3, "minutes": 5.0, "train": {"updates": 7, "clip": 0.3}})
    found = make_experiment(Train(config=path))
    assert (found.seed, found.minutes, found.train.updates) == (3, 5.0, 7)
    found = make_experiment(Train(config=path, seed=4, updates=9, single_agent=True))
    assert (found.seed, found.minutes, found.train.updates, found.train.clip) == (4, None, 9, 0.3)
    assert found.single_agent


WRONG = {
    "a field": ("[train]\nlearing_rate = 0.1", "train.learing_rate: there is no such field; perhaps learning_rate is"),
    "a table": ("[trian]\nx = 1", "trian: there is no such field; perhaps train is meant"),
    "a role": ("[train.roles.cyclist]\nhold = 2", "train.roles.cyclist: there is no such role; there are driver"),
    "of a role": ("[train.roles.driver]\nhidden = [2]", "train.roles.driver.hidden: there is no such field"),
    "a kind": ('[train]\nupdates = "many"', "train.updates: must be a valid integer, not 'many'"),
    "text for a number": ('seed = "3"', "seed: must be a valid integer, not '3'"),
    "a range": ("[train]\nlearning_rate = -1", "train: learning_rate must be a finite number above 0, not -1"),
    "infinity": ("[sim]\nmax_speed = inf", "sim: max_speed must be at most 100, not inf"),
    "of the world": ("[sim]\nmax_sped = 3", "sim.max_sped: there is no such field; perhaps max_speed is meant"),
    "a choice": ('[train]\ncredit = "mine"', "train.credit: must be 'individual' or 'shared', not 'mine'"),
    "a date": ("seed = 2026-01-01", "seed: must be a valid integer, not '2026-01-01'"),
    "a limit": ("[train.roles.driver]\nlimits = [{ cost = 'x' }]", "train.roles.driver.limits.0.limit: Field required"),
    "a kind of people": ("[sim]\nkinds = [{ name = 'x' }]", "sim.kinds"),
    "a recipe": ('recipe = "fst"', "recipe: there is no 'fst'; there are fast, paper"),
    "a recipe's kind": ("recipe = [1]", "recipe: there is no [1]; there are fast, paper"),
    "a world": ('world = "moon"', "world: there is no 'moon'; there are paper"),
    "a map's kind": ("maps = 3", "maps: must be a valid array, not 3"),
    "no TOML": ("seed = ", "not TOML that can be read"),
}  # fmt: skip


@pytest.mark.parametrize("text, message", WRONG.values(), ids=WRONG)
def test_a_mistake_is_one_message_that_names_the_field(text, message, tmp_path, capsys):
    path = tmp_path / "x.toml"
    path.write_text(text)
    with pytest.raises(ExperimentFileError) as error:
        load_experiment(path, RECIPES)
    assert message in str(error.value) and "\n" not in str(error.value)
    assert main(["train", "--run", str(tmp_path / "run"), "--config", str(path)]) == 2
    assert capsys.readouterr().err == f"jaxwalk: {error.value}\n"
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--config x.toml --recipe town", "--recipe: the file of --config names the recipe"),
        ("--config x.toml --map nowhere", "no such map"),
        ("--config weights.toml", "rewards.driver.luck is no reward term"),
        ("--config sets.toml", "train.roles.driver.observes must be one of"),
        ("--config maps.toml", "map nowhere has"),
    ],
)
def test_the_command_refuses_the_rest(words, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "x.toml", {"seed": 1})
    written(tmp_path / "weights.toml", {"driver_weights": {"luck": 1.0}})
    written(tmp_path / "sets.toml", {"train": {"roles": {"driver": {"observes": "everything"}}}})
    written(tmp_path / "maps.toml", {"maps": ["nowhere"]})
    assert main(["train", "--run", "run", *words.split()]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_files_that_are_no_files(tmp_path):
    for path, message in ((tmp_path, "not a regular file"), (tmp_path / "none.toml", "cannot be read")):
        with pytest.raises(ExperimentFileError, match=message):
            load_experiment(path, RECIPES)
    (tmp_path / "latin.toml").write_bytes(b'recipe = "\xff"')
    with pytest.raises(ExperimentFileError, match="not TOML that can be read"):
        load_experiment(tmp_path / "latin.toml", RECIPES)


def test_the_page_shows_a_file_that_is_read():
    page = (Path(__file__).parents[2] / "docs" / "recipes.md").read_text(encoding="utf-8")
    text = page.partition('```toml title="mine.toml"\n')[2].partition("```")[0]
    path = Path("mine.toml")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("jaxwalk.recipes.experiment_file.read_table", lambda _: tomllib.loads(text))
        found = load_experiment(path, RECIPES)
    assert found.recipe == "town" and found.crowds == (12, 48) and found.sim.perception
