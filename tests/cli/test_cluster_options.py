"""What `jaxwalk evaluate --cluster` refuses before it plays; needs no Ray."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from importlib.machinery import ModuleSpec

import pytest

from jaxwalk.cli import main
from jaxwalk.cli.jax_start import for_workers

GOOD = "evaluate --driver constant-speed --episodes 2048 --cluster local --out new"
REFUSED = {
    "--cluster somewhere": "--cluster somewhere: must be auto, local, ray://HOST:PORT or HOST:PORT",
    "--part 1/2": "--part: a cluster plays all parts; leave it out, or leave out --cluster",
    "--counterfactuals 3": "--counterfactuals: collisions aren't replayed in parts; leave it out, or",
    "--parts 0": "--parts must lie in [1, ",
    "--parts 5": "--parts 5: 2,048 episodes are 4 blocks of 512, so there are at most 4 parts; take a smaller N",
}


@pytest.fixture
def with_ray(monkeypatch):
    """As if Ray were installed."""
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *more: ModuleSpec(name, None) if name == "ray" else found(name, *more)
    )


@pytest.mark.parametrize("options", REFUSED)
def test_what_a_cluster_cannot_do_is_refused(options, with_ray, capsys, place):
    words = GOOD.replace("--cluster local ", "") if options.startswith("--cluster") else GOOD
    assert main([*words.split(), *options.split()]) == 2
    assert capsys.readouterr().err.startswith(f"jaxwalk: {REFUSED[options]}")
    assert not (place / "new").exists()


def test_a_cluster_needs_a_folder_and_parts_need_a_cluster(with_ray, capsys):
    assert main(GOOD.removesuffix("--out new").split()) == 2
    assert "--cluster needs --out DIR, for results, and for finished parts meanwhile" in capsys.readouterr().err
    assert main(["evaluate", "--driver", "constant-speed", "--parts", "3"]) == 2
    assert "--parts: goes with --cluster; leave it out, or see --part" in capsys.readouterr().err


def test_without_ray_a_message_names_the_extra(monkeypatch, capsys, place):
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name == "ray" else found(name, *more))
    assert main(GOOD.split()) == 2
    assert capsys.readouterr().err == (
        'jaxwalk: --cluster needs Ray; install it with: pip install "jaxwalk[cluster]"\n'
    )
    assert not (place / "new").exists()


def test_a_worker_knows_its_machine_before_it_imports_jax():
    program = "import sys, jaxwalk.cli.cluster_worker, jaxwalk.experiments.on_ray; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_workers_have_what_the_user_has_set_for_jax_and_nothing_of_this_machine(monkeypatch):
    monkeypatch.setattr("jaxwalk.cli.jax_start.cores", lambda: 7)
    for name in ("JAX_PLATFORMS", "JAX_COMPILATION_CACHE_DIR", "XLA_FLAGS"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "/cache")
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", "/cache/jaxwalk")
    monkeypatch.setenv("JAX_NUM_CPU_DEVICES", "7")
    monkeypatch.setenv("JAX_ENABLE_X64", "1")
    found = dict(for_workers())
    assert found["JAX_PLATFORMS"] == "cpu"
    assert found["JAX_NUM_CPU_DEVICES"] == "1"
    assert found["JAX_ENABLE_X64"] == "1"
    assert "JAX_COMPILATION_CACHE_DIR" not in found
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", "/shared")
    assert dict(for_workers())["JAX_COMPILATION_CACHE_DIR"] == "/shared"
