"""The run folder: what is written comes back, and what is damaged is refused by name."""

import json
import re
from dataclasses import replace

import pytest

from jaxwalk.cli import main
from jaxwalk.maps import each_map
from jaxwalk.recipes import RECIPES, single_agent, with_training
from jaxwalk.runs.folder import Run, RunError


def _edited(tmp_path, where, value):
    """A run folder with another value at a place of its configuration."""
    run = Run.create(tmp_path / "run", RECIPES["fast"])
    document = json.loads((run.path / "config.json").read_text())
    inner = document
    for name in where[:-1]:
        inner = inner[name]
    inner[where[-1]] = value
    (run.path / "config.json").write_text(json.dumps(document))
    return run.path


@pytest.mark.parametrize("name", RECIPES)
def test_configuration_comes_back(tmp_path, name):
    experiment = single_agent(with_training(RECIPES[name], learning_rate=1e-3))
    maps = tuple(map_name.replace(":64", ":2") for map_name in experiment.maps)  # 64 take half a minute
    Run.create(tmp_path / "run", replace(experiment, maps=maps))
    assert Run.open(tmp_path / "run").experiment == replace(experiment, maps=each_map(maps))


def test_a_new_run_writes_its_configuration_and_its_maps_alone(tmp_path):
    run = Run.create(tmp_path / "a" / "run", RECIPES["fast"])
    assert sorted(path.name for path in run.path.iterdir()) == [".lock", "config.json", "maps.json"]


def test_what_a_process_killed_at_once_left_is_in_nobodys_way(tmp_path):
    for name in (".lock", ".config.123.part.json"):
        (tmp_path / name).touch()
    assert Run.create(tmp_path, RECIPES["fast"]).experiment == RECIPES["fast"]
    with pytest.raises(RunError, match="not empty"):
        Run.create(tmp_path, RECIPES["fast"])


def test_an_empty_folder_may_be_used(tmp_path):
    assert Run.create(tmp_path, RECIPES["fast"]).experiment == RECIPES["fast"]


def test_a_run_is_not_overwritten(tmp_path):
    Run.create(tmp_path / "run", RECIPES["fast"])
    with pytest.raises(RunError, match=r"not empty; continue it with `jaxwalk train --resume"):
        Run.create(tmp_path / "run", RECIPES["fast"])


@pytest.mark.parametrize(
    ("where", "value", "message"),
    [
        (("train", "learning_rat"), 1, r"config.json: train.learning_rat: Unexpected keyword"),
        (("surprise",), 1, r"config.json: surprise: Unexpected keyword"),
        (("train", "minibatches"), 7, r"config.json: train: .*minibatches must divide steps \(64\), not 7"),
        (("train", "roles", "driver", "epochs"), "many", r"config.json: train.roles.driver.epochs: .*integer"),
        (("sim", "dt"), 0, r"config.json: sim: .*dt must be above 0"),
        (("minutes",), 0, r"config.json: .*minutes must be above 0 and at most"),
        (("seed",), -1, r"config.json: .*seed must lie in \[0, 2\^32\), not -1"),
    ],
)
def test_a_wrong_configuration_is_named(tmp_path, where, value, message):
    folder = _edited(tmp_path, where, value)
    with pytest.raises(RunError, match=message):
        Run.open(folder)


def test_metrics_cut_short_or_too_many_are_dropped(tmp_path):
    run = Run.create(tmp_path / "run", RECIPES["fast"])
    lines = "".join(json.dumps({"update": n, "seconds": n}) + "\n" for n in (1, 2, 3, 4))
    (run.path / "metrics.jsonl").write_text(lines + '{"update": 5, "sec')
    assert [line["update"] for line in run.keep_metrics(3)] == [1, 2, 3]
    assert [line["update"] for line in run.metrics()] == [1, 2, 3]


@pytest.mark.parametrize(
    "line",
    [
        b"nonsense", b"\xff\xfe", b"[]", b"[" * 20_000, b'{"seconds": 3}', b'{"update": 2}',
        *(b'{"seconds": 3, "update": ' + value + b"}" for value in (b'"1"', b"1e300", b"9" * 400, b"true")),
        *(b'{"seconds": 3, "update": 2, "loss": ' + value + b"}" for value in (b"{}", b"NaN", b"-Infinity", b"1e40")),
    ],
    ids=range(14),
)  # fmt: skip
def test_damaged_metrics_are_named(tmp_path, line):
    run = Run.create(tmp_path / "run", RECIPES["fast"])
    sound = b'{"seconds": 1, "update": 1}\n'
    (run.path / "metrics.jsonl").write_bytes(sound)
    assert run.metrics() == [{"seconds": 1, "update": 1}]
    (run.path / "metrics.jsonl").write_bytes(sound + line + b"\n")
    with pytest.raises(RunError, match=r"metrics.jsonl: damaged"):
        run.metrics()


@pytest.mark.parametrize(
    ("where", "value", "message"),
    [
        (
            ("train", "roles", "driver", "observes"),
            "maps",
            "train.roles.driver.observes must be one of paper, route.*, not 'maps'",
        ),
        (
            ("train", "roles", "pedestrian", "critic_observes"),
            ["kerb", "x"],
            "train.roles.pedestrian.critic_observes must be one of",
        ),
        (("train", "roles", "driver"), {"gated": True}, "train.roles.driver.gated must be false"),
        (("driver_weights", "speed"), 1.0, "rewards.driver.speed is no reward term"),
        (("pedestrian_weights", "walked"), 1e300, "rewards.pedestrian.walked must be a number up to"),
        (("sim", "pedestrians"), 10**9, "pedestrians must be at most 1000"),
        (("sim", "dt"), 1e-9, "dt must be at least 0.001 s"),
        (("train", "environments"), 10**12, "environments must be at most 1,048,576"),
        (("train", "roles", "driver", "actor_hidden"), [10**9], "actor_hidden must be at most 16 numbers, each in"),
        (("maps",), ["../../secret"], "no such map"),
    ],
)
def test_what_no_training_can_be_made_of_is_named(tmp_path, capsys, where, value, message):
    """By the command line, which has only this folder to go by."""
    folder = _edited(tmp_path, where, value)
    assert main(["train", "--resume", str(folder)]) == 2
    assert re.search(message, capsys.readouterr().err)
