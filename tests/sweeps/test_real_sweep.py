"""Sweeps of real trainings, tiny ones: small networks, 64 steps an update. What varies compiles nothing anew."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from jaxwalk.cli import main
from jaxwalk.policies import load_policy
from jaxwalk.runs.branching import begin_at
from jaxwalk.runs.folder import Run
from jaxwalk.runs.progress import Display
from jaxwalk.runs.training import train_in
from jaxwalk.sweeps import trial_work
from jaxwalk.sweeps.study_file import load_sweep
from jaxwalk.sweeps.sweeping import sweep
from sweeps.tiny_sweep import written


@pytest.mark.long
def test_a_sweep_trains_and_evaluates_run_folders(place, capsys):
    """The objective is of an evaluation."""
    study = written(place, metric="outcomes.kilometres", more='of = "evaluation"\nepisodes = 4\nseed = 7')
    assert main(["sweep", str(study), "--out", "out"]) == 0
    document = json.loads((place / "out" / "study.json").read_text())
    assert [trial["state"] for trial in document["trials"]] == ["complete"] * 2
    assert all(trial["value"] == trial["seeds"]["seed-0"] > 0 for trial in document["trials"])
    for number in range(2):
        run = Run.open(place / "out" / "trials" / str(number) / "seed-0")
        assert run.experiment.driver_weights["time"] == document["trials"][number]["values"]["driver_weights.time"]
        assert len(run.metrics()) == 1 and load_policy(run.policy, "driver")
    page = (place / "out" / "study.html").read_text()
    assert "1,000" not in page and "of an evaluation on 4 scenarios of seed 7 among always-go" in page


def test_a_number_that_no_evaluation_has_is_refused(place, capsys):
    study = written(place, metric="outcomes.gaol", more='of = "evaluation"')
    assert main(["sweep", str(study), "--out", "out"]) == 2
    assert "an evaluation has no 'outcomes.gaol'; it has outcomes.goal" in capsys.readouterr().err
    assert not (place / "out").exists()


def population(place, members, generations, updates):
    """Write a study of a population; return its path."""
    more = f"[pbt]\nmembers = {members}\ngenerations = {generations}"
    return written(place, sampler="pbt", more=more, updates=updates)


@pytest.mark.long
def test_a_population_that_is_killed_goes_on_and_a_member_that_is_never_replaced_is_an_ordinary_training(
    place, quiet, monkeypatch
):
    plan = load_sweep(population(place, members=2, generations=2, updates=2))

    def killed(run, parent, updates):
        begin_at(run, parent, updates)
        raise KeyboardInterrupt

    monkeypatch.setattr(trial_work, "begin_at", killed)
    with pytest.raises(KeyboardInterrupt):
        sweep(place / "out", plan, console=quiet)
    monkeypatch.setattr(trial_work, "begin_at", begin_at)
    first, second, *later = sweep(place / "out", plan, console=quiet).trials
    better, worse = (first, second) if first.value > second.value else (second, first)
    kept, copied = later[better.number], later[worse.number]
    assert (kept.parent, copied.parent) == (better.number, better.number)
    assert kept.values == better.values != copied.values
    ends = [Run.open(place / "out" / "trials" / str(trial.number) / "seed-0") for trial in (kept, copied)]
    assert [[line["update"] for line in run.metrics()] for run in ends] == [[2], [2]]
    assert ends[0].metrics()[0]["reward/driver/progress"] == ends[1].metrics()[0]["reward/driver/progress"]
    assert ends[1].experiment.driver_weights["time"] == copied.values["driver_weights.time"]
    whole = Run.create(place / "whole", ends[0].experiment)
    train_in(whole, display=Display(quiet))
    assert whole.policy.read_bytes() == ends[0].policy.read_bytes() != ends[1].policy.read_bytes()


def started(study, out):
    """Start a process of a sweep."""
    command = [sys.executable, "-m", "jaxwalk", "sweep", str(study), "--out", str(out)]
    environment = {**os.environ, "JAX_NUM_CPU_DEVICES": "1", "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0"}
    return subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def check_end(process):
    """Wait until a process has ended, and check that it ended well."""
    _, said = process.communicate(timeout=900)
    assert process.returncode == 0, said


def run_struck(study, out, kills, begins):
    """Run a sweep to its end by two processes. Each kill (SIGKILL) hits one of them, which is then started again.

    It comes at a random moment after two more trials have begun: the file ``begins`` is in their folders.
    """
    chance, processes = random.Random(0), [started(study, out), started(study, out)]

    def begun() -> int:
        return len(list(out.glob(f"trials/*/seed-0/{begins}")))

    try:
        for kill in range(kills):
            struck, wanted = processes[kill % 2], begun() + 2
            while begun() < wanted and any(process.poll() is None for process in processes):
                time.sleep(0.01)
            time.sleep(chance.uniform(0.0, 1.0))
            struck.send_signal(signal.SIGKILL)
            _, said = struck.communicate()
            assert struck.returncode == -signal.SIGKILL, f"it was over before it could be killed: {said}"
            processes[kill % 2] = started(study, out)
        for process in processes:
            check_end(process)
    finally:
        for process in processes:
            process.kill()
    check_end(started(study, out))


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="processes are killed")
def test_a_population_of_two_processes_killed_four_times_equals_an_untouched_one(place):
    study, out, alone = population(place, members=4, generations=4, updates=24), place / "out", place / "alone"
    run_struck(study, out, kills=4, begins="config.json")
    check_end(started(study, alone))
    found, untouched = (json.loads((folder / "study.json").read_text()) for folder in (out, alone))
    assert found["trials"] == untouched["trials"] and len(found["trials"]) == 16
    for trial in range(16):
        policy = Path("trials") / str(trial) / "seed-0" / "policy.safetensors"
        one, other = out / policy, alone / policy
        assert one.read_bytes() == other.read_bytes()


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="processes are killed")
def test_a_sweep_of_twenty_trials_killed_five_times_is_complete(place):
    study, out = written(place, trials=20, updates=12), place / "out"
    run_struck(study, out, kills=5, begins="metrics.jsonl")
    document = json.loads((out / "study.json").read_text())
    assert [(trial["number"], trial["state"]) for trial in document["trials"]] == [(n, "complete") for n in range(20)]
    assert len({trial["values"]["driver_weights.time"] for trial in document["trials"]}) == 20
    for number in range(20):
        lines = Run.open(out / "trials" / str(number) / "seed-0").metrics()
        assert [line["update"] for line in lines] == list(range(1, 13))
    told = [json.loads(line) for line in (out / "journal.log").read_text().splitlines()]
    ended = [entry["trial_id"] for entry in told if entry["op_code"] == 6 and entry["state"] == 1]
    assert sorted(ended) == list(range(20)), "each trial has ended once"
