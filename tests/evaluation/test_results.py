from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from dataclasses import asdict

import jax
import pytest

from jaxwalk.evaluation import SAMPLES, acts_by, evaluate_grid, paired, with_jaywalk_multiplier, with_mode, write_rows
from jaxwalk.evaluation.settings import jaywalk_multiplier
from jaxwalk.learning.actor import make_actor
from jaxwalk.learning.config import RoleConfig
from jaxwalk.maps import read_map
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import AlwaysGo, ConstantSpeed, LearnedPolicy, Random, RouteFollower
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.sim_config import SimConfig


def test_the_document_is_as_promised(compared):
    results, rows = compared
    document = json.loads(results.to_json(), parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert list(document) == ["schema", "scenarios", "street", "cells"]
    assert document["schema"] == 5
    assert document["scenarios"] == {"seed": 7, "count": 24, "hash": results.scenarios.hash}
    assert document["street"]["maps"] == [{"name": "paper", "hash": read_map("paper").hash}]
    assert document["street"]["sim"] == json.loads(json.dumps(asdict(SimConfig())))
    pairs = [(cell["driver"], cell["pedestrians"]) for cell in document["cells"]]
    assert pairs == [(d, p) for d in ("route-follower", "random") for p in ("undecided", "always-go")]
    modes = [(cell["driver_mode"], cell["pedestrian_mode"]) for cell in document["cells"]]
    assert modes == [(d, p) for d in ("mode", "sample") for p in ("sample", "mode")]
    observes = [(cell["driver_observes"], cell["pedestrian_observes"]) for cell in document["cells"]]
    assert observes == [(d, "paper") for d in ("route", "paper") for _ in range(2)]
    cell = document["cells"][1]
    assert cell["jaywalk_multiplier"] == 0.25
    assert cell["episodes"] == 24
    for name in ("goal_rate", "collision_rate", "timeout_rate", "mean_time_to_goal"):
        assert list(cell[name]) == ["value", "low", "high"]
        assert cell[name]["low"] <= cell[name]["value"] <= cell[name]["high"]
    assert cell["goal_rate"]["value"] == rows["route-follower", "always-go"][OUTCOMES].goal.mean()
    assert sum(cell[name]["value"] for name in ("goal_rate", "collision_rate", "timeout_rate")) == pytest.approx(1)
    assert cell["preventable_share"] == {"value": None, "low": None, "high": None}, "nothing was replayed"
    assert {"outcomes", "speed_differential", "attribution", "encounters", "jaywalk_rate", "waiting"} < set(cell)


IN_ANOTHER_PROCESS = """
import os, jax
if os.environ["CACHE"]:
    jax.config.update("jax_compilation_cache_dir", os.environ["CACHE"])
from jaxwalk import Street
from jaxwalk.evaluation import evaluate_grid
from jaxwalk.policies import AlwaysGo, Random, RouteFollower
from jaxwalk.scenarios import Drawn
drivers, street = {"route-follower": RouteFollower(), "random": Random()}, Street.create()
print(evaluate_grid(street, drivers, {"always-go": AlwaysGo()}, Drawn(street, 7, 24), batch=16)[0].to_json())
"""


@pytest.mark.long
def test_the_same_call_gives_the_same_document_here_and_in_another_process(street, compared):
    drivers = {"route-follower": RouteFollower(), "random": Random()}
    again, _ = evaluate_grid(street, drivers, {"always-go": AlwaysGo()}, Drawn(street, 7, 24), batch=16)
    assert [again.cell(name, "always-go").as_dict() for name in drivers] == [
        compared[0].cell(name, "always-go").as_dict() for name in drivers
    ]
    environment = os.environ | {"CACHE": jax.config.jax_compilation_cache_dir or ""}
    other = subprocess.run(
        [sys.executable, "-c", IN_ANOTHER_PROCESS], env=environment, capture_output=True, text=True, check=True
    )
    assert other.stdout.strip() == again.to_json().strip()


def test_a_cell_is_found_by_its_names(compared):
    results, _ = compared
    assert results.cell("random", "always-go").driver == "random"
    with pytest.raises(KeyError, match="no cell for random among learned"):
        results.cell("random", "learned")


def test_a_row_per_episode(compared, tmp_path):
    _, rows = compared
    path = tmp_path / "episodes.csv"
    write_rows(path, [(*names, cell) for names, cell in rows.items()])
    with path.open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]
    ending = ["outcome", "contact", "impact_speed", "duration"]
    assert list(table[0]) == ["scenario", "driver", "pedestrians", *ending, "map"]
    assert {row["map"] for row in table} == {"paper"}
    assert [int(row["scenario"]) for row in table] == [*range(24)] * 4
    assert {row["outcome"] for row in table} == {"goal", "collision", "timeout"}
    for row in table:
        assert (row["outcome"] == "collision") == (row["contact"] != "") == (row["impact_speed"] != "")
    episodes = rows["route-follower", "always-go"][OUTCOMES]
    assert float(table[24]["duration"]) == pytest.approx(episodes.steps[0] * 0.1)


def test_pairs_of_the_same_scenarios(compared, rows):
    a, b = (compared[1][name, "always-go"] for name in ("route-follower", "random"))
    same, pair = paired(a, a), paired(a, b)
    assert (same.goal.only_a, same.goal.only_b, same.goal.difference, same.goal.p) == (0, 0, 0, 1)
    assert same.alike and not pair.alike
    goal = pair.goal
    assert pair.scenarios == 24
    assert goal.both + goal.only_a == a[OUTCOMES].goal.sum()
    assert goal.both + goal.only_b == b[OUTCOMES].goal.sum()
    assert goal.difference == pytest.approx(b[OUTCOMES].goal.mean() - a[OUTCOMES].goal.mean())
    assert 0 <= goal.p < 0.01
    with pytest.raises(ValueError, match="same scenarios"):
        paired(a, rows)


def test_modes_are_set_and_told(street):
    actor = make_actor(jax.random.key(0), 20, street.roles["pedestrian"].action, RoleConfig())
    policy = LearnedPolicy(actor, "driver")
    assert (acts_by(policy), acts_by(with_mode(policy, sample=True))) == ("mode", "sample")
    assert with_mode(ConstantSpeed(), sample=True) == ConstantSpeed()
    assert acts_by(with_mode(Random(), sample=False)) == "sample"
    assert SAMPLES == {"driver": False, "pedestrian": True}


def test_the_multiplier_is_told_as_it_was_written(street):
    wanted = [0.0, 0.1, 0.6, 1.0]
    assert [jaywalk_multiplier(with_jaywalk_multiplier(street, x)) for x in wanted] == wanted
    with pytest.raises(ValueError, match="0 or more"):
        with_jaywalk_multiplier(street, -0.1)
