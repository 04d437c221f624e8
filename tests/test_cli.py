"""The command line: help at once, documents that repeat, and one message for whatever can't be used."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import signal
import subprocess
import sys
import time

import jax
import pytest

from jaxwalk.cli import main
from jaxwalk.cli.options import Bench, Evaluate, Export, HiddenIntent, Observations, Play, Reproduce, Train
from jaxwalk.experiments.recipes import RECIPES, with_training
from jaxwalk.experiments.runs import Run
from jaxwalk.interfaces import Box
from jaxwalk.learning.actor import make_actor
from jaxwalk.learning.config import RoleConfig
from jaxwalk.policies import save_policy

SMALL = ("--environments", "8", "--steps", "8", "--minibatches", "2")


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """An empty working folder; the tests' own cache of compiled code."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(jax.config.jax_compilation_cache_dir or tmp_path / "cache"))
    monkeypatch.setenv("COLUMNS", "200")
    return tmp_path


def _policy(path, size=5, role="driver"):
    actor = make_actor(jax.random.key(0), size, Box(2), RoleConfig(actor_hidden=(4,)))
    save_policy(path, {role: actor}, {})


def _foreign_run(path):
    path.mkdir()
    (path / "notes.txt").write_text("mine")


def _damaged_run(path):
    run = Run.create(path, RECIPES["fast"])
    document = json.loads((run.path / "config.json").read_text())
    document["train"]["clip"] = -1
    (run.path / "config.json").write_text(json.dumps(document))


def _half_map(path):
    path.write_text("size = [60, 20]\n")


FILES = {
    "policy": lambda p: _policy(p / "small.safetensors"),
    "nonsense": lambda p: [
        (p / f"nonsense.{x}").write_bytes(b"nonsense") for x in ("safetensors", "onnx", "zip", "pt")
    ],
    "idle": lambda p: (p / "idle.py").write_text("class Idle: pass\n"),
    "foreign": lambda p: _foreign_run(p / "foreign"),
    "damaged": lambda p: _damaged_run(p / "damaged"),
    "untrained": lambda p: Run.create(p / "untrained", RECIPES["fast"]),
    "map": lambda p: _half_map(p / "half.toml"),
    "file": lambda p: (p / "file").write_text(""),
    "reproduced": lambda p: [(p / "reproduced").mkdir(), (p / "reproduced" / "plan.json").write_text("{}")],
}

BAD = {
    "unknown option": ("train --run r --epoch 3", "Unrecognized options"),
    "unknown command": ("trian", "trian"),
    "no number": ("train --run r --updates many", "many"),
    "unknown recipe": ("train --run r --recipe quick", "quick"),
    "no folder": ("train", "--run DIR is missing"),
    "impossible value": ("train --run r --learning-rate 0", "learning_rate must be above 0, not 0.0"),
    "does not divide": ("train --run r --minibatches 7", "minibatches must divide steps (64), not 7"),
    "no updates": ("train --run r --updates 0", "updates must be at least 1, not 0"),
    "no minutes": ("train --run r --minutes 0", "--minutes must be above 0"),
    "two lengths": ("train --run r --minutes 1 --updates 3", "give one of them"),
    "negative seed": ("train --run r --seed -1", "seed must lie in [0, 2^32), not -1"),
    "negative multiplier": ("train --run r --jaywalk-multiplier -1", "jaywalk_multiplier must be 0 or more"),
    "unknown map": ("train --run r --map nowhere", "nowhere"),
    "wrong map": ("train --run r --map half.toml", "half.toml"),
    "foreign folder": ("train --run foreign", "foreign: the folder is not empty; name another folder"),
    "run that is there": ("train --run untrained", "jaxwalk train --resume untrained"),
    "below a file": ("train --run file/run", "is a file, so nothing can be put into it"),
    "run is a file": ("train --run file", "file: is a file, not a folder"),
    "nothing to resume": ("train --resume nowhere", "nowhere: no such run folder"),
    "no run to resume": ("train --resume foreign", "foreign: is no run folder, it has no config.json"),
    "damaged run": ("train --resume damaged", "config.json: train: Value error, clip must be above 0, not -1"),
    "resume otherwise": ("train --resume untrained --clip 0.1", "--clip: a resumed training keeps its configuration"),
    "both": ("train --resume untrained --run r", "give one of them"),
    "no driver": ("evaluate", "--driver is missing"),
    "unknown driver": ("evaluate --driver rule-bsed", "rule-bsed: no driver of that name (random, constant-speed"),
    "unknown people": ("evaluate --driver random --pedestrians never-go", "never-go: no pedestrian of that name"),
    "no episodes": ("evaluate --driver random --episodes 0", "--episodes must be at least 1, not 0"),
    "evaluation seed": ("evaluate --driver random --seed -3", "--seed must lie in [0, 2^31), not -3"),
    "evaluation multiplier": (
        "evaluate --driver random --jaywalk-multiplier -1",
        "jaywalk_multiplier must be 0 or more",
    ),
    "evaluation map": ("evaluate --driver random --map nowhere", "nowhere"),
    "other sizes": ("evaluate --driver small.safetensors", "reads 5 numbers ('paper'), but the environment gives 34"),
    "other role": ("evaluate --driver random --pedestrians small.safetensors", "holds no pedestrian policy"),
    "nonsense policy": ("evaluate --driver nonsense.safetensors", "nonsense.safetensors: damaged"),
    "untrained driver": ("evaluate --driver untrained", "untrained: has no policy.safetensors"),
    "damaged driver": ("evaluate --driver damaged", "config.json: train: Value error, clip must be above 0"),
    "unknown module": ("evaluate --driver nowhere:Mine", "nowhere:Mine: importing nowhere raised ModuleNotFoundError"),
    "driver of nothing": ("evaluate --driver idle.py:Idle", "idle.py:Idle: has no method act(observation)"),
    "no limit": ("evaluate --driver idle.py:Idle --driver-seconds 0", "its limit for a step must be above 0 s, not 0"),
    "no ONNX file": ("play --driver nowhere.onnx", "nowhere.onnx: no such file"),
    "nonsense as ONNX": ("evaluate --driver nonsense.onnx", "nonsense.onnx: damaged or no ONNX file"),
    "nonsense as an agent": ("evaluate --driver nonsense.zip", "damaged or no Stable-Baselines3 agent"),
    "pickled": ("evaluate --driver nonsense.pt", "can run any code while it is loaded"),
    "export a rule": ("export route-follower --out r.onnx", "route-follower: is a rule, not a trained policy"),
    "export nobody": ("export nobody --out r.onnx", "nobody: no driver of that name"),
    "export to nowhere": ("export co-trained", "--out FILE.onnx is missing"),
    "export to another kind": ("export co-trained --out r.txt", "--out r.txt: name a file that ends in .onnx"),
    "one to compare": ("evaluate --compare random", "--compare needs two different drivers, not random"),
    "three to compare": ("evaluate --compare random rule-based random", "two different drivers, not random rule-based"),
    "the same twice": ("evaluate --compare random random", "--compare needs two different drivers, not random"),
    "fewer than no replays": ("evaluate --driver random --counterfactuals -1", "--counterfactuals must be 0 or more"),
    "encounters nowhere": ("evaluate --driver random --encounters", "--encounters needs --out DIR"),
    "out below a file": ("evaluate --driver random --out file/out", "is a file, so nothing can be put into it"),
    "play nobody": ("play", "--driver is missing"),
    "play before the first": ("play --driver random --scenario -1", "--scenario must lie in [0, 2^30), not -1"),
    "play to nothing": ("play --driver random --out episode.doc", "must end in one of .html, .png"),
    "reproduce for no time": ("reproduce --out r --minutes 0", "minutes must be above 0"),
    "reproduce nothing": ("reproduce --out r --episodes 0", "episodes must be at least 1, not 0"),
    "reproduce untrained": ("reproduce --out r --seeds 0", "seeds must be at least 1, not 0"),
    "reproduce beyond the last seed": ("reproduce --out r --seed 2147483647 --seeds 2", "seed + seeds must be at most"),
    "reproduce elsewhere": ("reproduce --out foreign", "no `jaxwalk reproduce` made it"),
    "intent nothing": ("hidden-intent --out r --episodes 0", "episodes must be at least 1, not 0"),
    "intent untrained": ("hidden-intent --out r --updates 0", "updates must lie in [1, 2^31), not 0"),
    "intent without seeds": ("hidden-intent --out r --seeds 0", "seeds must be at least 1, not 0"),
    "intent seed": ("hidden-intent --out r --seed -1", "seed must lie in [0, 2^31), not -1"),
    "intent half a seed": ("hidden-intent --out r --seed 0.5", "0.5"),
    "intent elsewhere": ("hidden-intent --out foreign", "no `jaxwalk hidden-intent` made it"),
    "intent below a file": ("hidden-intent --out file/out", "is a file, so nothing can be put into it"),
    "bench nothing": ("bench --environments 64 0", "environments must be at least 1, not 0"),
    "bench nobody": ("bench --pedestrians 0", "pedestrians must be at least 1, not 0"),
    "bench backwards": ("bench --seconds -1", "seconds must be 0 or more, not -1.0"),
    "bench half a row": ("bench --chunk-rows 0", "chunk_rows must be at least 1, not 0"),
    "bench an unknown part": ("bench --only all", "all"),
    "bench seed": ("bench --seed -1", "seed must lie in [0, 2^31), not -1"),
    "bench below a file": ("bench --out file/bench", "is a file, so nothing can be put into it"),
    "play two in a picture": ("play --driver random rule-based --out a.png", "several only on a page (--html)"),
    "play to two places": ("play --driver random --html --out a.html", "give one of the two"),
    "play a moment of a film": ("play --driver random --time 2 --out a.gif", "--time is the moment of a picture"),
    "play never": ("play --driver random --time nan --out a.png", "--time must be 0 or more, not nan"),
    "play after the end": ("play --driver rule-based --time 99 --out a.png", "at 99 s the episode is over: it takes"),
    "report on nothing": ("report foreign", "foreign: is no run folder, it has no config.json"),
    "report on nobody": ("report nobody", "nobody: no driver of that name"),
    "report otherwise": ("report reproduced --episodes 5", "--episodes and all other options are those of"),
    "report no episodes": ("report random --episodes 0", "--episodes must be at least 1, not 0"),
    "report too many incidents": ("report random --incidents 201", "--incidents must lie in [0, 200], not 201"),
    "report among too many": ("report random --pedestrians a b c d", "--pedestrians takes 1 to 3 populations, not 4"),
    "report below a file": ("report random --out file/report", "is a file, so nothing can be put into it"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_one_message_and_writes_nothing(name, place, capsys):
    command, message = BAD[name]
    for make in FILES.values():
        make(place)
    before = _contents(place)
    assert main(command.split()) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in " ".join(err.split())
    assert "Traceback" not in err
    assert err.count("jaxwalk: ") <= 1
    assert _contents(place) == before


def _contents(folder):
    return {path: path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write everywhere")
def test_no_permission(place, capsys):
    (place / "locked").mkdir(mode=0o500)
    assert main(["train", "--run", "locked/run"]) == 2
    assert "no permission to write" in capsys.readouterr().err


def test_no_permission_is_said(place, capsys, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert main(["train", "--run", "locked/run"]) == 2
    assert "no permission to write" in capsys.readouterr().err


def test_version(capsys):
    from importlib.metadata import version

    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"jaxwalk {version('jaxwalk')}\n"


@pytest.mark.parametrize("command", [Train, Evaluate, Play, Reproduce, HiddenIntent, Observations, Bench])
def test_help_says_every_default(command, capsys):
    name = "hidden-intent" if command is HiddenIntent else command.__name__.lower()
    assert main([name, "--help"]) == 0
    text = capsys.readouterr().out
    assert text.count("(default:") == len(dataclasses.fields(command))
    assert "None" not in text


def test_help_of_export_says_what_to_name(capsys):
    assert main(["export", "--help"]) == 0
    text = capsys.readouterr().out
    assert text.count("(default:") == len(dataclasses.fields(Export)) - 1  # all but the policy
    assert "POLICY" in text


def test_help_loads_no_jax():
    code = "import sys; from jaxwalk.cli import main; main(['train', '--help']); assert 'jax' not in sys.modules"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=False).returncode == 0


def test_an_evaluation_repeats_itself(place, capsys):
    command = "evaluate --driver rule-based --pedestrians always-go --episodes 3 --seed 7 --json"
    assert main([*command.split(), "--out", "kept"]) == 0
    first = capsys.readouterr().out
    assert main(command.split()) == 0
    assert capsys.readouterr().out == first
    assert (place / "kept" / "results.json").read_text() == first
    document = json.loads(first)
    assert document["schema"] == 3
    assert document["scenarios"].keys() == {"seed", "count", "hash"}
    assert document["cells"][0]["goal_rate"].keys() == {"value", "low", "high"}
    rows = (place / "kept" / "episodes.csv").read_text().splitlines()
    assert len(rows) == 4
    assert rows[0].startswith("scenario,")


def test_the_table_shows_intervals_and_the_hash(capsys):
    command = "evaluate --driver rule-based --pedestrians always-go --episodes 3 --seed 7 --jaywalk-multiplier 0 1"
    assert main(command.split()) == 0
    out = capsys.readouterr().out
    assert out.count("rule-based") == 2
    assert "3 scenarios of seed 7, hash " in out
    assert "[" in out


OWN = """
import numpy as np

class Mine:
    batches = 0
    def reset(self, episodes):
        self.batches, self.step = self.batches + 1, 0
    def act(self, observation):
        self.step += 1
        action = np.zeros((len(observation), 2))
        action[:, 0] = 1
        return action[:, self.batches > 1 and self.step == 3 :]
"""


def test_a_driver_of_ones_own_is_evaluated_and_its_cost_shown(place, capsys):
    (place / "mine.py").write_text(OWN)
    assert main(["evaluate", "--driver", "mine:Mine", "--episodes", "3", "--seed", "7", "--out", "kept"]) == 0
    cell = json.loads((place / "kept" / "results.json").read_text())["cells"][0]
    assert (cell["driver"], cell["driver_observes"]) == ("mine:Mine", "paper")
    assert f"mine:Mine: {cell['driver_ms_per_step']:.3g} ms for a step of 512 episodes" in capsys.readouterr().out


def test_what_was_evaluated_before_a_driver_failed_is_kept(place, capsys):
    (place / "mine.py").write_text(OWN)
    assert main(["evaluate", "--driver", "mine.py:Mine", "--episodes", "600", "--seed", "7", "--out", "kept"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    message = " ".join(err.split())
    assert "jaxwalk: mine.py:Mine: act returned shape (512, 1); return an array of shape (512, 2)" in message
    assert "(scenario 512 and 511 others, played together, step 2); the 512 episodes evaluated before are" in message
    assert [path.name for path in (place / "kept").iterdir()] == ["episodes-partial.csv"]
    assert len((place / "kept" / "episodes-partial.csv").read_text().splitlines()) == 1 + 512


def test_observations_are_listed(capsys):
    assert main(["observations", "--role", "pedestrian"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "paper: 20 features"
    assert lines[1].split() == ["0", "to", "1", "position"]
    assert lines[9].split() == ["18", "to", "19", "nearest_other"]


def test_two_drivers_are_compared_in_words_and_everything_is_kept(place, capsys):
    command = "evaluate --compare rule-based random --episodes 3 --seed 7 --out kept --encounters"
    assert main(command.split()) == 0
    out = capsys.readouterr().out
    assert out.count("3 scenarios") == 3  # two tests, and which scenarios they were
    assert {file.name for file in (place / "kept").iterdir()} == {
        "encounters.parquet", "episodes.csv", "results.json", "suite.md",
    }  # fmt: skip
    suite = (place / "kept" / "suite.md").read_text()
    assert "| rule-based among always-go |" in suite and "Made at commit" in suite
    compared = json.loads((place / "kept" / "results.json").read_text())["compared"]
    for one in compared:
        assert one["in_words"] in suite and one["in_words"] in out
    assert [(one["a"], one["b"], one["ending"]) for one in compared] == [
        ("rule-based", "random", "collision"), ("rule-based", "random", "goal"),
    ]  # fmt: skip


def test_the_table_marks_who_sees_what_is_hidden():
    from jaxwalk.cli.evaluate import table

    number = {"value": 0.5, "low": None, "high": None}
    names = ("goal_rate", "collision_rate", "timeout_rate", "mean_time_to_goal")
    cell = {"pedestrians": "always-go", "jaywalk_multiplier": 0.25, **dict.fromkeys(names, number)}
    sets = ("route", "route-belief", "route-told", "privileged")
    shown = table({"cells": [{**cell, "driver": "mine", "driver_observes": name} for name in sets]})
    marked = ["mine", "mine", "mine (route-told)", "mine (privileged)"]
    assert list(shown.columns[0].cells) == marked


def test_play_draws(place, capsys):
    assert main(["play", "--driver", "rule-based", "--scenario", "2", "--out", "there/episode.png"]) == 0
    assert (place / "there" / "episode.png").read_bytes().startswith(b"\x89PNG")
    assert "scenario 2 of seed 0" in capsys.readouterr().out


def test_play_makes_a_page_of_several_drivers_and_scenarios(place, capsys):
    command = "play --driver route-follower rule-based --scenario 2 5 2 --out there/replay.html"
    assert main(command.split()) == 0
    said = "4 episodes of seed 0, route-follower, rule-based among always-go"
    assert said in capsys.readouterr().out
    text = (place / "there" / "replay.html").read_text(encoding="utf-8")
    document = json.loads(text.split('id="data">')[1].split("</script>")[0])
    shown = [(e["driver"], e["scenario"]) for e in document["episodes"]]
    assert shown == [("route-follower", 2), ("route-follower", 5), ("rule-based", 2), ("rule-based", 5)]
    assert not re.search(r'(src|href)="(https?:)?//', text)


def test_a_report_on_a_driver(place, capsys):
    command = "report route-follower --pedestrians always-go --episodes 40 --incidents 3 --out mine"
    assert main(command.split()) == 0
    assert capsys.readouterr().out == "Open mine/report.html\n"
    folder = place / "mine"
    assert {p.name for p in folder.iterdir()} == {"report.html", "results.json", "episodes.csv", "figures", "tables"}
    results = json.loads((folder / "results.json").read_text())
    hits = results["cells"][0]["outcomes"]["all"]["per_km"]["count"]
    assert hits > 3
    text = (folder / "report.html").read_text(encoding="utf-8")
    document = json.loads(text.split('id="data">')[1].split("</script>")[0])
    kinds = [(one["kind"], one["avoidable"] is not None) for one in document["incidents"]]
    assert kinds == [("collision", True)] * 3 + [("near miss", False)] * 3
    for one in document["incidents"][:3]:
        episode = document["episodes"][one["episode"]]
        assert episode["ending"] == "collision"
        assert one["t"] == pytest.approx(episode["steps"] * 0.1)


def test_bench_prints_one_document_and_keeps_it(place, capfd):
    command = "bench --only env --environments 8 --seconds 0.05 --json --out bench"
    assert main(command.split()) == 0
    out, err = capfd.readouterr()
    document = json.loads(out)
    assert (place / "bench" / "bench.json").read_text() == out
    assert document["figures"]["env_steps_per_s"]["value"] == document["rows"]["env"][0]["env_steps_per_s"] > 0
    assert document["hardware"].keys() >= {"processor", "cores", "memory_bytes", "accelerator"}
    assert document["provenance"]["versions"].keys() >= {"jax", "jaxlib", "python"}
    assert "sets JAX_NUM_CPU_DEVICES=" in err


def test_bench_prints_a_table(capfd, monkeypatch):
    from jaxwalk.experiments.benchmark import document

    monkeypatch.setattr(document, "starts", lambda: {"import_s": 0.25, "help_s": 0.5})
    assert main(["bench", "--only", "compile"]) == 0
    out = capfd.readouterr().out
    assert "import_s" in out
    assert "0.25 s" in out


def test_ctrl_c_leaves_a_run_that_resumes(place):
    command = [sys.executable, "-m", "jaxwalk", "train", "--run", "run", "--updates", "100000", *SMALL]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=place) as process:
        _wait_for(lambda: len(_lines(place)) >= 2, process)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "Traceback" not in err
    assert "jaxwalk train --resume run" in " ".join(err.split())
    run = Run.open(place / "run")
    made = run.metrics()[-1]["update"]
    assert [line["update"] for line in run.metrics()] == list(range(1, made + 1))
    run.describe(with_training(run.experiment, updates=100000))
    from jaxwalk.learning import checkpoint

    assert checkpoint.latest(run.checkpoints) == made
    assert run.policy.is_file()


def _lines(place):
    path = place / "run" / "metrics.jsonl"
    return path.read_text().splitlines() if path.is_file() else []


def _wait_for(happened, process, seconds=300):
    until = time.monotonic() + seconds
    while not happened():
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < until
        time.sleep(0.05)
