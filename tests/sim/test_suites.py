"""Suites name streets that no training has, in worlds that exist; and everybody finds the same street by a name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from jaxwalk.recipes import RECIPES
from jaxwalk.runs.contestants import world_of
from jaxwalk.runs.folder import Run
from jaxwalk.sim.sim_config import WORLDS, SimConfig, rules_of
from jaxwalk.sim.suites import SUITES, Where

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.parametrize("name", SUITES)
def test_a_suite_is_a_world_that_exists_with_its_crowd_and_is_on_the_page(name):
    suite = SUITES[name]
    rules = rules_of(suite.world, suite.maps)
    assert rules == rules_of(suite.world, (), SimConfig()) and suite.people <= SimConfig(pedestrians=72).pedestrians
    assert suite.world in WORLDS
    assert (
        f"| `{name}` | `{'`, `'.join(suite.maps)}` | `{suite.world}` | {suite.people} |"
        in (DOCS / "suites.md").read_text()
    )


def test_no_training_has_the_streets_of_a_suite():
    streets = {street for suite in SUITES.values() for street in suite.maps if street != "paper"}
    tests = ("test", "unseen-ranges", "arterial", "parked-test")
    assert streets and all(street.rpartition(":")[0] in tests for street in streets)


def test_a_suite_is_the_same_whatever_a_car_was_trained_in(tmp_path, monkeypatch):
    trained = replace(RECIPES["blind-corner"], sim=SimConfig(earlier_decisions=1, max_speed=11.0, offroad_margin=2.0))
    run = Run.create(tmp_path / "run", replace(trained, maps=("parked-training:1",)))
    few = replace(SUITES["blind-corner"], maps=("parked-test:2",))  # streets take long to make
    monkeypatch.setitem(SUITES, "blind-corner", few)
    there = world_of([str(run.path)], few)
    assert there.config == replace(WORLDS["blind-corner"], pedestrians=48)


def test_a_named_crowd_and_world_win_over_those_of_a_run_folder(tmp_path):
    run = Run.create(tmp_path / "run", RECIPES["fast"])
    there = world_of([str(run.path)], Where(("paper",), "town", 30))
    assert there.config == rules_of("town", (), SimConfig(pedestrians=30))
    assert world_of([str(run.path)]).config == RECIPES["fast"].sim
    assert world_of([], Where(people=3)).roles["pedestrian"].agents == (3,)
    with pytest.raises(ValueError, match="pedestrians must be at most 1000"):
        world_of([], Where(people=1001))
