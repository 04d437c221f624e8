"""The study of generalisation, very small: who trains and drives where, what is said, and that it goes on."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from functools import partial

import pytest
from rich.console import Console

from conftest import SMALL
from jaxwalk.evaluation import evaluate_grid
from jaxwalk.evaluation.over_streets import StreetScores, StreetSet
from jaxwalk.experiments import generalisation as module
from jaxwalk.experiments import tournament
from jaxwalk.experiments.generalisation import GeneralisationEffort, generalisation, own_streets
from jaxwalk.maps import each_map
from jaxwalk.provenance import Provenance
from jaxwalk.recipes import TOWN, single_agent, with_training
from jaxwalk.report import generalisation_page
from jaxwalk.runs.folder import Run, RunError

PLAN = GeneralisationEffort(updates=2, episodes=8, seed=3, seeds=2)
FEW = {"STREETS": (1, 2), "CROWDS": (2, 3), "USUAL": 3, "RULES": ("route-follower",)}
"""So few streets, people and rules; ``TESTS`` are changed too."""


def a_set(name, people, shares):
    """Ten episodes on each of two streets, for each driver, of which this share reaches the goal."""
    scores = [
        StreetScores(driver, seed, (10, 10), (round(10 * x), round(10 * x)), (1, 0))
        for driver, seeds, x in shares
        for seed in seeds
    ]
    return StreetSet(name, people, ("a", "b"), tuple(scores))


def test_the_page_says_the_gap_and_shows_rules_beside_cars():
    seeds, none = range(5), (None,)
    rules = [("route-follower", none, 0.6)]
    sets = [
        a_set("test", 6, [("streets-1", seeds, 0.9), *rules]),
        a_set("test", 12, [("streets-1", seeds, 0.8), *rules]),
        a_set("paper", 12, [("streets-1", seeds, 0.7), *rules]),
        *(a_set("own", 12, [("streets-1", (seed,), 1.0)]) for seed in seeds),
    ]
    made = Provenance(commit=None, hardware="an abacus", versions={})
    text = generalisation_page.page(sets, updates=4, made=made)
    assert "`streets-1` reaches its goal in 100.00 % on its own streets and in 80.0 [" in text
    assert "a gap of 20.00 points, with no interval." in text, "nothing differs among the seeds"
    assert "| driver | own | test | paper | own minus test |" in text
    ends = "60.00 [2.68, 99.57]"
    assert f"| route-follower | – | {ends} | {ends} | – |" in text, "each of two streets counts as one trial"
    assert "| driver | 6 | 12 |" in text
    assert "nan" not in text


def test_seeds_train_on_other_streets(monkeypatch):
    monkeypatch.setattr(module, "STREETS", (1, 2, 4))
    every = each_map(["training:4"])
    assert [own_streets(1, place) for place in range(5)] == [*((name,) for name in every), (every[0],)]
    assert [own_streets(2, place) for place in range(3)] == [every[:2], every[2:], every[:2]]
    assert own_streets(4, 3) == every


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder, the page, and what was said, by a second time too."""
    folder, said = tmp_path_factory.mktemp("generalisation") / "out", (io.StringIO(), io.StringIO())
    town = single_agent(TOWN)
    roles = {
        name: replace(role, actor_hidden=(8,), critic_hidden=(8,), epochs=1) for name, role in town.train.roles.items()
    }
    base = replace(with_training(town, **SMALL, roles=roles), crowds=(2, 3))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tournament, "evaluate_grid", partial(evaluate_grid, batch=PLAN.episodes))
        patch.setattr(generalisation_page, "USUAL", FEW["USUAL"])
        patch.setattr(module, "TESTS", {"test": "test:2", "paper": "paper"})
        for name, value in FEW.items():
            patch.setattr(module, name, value)
        for file in said:
            page = generalisation(folder, PLAN, base=base, console=Console(file=file, width=200))
    return folder, page.read_text(encoding="utf-8"), [file.getvalue() for file in said]


@pytest.mark.long
def test_everybody_drives_on_every_set(made):
    folder, *_ = made
    document = json.loads((folder / "generalisation.json").read_text(encoding="utf-8"))
    sets = [(one["name"], one["people"], len(one["streets"]), len(one["scores"])) for one in document["sets"]]
    own = [("own", 3, 1, 1)] * 2 + [("own", 3, 2, 1)] * 2
    assert sets == [("test", 2, 2, 5), ("test", 3, 2, 5), ("paper", 3, 1, 5), *own]
    drivers = [(x["driver"], x["training_seed"]) for x in document["sets"][0]["scores"]]
    assert drivers == [("streets-1", 3), ("streets-1", 4), ("streets-2", 3), ("streets-2", 4), ("route-follower", None)]
    assert {sum(x["episodes"]) for one in document["sets"] for x in one["scores"]} == {PLAN.episodes}
    trained = [Run.open(folder / "runs" / "streets-1" / f"seed-{seed}").experiment for seed in (3, 4)]
    assert trained[0].maps != trained[1].maps
    assert {one.sim.max_speed for one in trained} == {TOWN.sim.max_speed}


@pytest.mark.long
def test_the_page_of_a_study_and_a_second_time(made):
    _, page, (first, second) = made
    assert "a gap of" in page and "with no interval" in page
    assert "4 trainings of 2 updates (" in first
    assert second.count("there already") == 4 + 2 + 4
    assert "among always-go" not in second


@pytest.mark.long
def test_another_plan_needs_another_folder(made, quiet):
    with pytest.raises(RunError, match="was begun with another value of episodes"):
        generalisation(made[0], replace(PLAN, episodes=9), console=quiet)
