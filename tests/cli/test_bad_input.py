"""Whatever can't be used ends in one message, with nothing written."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import jax
import pytest

from jaxwalk.cli import main
from jaxwalk.interfaces import Box, Discrete
from jaxwalk.learning.actor import make_actor
from jaxwalk.learning.config import RoleConfig
from jaxwalk.policies import save_policy
from jaxwalk.recipes import RECIPES
from jaxwalk.runs.entry import Trained
from jaxwalk.runs.folder import Run
from jaxwalk.sim.observation import size
from jaxwalk.sim.sim_config import SimConfig


def _policy(path, role="driver"):
    actor = make_actor(jax.random.key(0), 5, Box(2), RoleConfig(actor_hidden=(4,)))
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


def _trained_run(path, **changes):
    """A run folder whose policy is never read."""
    Run.create(path, replace(RECIPES["fast"], **changes)).policy.write_bytes(b"")


FILES = {
    "policy": lambda p: _policy(p / "small.safetensors"),
    "nonsense": lambda p: [
        (p / f"nonsense.{x}").write_bytes(b"nonsense") for x in ("safetensors", "onnx", "zip", "pt")
    ],
    "idle": lambda p: (p / "idle.py").write_text("class Idle: pass\n"),
    "leaves": lambda p: (p / "leaves.py").write_text("import sys\nsys.exit()\n"),
    "foreign": lambda p: _foreign_run(p / "foreign"),
    "damaged": lambda p: _damaged_run(p / "damaged"),
    "untrained": lambda p: Run.create(p / "untrained", RECIPES["fast"]),
    "trained": lambda p: _trained_run(p / "trained"),
    "elsewhere": lambda p: _trained_run(p / "elsewhere", maps=("paper", "paper")),
    "slow": lambda p: _trained_run(p / "slow", sim=SimConfig(max_speed=5.0)),
    "map": lambda p: _half_map(p / "half.toml"),
    "file": lambda p: (p / "file").write_text(""),
    "folders": lambda p: [(p / f"folder.{x}").mkdir() for x in ("png", "onnx", "safetensors")],
    "reproduced": lambda p: [(p / "reproduced").mkdir(), (p / "reproduced" / "plan.json").write_text("{}")],
}

BAD = {
    "unknown option": ("train --run r --epoch 3", "Unrecognized options"),
    "unknown command": ("trian", "trian"),
    "no number": ("train --run r --updates many", "many"),
    "unknown recipe": ("train --run r --recipe quick", "quick"),
    "no folder": ("train", "--run DIR is missing"),
    "impossible value": ("train --run r --learning-rate 0", "learning_rate must be a finite number above 0, not 0.0"),
    "does not divide": ("train --run r --minibatches 7", "minibatches must divide steps (64), not 7"),
    "no updates": ("train --run r --updates 0", "updates must be at least 1, not 0"),
    "no minutes": ("train --run r --minutes 0", "--minutes must be above 0"),
    "two lengths": ("train --run r --minutes 1 --updates 3", "give one of them"),
    "negative seed": ("train --run r --seed -1", "seed must lie in [0, 2^32), not -1"),
    "negative multiplier": (
        "train --run r --jaywalk-multiplier -1",
        "jaywalk_multiplier must be a finite number of 0 or more",
    ),
    "unknown map": ("train --run r --map nowhere", "nowhere"),
    "wrong map": ("train --run r --map half.toml", "half.toml"),
    "foreign folder": ("train --run foreign", "foreign: the folder is not empty; name another folder"),
    "run that is there": ("train --run untrained", "jaxwalk train --resume untrained"),
    "below a file": ("train --run file/run", "is a file, so nothing can be put into it"),
    "run is a file": ("train --run file", "file: is a file, not a folder"),
    "nothing to resume": ("train --resume nowhere", "nowhere: no such run folder"),
    "no run to resume": ("train --resume foreign", "foreign: is no run folder, it has no config.json"),
    "damaged run": (
        "train --resume damaged",
        "config.json: train: Value error, clip must be a finite number above 0, not -1",
    ),
    "resume otherwise": ("train --resume untrained --clip 0.1", "--clip: a resumed training keeps its configuration"),
    "both": ("train --resume untrained --run r", "give one of them"),
    "no driver": ("evaluate", "--driver is missing"),
    "unknown driver": ("evaluate --driver rule-bsed", "rule-bsed: no driver of that name (random, constant-speed"),
    "unknown people": ("evaluate --driver random --pedestrians never-go", "never-go: no pedestrian of that name"),
    "no episodes": ("evaluate --driver random --episodes 0", "--episodes must lie in [1, 10,000,000], not 0"),
    "evaluation seed": ("evaluate --driver random --seed -3", "--seed must lie in [0, 2^31), not -3"),
    "evaluation multiplier": (
        "evaluate --driver random --jaywalk-multiplier -1",
        "jaywalk_multiplier must be a finite number of 0 or more",
    ),
    "evaluation among nobody": ("evaluate --driver random --pedestrians", "--pedestrians is missing"),
    "no multiplier": ("evaluate --driver random --jaywalk-multiplier", "--jaywalk-multiplier needs a number"),
    "different maps": ("evaluate --driver trained elsewhere", "were trained on different maps"),
    "different rules": ("evaluate --driver trained slow --map paper", "were trained in worlds of different rules"),
    "evaluation map": ("evaluate --driver random --map nowhere", "nowhere"),
    "other sizes": ("evaluate --driver small.safetensors", "reads 5 numbers ('paper'), but the environment gives 34"),
    "other role": ("evaluate --driver random --pedestrians small.safetensors", "holds no pedestrian policy"),
    "nonsense policy": ("evaluate --driver nonsense.safetensors", "nonsense.safetensors: damaged"),
    "untrained driver": ("evaluate --driver untrained", "untrained: has no policy.safetensors"),
    "damaged driver": (
        "evaluate --driver damaged",
        "config.json: train: Value error, clip must be a finite number above 0",
    ),
    "unknown module": ("evaluate --driver nowhere:Mine", "nowhere:Mine: importing nowhere raised ModuleNotFoundError"),
    "driver of nothing": ("evaluate --driver idle.py:Idle", "idle.py:Idle: has no method act(observation)"),
    "driver that exits": ("evaluate --driver leaves.py:Mine", "leaves.py:Mine: exits while it is loaded (code None)"),
    "no limit": (
        "evaluate --driver idle.py:Idle --driver-seconds 0",
        "--driver-seconds must be above 0 and at most 86,400, not 0",
    ),
    "no ONNX file": ("play --driver nowhere.onnx", "nowhere.onnx: no such file"),
    "nonsense as ONNX": ("evaluate --driver nonsense.onnx", "nonsense.onnx: damaged or no ONNX file"),
    "nonsense as an agent": ("evaluate --driver nonsense.zip", "damaged or no Stable-Baselines3 agent"),
    "pickled": ("evaluate --driver nonsense.pt", "can run any code while it is loaded"),
    "export a shield": (
        "export co-trained+rss --out r.onnx",
        "co-trained+rss: a shield is no network; export co-trained",
    ),
    "a shield that isn't": ("evaluate --driver random+shield", "random+shield: no driver of that name"),
    "another shield": ("evaluate --driver random --shield steel", "steel"),
    "export a rule": ("export route-follower --out r.onnx", "route-follower: is a rule, not a trained policy"),
    "export nobody": ("export nobody --out r.onnx", "nobody: no driver of that name"),
    "export to nowhere": ("export co-trained", "--out FILE.onnx is missing"),
    "export to a folder": ("export co-trained --out folder.onnx", "--out folder.onnx: is a folder; name a file"),
    "export to another kind": ("export co-trained --out r.txt", "--out r.txt: name a file that ends in .onnx"),
    "one to compare": ("evaluate --compare random", "--compare needs two different drivers, not random"),
    "three to compare": ("evaluate --compare random rule-based random", "two different drivers, not random rule-based"),
    "the same twice": ("evaluate --compare random random", "--compare needs two different drivers, not random"),
    "fewer than no replays": (
        "evaluate --driver random --counterfactuals -1",
        "--counterfactuals must lie in [0, 10,000,000], not -1",
    ),
    "encounters nowhere": ("evaluate --driver random --encounters", "--encounters needs --out DIR"),
    "out below a file": ("evaluate --driver random --out file/out", "is a file, so nothing can be put into it"),
    "play nobody": ("play", "--driver is missing"),
    "play before the first": ("play --driver random --scenario -1", "--scenario must lie in [0, 2^30), not -1"),
    "play no scenario": ("play --driver random --scenario", "--scenario needs a number, such as 3"),
    "play seed": ("play --driver random --seed -1", "--seed must lie in [0, 2^31), not -1"),
    "play to a folder": ("play --driver random --out folder.png", "folder.png: is a folder; name a file"),
    "scenario seed": ("scenario --driver random --out r --seed -1", "--seed must lie in [0, 2^31), not -1"),
    "share to a folder": ("share trained --out folder.safetensors", "is a folder; name a file"),
    "share among nobody": ("share trained --out a.safetensors --pedestrians", "--pedestrians is missing"),
    "play to nothing": ("play --driver random --out episode.doc", "must end in one of .html, .png"),
    "reproduce for no time": ("reproduce --out r --minutes 0", "minutes must be above 0"),
    "reproduce nothing": ("reproduce --out r --episodes 0", "episodes must lie in [1, 10,000,000], not 0"),
    "reproduce untrained": ("reproduce --out r --seeds 0", "seeds must lie in [1, 1,000], not 0"),
    "reproduce beyond the last seed": ("reproduce --out r --seed 2147483647 --seeds 2", "seed + seeds must be at most"),
    "reproduce elsewhere": ("reproduce --out foreign", "no `jaxwalk reproduce` made it"),
    "intent nothing": ("hidden-intent --out r --episodes 0", "episodes must lie in [1, 10,000,000], not 0"),
    "intent untrained": ("hidden-intent --out r --updates 0", "updates must lie in [1, 2^31), not 0"),
    "intent without seeds": ("hidden-intent --out r --seeds 0", "seeds must lie in [1, 1,000], not 0"),
    "intent seed": ("hidden-intent --out r --seed -1", "seed must lie in [0, 2^31), not -1"),
    "intent unknown car": (
        "hidden-intent --out r --cars blind x-ray",
        "no car 'x-ray' in recipe fast; there are: blind",
    ),
    "intent without blind": ("hidden-intent --out r --cars told", "the others are compared with blind; name it too"),
    "intent time twice": (
        "hidden-intent --out r --time-weights 1 2 2",
        "time_weights: name each once, and 1 among them",
    ),
    "intent time nearly twice": ("hidden-intent --out r --time-weights 1 4 4.0000001", "time_weights: name each once"),
    "intent time below zero": (
        "hidden-intent --out r --time-weights 1 -2",
        "time_weights must lie in [0, 1000], not -2",
    ),
    "intent too well shown": (
        "hidden-intent --out r --pace-correlation 1.5",
        "pace_correlation must lie in [-1, 1], not 1.5",
    ),
    "intent half a seed": ("hidden-intent --out r --seed 0.5", "0.5"),
    "co-training of one seed": (
        "co-training --out r --seeds 1",
        "seeds must be at least 2: cars meet people of another training seed",
    ),
    "co-training elsewhere": ("co-training --out foreign", "no `jaxwalk co-training` made it"),
    "intent elsewhere": ("hidden-intent --out foreign", "no `jaxwalk hidden-intent` made it"),
    "intent below a file": ("hidden-intent --out file/out", "is a file, so nothing can be put into it"),
    "bench nothing": ("bench --environments 64 0", "environments must lie in [1, 1,048,576], not [0]"),
    "bench nobody": ("bench --pedestrians 0", "pedestrians must lie in [1, 1,000], not [0]"),
    "bench backwards": ("bench --seconds -1", "seconds must lie in [0, 3,600], not -1"),
    "bench half a row": ("bench --chunk-rows 0", "chunk_rows must lie in [1, 2^31), not 0"),
    "bench an unknown part": ("bench --only all", "all"),
    "bench seed": ("bench --seed -1", "seed must lie in [0, 2^31), not -1"),
    "bench a plan of times": ("bench --plan h100 --seconds 1", "has no use for --seconds"),
    "bench an unknown GPU": ("bench --plan abacus", "abacus"),
    "bench below a file": ("bench --out file/bench", "is a file, so nothing can be put into it"),
    "play two in a picture": ("play --driver random rule-based --out a.png", "several only on a page (--html)"),
    "play to two places": ("play --driver random --html --out a.html", "give one of the two"),
    "play a moment of a film": ("play --driver random --time 2 --out a.gif", "--time is the moment of a picture"),
    "play never": (
        "play --driver random --time nan --out a.png",
        "--time must be a finite number of 0 or more, not nan",
    ),
    "play after the end": ("play --driver rule-based --time 99 --out a.png", "at 99 s the episode is over: it takes"),
    "report on nothing": ("report foreign", "foreign: is no run folder, it has no config.json"),
    "report on nobody": ("report nobody", "nobody: no driver of that name"),
    "report otherwise": ("report reproduced --episodes 5", "--episodes and all other options are those of"),
    "report two at once": ("report reproduced trained", "is reported on its own; name it alone"),
    "train too many shards": ("train --run new --shards 64", "64 devices are needed, and JAX has 2 (cpu); ask"),
    "train uneven shards": ("train --run new --shards 5", "shards must divide environments (768), not 5"),
    "report seed": ("report random --seed -1", "--seed must lie in [0, 2^31), not -1"),
    "report no episodes": ("report random --episodes 0", "--episodes must lie in [1, 10,000,000], not 0"),
    "report too many incidents": ("report random --incidents 201", "--incidents must lie in [0, 200], not 201"),
    "report among too many": (
        "report random --pedestrians always-go learned always-go learned",
        "--pedestrians takes 1 to 3 populations, not 4",
    ),
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
    """All but what Python compiles of a driver of one's own."""
    paths = (path for path in folder.rglob("*") if "__pycache__" not in path.parts)
    return {path: path.read_bytes() if path.is_file() else None for path in paths}


@pytest.mark.parametrize("command", ["evaluate --driver wrong.safetensors", "evaluate --driver a --pedestrians wide"])
def test_a_network_of_another_kind(command, place, capsys):
    """The driver of this file chooses; the pedestrian of that one gives three numbers."""
    driver, pedestrian = size("driver", "paper"), size("pedestrian", "paper")
    chooses = make_actor(jax.random.key(0), driver, Discrete(2), RoleConfig(actor_hidden=(4,)))
    save_policy(place / "wrong.safetensors", {"driver": chooses}, {})
    save_policy(
        place / "wide", {"pedestrian": make_actor(jax.random.key(0), pedestrian, Discrete(3), RoleConfig())}, {}
    )
    assert main([x if x != "a" else "random" for x in command.split()]) == 2
    assert "outputs; train anew" in capsys.readouterr().err


def test_out_of_memory_is_said(place, capsys, monkeypatch):
    def train(*_, **__):
        raise RuntimeError("RESOURCE_EXHAUSTED: Out of memory allocating 99999999999 bytes.")

    monkeypatch.setattr("jaxwalk.runs.entry.train_in", train)
    assert main(["train", "--run", "r"]) == 2
    assert "jaxwalk: not enough memory; ask for fewer environments" in capsys.readouterr().err


def test_brackets_in_a_folder_are_no_markup(place, capsys, monkeypatch):
    ended = Trained(1, 64, 1.0, False, folder=Path("a[/b]"))
    monkeypatch.setattr("jaxwalk.cli.train.train", lambda *_, **__: ended)
    assert main(["train", "--run", "a[/b]"]) == 0
    assert "jaxwalk evaluate --driver a[/b]" in capsys.readouterr().err


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write everywhere")
def test_no_permission(place, capsys):
    (place / "locked").mkdir(mode=0o500)
    assert main(["train", "--run", "locked/run"]) == 2
    assert "no permission to write" in capsys.readouterr().err


def test_no_permission_is_said(place, capsys, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert main(["train", "--run", "locked/run"]) == 2
    assert "no permission to write" in capsys.readouterr().err
