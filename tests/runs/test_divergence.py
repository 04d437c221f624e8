"""Trainings that can't go on, as a user would meet them: an absurd learning rate, a broken fixed policy."""

from __future__ import annotations

import re

import jax.numpy as jnp
import numpy as np
import pytest
from safetensors.numpy import load_file

from jaxwalk.cli import main
from jaxwalk.learning import checkpoint
from jaxwalk.policies import ConstantSpeed, read_metadata
from jaxwalk.recipes import with_training
from jaxwalk.runs.folder import Run
from jaxwalk.runs.street import fixed_policies


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


class Broken(ConstantSpeed):
    """A driver who gives no numbers."""

    def act(self, key, memory, observation):
        action, memory = super().act(key, memory, observation)
        return jnp.full_like(action, jnp.nan), memory


@pytest.mark.long
def test_a_broken_fixed_policy_ends_a_training(tiny, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "jaxwalk.runs.training.fixed_policies",
        lambda experiment: fixed_policies(experiment) | {"driver": Broken()},
    )
    Run.create("run", tiny)
    assert main(["train", "--resume", "run"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "jaxwalk: run: in update 1 the fixed driver policy gave an action that isn't in its space" in said
    assert "update 0 are kept. Correct it, and train anew" in said
    assert not list(Run.open("run").metrics())


def test_a_sound_training_records_nothing_about_it(whole):
    assert not [name for name in next(iter(whole.metrics())) if name.startswith("fixed/") or name == "finite"]
