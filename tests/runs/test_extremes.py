"""Extreme but legal values: they are evaluated and trained with, and mean what they say."""

from __future__ import annotations

import io
import json
import math
from dataclasses import replace

import pytest
from rich.console import Console

from jaxwalk import Street
from jaxwalk.evaluation import evaluate, with_jaywalk_multiplier, write_rows
from jaxwalk.metrics import JAYWALK_RATE, OUTCOMES, summarise
from jaxwalk.policies import DRIVERS, POPULATIONS, load_policy
from jaxwalk.recipes import with_training
from jaxwalk.runs.folder import Run
from jaxwalk.runs.progress import Display
from jaxwalk.runs.training import train_in
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.sim_config import SimConfig

pytestmark = pytest.mark.long

LONELY = SimConfig(pedestrians=1, dt=0.02, horizon=600)
CROWDED = SimConfig(pedestrians=200, horizon=120)


def _evaluated(street):
    return evaluate(
        street,
        {"driver": DRIVERS["constant-speed"](), "pedestrian": POPULATIONS["always-go"]()},
        Drawn(street, 0, 4),
        batch=4,
    )


def test_a_crowd_that_never_and_one_that_nearly_always_jaywalks():
    """P(jaywalk) = min(1, 4 tau), with tau uniform, is 1 - 1 / 8 on average; beyond 1 / 4 it is certain."""
    street = Street.create(config=CROWDED)
    never, always = (_evaluated(with_jaywalk_multiplier(street, x)) for x in (0.0, 4.0))
    rates = [summarise(rows)[JAYWALK_RATE].all.value for rows in (never, always)]
    assert rates[0] == 0
    assert rates[1] == pytest.approx(7 / 8, abs=0.06)


def test_one_pedestrian_and_short_steps(tmp_path):
    rows = _evaluated(Street.create(config=LONELY))
    times = (rows[OUTCOMES].steps * rows.dt).tolist()
    assert all(0 < time <= 12 for time in times), "600 steps of 0.02 s"
    assert summarise(rows).as_dict()["episodes"] == 4
    write_rows(tmp_path / "episodes.csv", [("a", "b", rows)])
    written = [float(line.split(",")[-2]) for line in (tmp_path / "episodes.csv").read_text().splitlines()[1:]]
    assert written == pytest.approx(times, abs=1e-9), "no digit of a duration is lost"


@pytest.mark.parametrize(("sim", "multiplier"), [(LONELY, 4.0), (CROWDED, 0.0)], ids=["1 person", "200 people"])
def test_one_environment_trains(tmp_path, tiny, sim, multiplier):
    short = with_training(tiny, environments=1, updates=2)
    run = Run.create(tmp_path / "run", replace(short, sim=sim, jaywalk_multiplier=multiplier))
    trained = train_in(run, display=Display(Console(file=io.StringIO())))
    assert (trained.updates, trained.steps) == (2, 16)
    for line in (run.path / "metrics.jsonl").read_text().splitlines():
        assert all(map(math.isfinite, json.loads(line).values())), line
    assert load_policy(run.policy, "driver").view.name == "route-footprint"
