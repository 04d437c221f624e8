"""A few kills; `kill_training.py` and `kill_processes.py` of `tests/reliability` have many more."""

import sys

import jax
import pytest

from reliability.kill_processes import strike_often
from reliability.kill_training import kill_often


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="processes are forked")
def test_a_killed_training_ends_as_if_nothing_had_happened(tmp_path, monkeypatch):
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(jax.config.jax_compilation_cache_dir or tmp_path / "cache"))
    said = []
    assert kill_often(tmp_path, 2, seed=0, say=said.append) == []
    assert said[-1].startswith("2 kills (by what went on: ")


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="processes are found in /proc")
def test_a_training_by_two_processes_ends_together_and_goes_on(tmp_path, monkeypatch):
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(jax.config.jax_compilation_cache_dir or tmp_path / "cache"))
    said = []
    assert strike_often(tmp_path, 1, 1, seed=0, say=said.append) == []
    assert said[-1].startswith("2 strikes ")
