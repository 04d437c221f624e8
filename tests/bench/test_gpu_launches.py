"""Launches of a rollout on a GPU, read from a program that is compiled for one without one.

That needs a compiler for NVIDIA GPUs. ``JAXWALK_GPU_COMPILER`` names the Python of an environment that has one, and
jaxwalk; `.ci/run` makes it.
"""

from __future__ import annotations

import json
import os
import subprocess

import pytest

MOST_LAUNCHES = 60
"""Most launches in a step of a rollout in the paper's world with the views of the recipe ``fast``."""


def test_a_rollout_launches_little_and_never_waits(tmp_path):
    python = os.environ.get("JAXWALK_GPU_COMPILER")
    if not python:
        pytest.skip("JAXWALK_GPU_COMPILER names no Python with a compiler for GPUs")
    command = [python, "-m", "jaxwalk", "bench", "--plan", "h100", "--quick", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    (rollout,) = json.loads(done.stdout)["programs"]
    assert 10 < rollout["launches_per_step"] <= MOST_LAUNCHES
    assert rollout["synchronisations_per_step"] == 0
