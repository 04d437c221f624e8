"""Every command runs in an empty folder."""

from __future__ import annotations

import jax
import pytest


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """An empty working folder; the tests' own cache of compiled code."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(jax.config.jax_compilation_cache_dir or tmp_path / "cache"))
    monkeypatch.setenv("COLUMNS", "200")
    return tmp_path
