"""Programs are forgotten when they take too many of the memory mappings that a process may have, and not before."""

from __future__ import annotations

import sys
import types

import jax
import pytest

from jaxwalk import relief


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux says how many mappings there are")
def test_mappings_are_counted():
    assert 100 < relief.mappings() < 65_530  # a process with JAX has hundreds: one for each part of a library


def test_programs_are_forgotten_only_when_there_are_too_many(monkeypatch):
    double = jax.jit(lambda x: 2 * x)
    double(1.0)
    monkeypatch.setattr(relief, "mappings", lambda: relief.MOST_MAPPINGS)
    relief.relieve()
    assert double._cache_size() == 1
    monkeypatch.setattr(relief, "mappings", lambda: relief.MOST_MAPPINGS + 1)
    relief.relieve()
    assert double._cache_size() == 0
    assert double(2.0) == 4.0


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux says how much memory a process takes")
def test_only_a_large_process_gives_memory_back(monkeypatch):
    assert 50e6 < relief.resident() < 50e9
    trimmed = []
    monkeypatch.setattr(relief.ctypes, "CDLL", lambda _: types.SimpleNamespace(malloc_trim=trimmed.append))
    monkeypatch.setattr(relief, "resident", lambda: relief.MOST_RESIDENT)
    relief.relieve()
    assert not trimmed
    monkeypatch.setattr(relief, "resident", lambda: relief.MOST_RESIDENT + 1)
    relief.relieve()
    assert trimmed == [0]
