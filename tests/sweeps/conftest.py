"""Sweeps whose trainings are pretended, so that nothing is compiled."""

from __future__ import annotations

import importlib.util
import json
import math

import jax
import pytest

from jaxwalk.recipes import RECIPES
from jaxwalk.runs.training import TrainingEnd

STUDY = """
sampler = "random"
trials = 4

[objective]
metric = "reward/driver"
direction = "minimise"

[training.train]
environments = 8
steps = 8
minibatches = 2
updates = 10

[vary.driver_weights]
time = { low = -0.25, high = -0.02 }
"""


def pytest_collection_modifyitems(items):
    """Without Optuna none of these tests can run."""
    if importlib.util.find_spec("optuna") is None:
        for item in items:
            if "/sweeps/" in item.nodeid:
                item.add_marker(pytest.mark.skip(reason="needs Optuna"))


@pytest.fixture
def study(tmp_path):
    """Write a study with some lines replaced; return its path."""

    def write(**changes):
        text = STUDY
        for old, new in changes.items():
            assert old in text, old
            text = text.replace(old, new)
        path = tmp_path / "study.toml"
        path.write_text(text)
        return path

    return write


class Pretended:
    """Trainings that only write metrics: the reward is (time + 0.1)^2 + seed, whatever the update."""

    def __init__(self) -> None:
        self.trained: list[tuple[str, str, int]] = []
        """Folder of the trial, folder of the seed, and the update after which it began or was resumed."""
        self.stop_after: int | None = None
        """Raise KeyboardInterrupt after so many updates in all."""

    def train_in(self, run, *, resume, display, on_update=None):
        lines = run.metrics()
        self.trained.append((run.path.parent.name, run.path.name, len(lines)))
        value = (run.experiment.driver_weights["time"] + 0.1) ** 2 + run.experiment.seed
        stopped = False
        for update in range(len(lines) + 1, run.experiment.train.updates + 1):
            if self.stop_after is not None:
                self.stop_after -= 1
                if self.stop_after < 0:
                    raise KeyboardInterrupt
            lines.append({"update": update, "seconds": 1.0, "episodes": 3.0, "reward/driver": value})
            (run.path / "metrics.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
            if on_update is not None and on_update(lines[-1]):
                stopped = True
                break
        return TrainingEnd(len(lines), len(lines), 1.0, False, stopped)

    @staticmethod
    def is_finished(run, updates):
        return len(run.metrics()) == updates


@pytest.fixture
def pretended(monkeypatch):
    """Trainings are pretended."""
    from jaxwalk.sweeps import trial_work

    found = Pretended()
    monkeypatch.setattr(trial_work, "train_in", found.train_in)
    monkeypatch.setattr(trial_work, "is_finished", found.is_finished)
    monkeypatch.setattr("jaxwalk.sweeps.sweeping.make_street", lambda experiment: None)
    assert math.isclose(RECIPES["fast"].driver_weights["time"], -0.06)
    return found


@pytest.fixture
def place(tmp_path, monkeypatch):
    """An empty working folder; processes share the tests' cache of compiled code."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(jax.config.jax_compilation_cache_dir or tmp_path / "cache"))
    return tmp_path
