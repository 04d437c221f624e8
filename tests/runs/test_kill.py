"""Two kills; `tests/reliability/kill_training.py` has many more."""

import sys

import jax
import pytest

from reliability.kill_training import kill_often


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="processes are forked")
def test_a_killed_training_ends_as_if_nothing_had_happened(tmp_path, monkeypatch):
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(jax.config.jax_compilation_cache_dir or tmp_path / "cache"))
    said = []
    assert kill_often(tmp_path, 2, seed=0, say=said.append) == []
    assert said[-1].startswith("2 kills (by what went on: ")
