"""A policy whose numbers overflow ends every command that plays it: one message, exit code 2, no file."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
import safetensors
from safetensors.numpy import load_file, save_file

from jaxwalk.cli import main
from jaxwalk.experiments import tournament
from jaxwalk.policies import shipped_policy
from jaxwalk.recipes import RECIPES
from jaxwalk.runs import study
from jaxwalk.runs.folder import POLICY, Run
from jaxwalk.runs.training import TrainingEnd

FACTOR = 1e30

COMMANDS = {
    "evaluate": "evaluate --driver broken.safetensors --episodes 8 --out made/all",
    "evaluate people": "evaluate --driver route-follower --pedestrians broken.safetensors --episodes 8 --json",
    "play": "play --driver broken.safetensors --out made/episode.png",
    "page": "play --driver route-follower broken.safetensors --out made/episode.html",
    "tracks": "tracks --driver broken.safetensors --episodes 8 --out made/tracks.parquet",
    "scenario": "scenario --driver broken.safetensors --out made/scenario",
    "export": "export broken.safetensors --out made/broken.onnx",
    "report": "report broken.safetensors --episodes 8 --out made/report",
}


@pytest.fixture
def broken(place):
    """The shipped co-trained policies times 1e30: every number is finite, but no action is."""
    shipped = shipped_policy("driver", "co-trained")
    with safetensors.safe_open(shipped, "numpy") as file:
        header = file.metadata()
    arrays = {name: x * np.float32(FACTOR) for name, x in load_file(shipped).items()}
    assert all(np.isfinite(x).all() for x in arrays.values())
    save_file(arrays, place / "broken.safetensors", header)


LONG = ("export", "report")
"""What plays the most."""


@pytest.mark.parametrize("name", [pytest.param(x, marks=[pytest.mark.long] * (x in LONG)) for x in COMMANDS])
def test_it_is_said_who_and_where(broken, place, name, capsys):
    if name == "tracks":
        pytest.importorskip("pyarrow")
    if name == "export":
        pytest.importorskip("onnxruntime")
    if name == "scenario":
        pytest.importorskip("scenariogeneration")
    assert main(COMMANDS[name].split()) == 2
    said = " ".join(capsys.readouterr().err.split())
    people = "people" in name
    action = r"-1, not an integer in [0, 2)" if people else "[nan nan], not 2 numbers in [-1, 1]"
    assert said.count("jaxwalk: ") == 1
    if name == "export":
        assert "jaxwalk: broken.safetensors: an action isn't 2 numbers in [-1, 1]; " in said
    else:
        assert f"jaxwalk: broken.safetensors: its action is {action} (scenario " in said
    assert "the policy is broken" in said
    assert "Traceback" not in said
    assert not [path for path in (place / "made").rglob("*") if path.is_file() and path.name != ".lock"]


NOTHING_MADE = "its action is [nan nan], not 2 numbers in [-1, 1] (scenario 0, step 0); the policy is broken"


@pytest.mark.long
def test_what_is_shared_is_played_first(broken, place, capsys):
    run = Run.create(place / "run", RECIPES["fast"])
    shutil.copy(place / "broken.safetensors", run.policy)
    assert (
        main(["share", "run", "--pedestrians", "always-go", "--episodes", "8", "--out", "made/mine.safetensors"]) == 2
    )
    assert f"jaxwalk: run: {NOTHING_MADE}" in " ".join(capsys.readouterr().err.split())
    assert not list(place.rglob("mine.*"))


STUDIES = {"reproduce": "single-agent", "hidden-intent": "blind", "co-training": "pure"}
"""Every study, and the training that it plays first."""


@pytest.mark.long
@pytest.mark.parametrize(("command", "first"), STUDIES.items())
def test_a_study_names_which_of_its_trainings_broke(broken, place, command, first, monkeypatch, capsys):
    def train(run, **_):
        shutil.copy(place / "broken.safetensors", run.path / POLICY)
        return TrainingEnd(1, 1, 1.0, False)

    monkeypatch.setattr(study, "train_in", train)
    monkeypatch.setattr(tournament, "COMPARED", [])
    assert main([command, *["--updates", "1", "--episodes", "8", "--seeds", "2", "--out", "made"]]) == 2
    assert f"jaxwalk: {first}: {NOTHING_MADE}" in " ".join(capsys.readouterr().err.split())
    assert sorted(path.name for path in (place / "made").glob("*.*")) == [".lock", "minutes.json", "plan.json"]
