"""Every command runs in an empty folder; entries of a leaderboard."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import jax
import pytest

from cli.entries import DRIVER, python_entry
from jaxwalk.cli import main
from jaxwalk.experiments import submissions
from jaxwalk.experiments.again import read_document


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """An empty working folder; the tests' own cache of compiled code."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(jax.config.jax_compilation_cache_dir or tmp_path / "cache"))
    monkeypatch.setenv("COLUMNS", "200")
    return tmp_path


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """A folder with an entry under ``zoo/bold``, of four scenarios."""
    folder = tmp_path_factory.mktemp("made")
    entry = folder / "zoo" / "bold"
    assert main(f"evaluate --driver route-follower --episodes 4 --out {entry}".split()) == 0
    (entry / "README.md").write_text("It looks at nobody.")
    for name in ("suite.md", "episodes.csv"):
        (entry / name).unlink()
    return folder


@pytest.fixture
def zoo(made, tmp_path, monkeypatch):
    """A copy of it; four scenarios are enough here."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(submissions, "FEWEST", 4)
    return tmp_path / "zoo"


@pytest.fixture
def of_python(zoo, monkeypatch):
    """Entries of a Python driver with a module, called slow and fast, which aren't played; returns what was loaded."""
    loaded = []

    def evaluated(work, tell):
        (driver,) = work.drivers.values()
        loaded.append(driver._driver.pedal)
        results = read_document(Path("results.json"))
        return replace(results, scenarios=replace(results.scenarios, seed=work.scenarios.seed))

    monkeypatch.setattr(submissions, "evaluate_all", evaluated)
    for name, pedal in (("slow", 0.1), ("fast", 1.0)):
        shutil.copytree(zoo / "bold", zoo / name)
        python_entry(zoo / name, {"driver.py": DRIVER, "network.py": f"PEDAL = {pedal}"})
    return loaded
