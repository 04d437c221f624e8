"""Several processes learn as one process with as many shards does."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import jax
import numpy as np
import pytest
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from compiling import counted_programs
from jaxwalk import peers
from jaxwalk.cli.launcher import free_port
from learning.peer_worker import play

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="JAX's processes don't find each other on Windows")


def played(folder, processes, shards):
    """What each process holds after the first update and after the last one."""
    folder.mkdir()
    cache = str(jax.config.jax_compilation_cache_dir or folder / "cache")
    port = str(free_port())
    words = [sys.executable, str(Path(__file__).with_name("peer_worker.py"))]
    begun = [
        subprocess.Popen(
            [*words, str(number), str(processes), str(shards), port, str(folder)],
            env=os.environ | {"JAX_COMPILATION_CACHE_DIR": cache, "JAX_PLATFORMS": "cpu"},
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )
        for number in range(processes)
    ]  # fmt: skip
    try:
        said = [process.communicate(timeout=300)[0] for process in begun]
    finally:
        for process in begun:
            process.kill()
    assert [process.returncode for process in begun] == [0] * processes, "\n".join(said)
    return [[dict(np.load(folder / f"{name}-{k}.npz")) for k in range(processes)] for name in ("first", "last")]


def same(one, other):
    assert one.keys() == other.keys()
    for name, x in one.items():
        np.testing.assert_array_equal(x, other[name], err_msg=name)


@pytest.mark.long
def test_two_processes_equal_two_shards_to_the_bit(tmp_path):
    first, last = played(tmp_path / "two", 2, 2)
    alone = play(2, tmp_path / "alone")
    for of_both, reference in zip((first, last), alone, strict=True):
        for of_one in of_both:
            same(of_one, reference)
    assert any(not np.array_equal(x, alone[1][name]) for name, x in alone[0].items()), "something was learned"


def test_whole_arrays_are_compiled_once(monkeypatch):
    """Two devices of this process stand for those of two."""
    monkeypatch.setattr(peers, "several", lambda: True)
    mesh = Mesh(np.array(jax.devices()[:2]), ("device",))
    halves = [jax.device_put(np.arange(6) + k, NamedSharding(mesh, PartitionSpec("device"))) for k in range(2)]
    assert halves[0].addressable_data(0).shape == (3,)
    with counted_programs() as programs:
        for k, half in enumerate(halves):
            whole = peers.gathered({"numbers": half, "name": "x"})
            assert whole["name"] == "x" and np.array_equal(whole["numbers"], np.arange(6) + k)
    assert len(programs) == 1


@pytest.mark.long
def test_four_processes_repeat_themselves_and_are_close_to_four_shards(tmp_path):
    """A sum of four comes in another order than four shards have; after one update little has come of that."""
    firsts, lasts = played(tmp_path / "once", 4, 4)
    again = played(tmp_path / "again", 4, 4)
    (first,), _ = played(tmp_path / "shards", 1, 4)
    for each in (*firsts, *again[0]):
        same(each, firsts[0])
    for each in (*lasts, *again[1]):
        same(each, lasts[0])
    for name, x in first.items():
        np.testing.assert_allclose(firsts[0][name], x, atol=1e-5, rtol=0, err_msg=name)


@pytest.mark.long
def test_two_processes_divide_four_shards(tmp_path):
    firsts, lasts = played(tmp_path / "two", 2, 4)
    same(firsts[0], firsts[1])
    same(lasts[0], lasts[1])
    (first,), _ = played(tmp_path / "shards", 1, 4)
    for name, x in first.items():
        np.testing.assert_allclose(firsts[0][name], x, atol=1e-5, rtol=0, err_msg=name)
