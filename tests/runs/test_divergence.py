"""A training with an absurd learning rate, as a user would meet it."""

from __future__ import annotations

import re

import numpy as np
from safetensors.numpy import load_file

from jaxwalk.cli import main
from jaxwalk.learning import checkpoint
from jaxwalk.policies import read_metadata
from jaxwalk.recipes import with_training
from jaxwalk.runs.folder import Run


def test_a_diverging_training_says_so_and_keeps_its_last_good_state(tiny, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Run.create("run", with_training(tiny, updates=500, learning_rate=100.0))
    assert main(["train", "--resume", "run"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    found = re.search(r"jaxwalk: run: update (\d+) gave numbers that are not finite; .* of update (\d+) are kept", said)
    assert found, said
    failed, good = map(int, found.groups())
    assert failed == good + 1

    run = Run.open("run")
    assert [line["update"] for line in run.metrics()] == list(range(1, failed))
    assert checkpoint.latest(run.checkpoints) == read_metadata(run.policy)["updates"] == good
    assert all(np.isfinite(x).all() for x in load_file(run.policy).values())

    assert main(["train", "--resume", "run"]) == 2  # goes on from there, and meets the same
    assert f"update {failed} gave numbers that are not finite" in " ".join(capsys.readouterr().err.split())
