"""Ctrl-C ends a training, which goes on later."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import pytest

from jaxwalk.learning import checkpoint
from jaxwalk.recipes import with_training
from jaxwalk.runs.folder import Run

SMALL = ("--environments", "8", "--steps", "8", "--minibatches", "2")


@pytest.mark.long
def test_ctrl_c_leaves_a_run_that_resumes(place):
    command = [sys.executable, "-m", "jaxwalk", "train", "--run", "run", "--updates", "100000", *SMALL]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=place) as process:
        try:
            _wait_for(lambda: len(_lines(place)) >= 2, process)
            process.send_signal(signal.SIGINT)
            _, err = process.communicate(timeout=120)
        finally:
            process.kill()
    assert process.returncode == 130
    assert "Traceback" not in err
    assert "jaxwalk train --resume run" in " ".join(err.split())
    run = Run.open(place / "run")
    made = run.metrics()[-1]["update"]
    assert [line["update"] for line in run.metrics()] == list(range(1, made + 1))
    run.describe(with_training(run.experiment, updates=100000))
    assert checkpoint.latest(run.checkpoints) == made
    assert run.policy.is_file()


def _lines(place):
    path = place / "run" / "metrics.jsonl"
    return path.read_text().splitlines() if path.is_file() else []


def _wait_for(happened, process, seconds=300):
    until = time.monotonic() + seconds
    while not happened():
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < until
        time.sleep(0.05)
