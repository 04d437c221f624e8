"""Does co-training help, very small: what is trained, who meets whom, what is said, and that it goes on."""

import io
import json
from dataclasses import replace
from functools import partial

import pytest
from rich.console import Console

from jaxwalk.evaluation import evaluate_grid
from jaxwalk.experiments import co_training as module
from jaxwalk.experiments import tournament
from jaxwalk.experiments.co_training import CoTrainingEffort, cells, co_training
from jaxwalk.learning.config import own_environments
from jaxwalk.policies import load_policy
from jaxwalk.recipes import RECIPES, single_agent
from jaxwalk.runs.folder import Run, RunError

PLAN = CoTrainingEffort(updates=2, episodes=8, seed=3, seeds=2)
CARS = ["pure", "pure-stand-ins", "mixed", "mixed-stand-ins", "alone"]
POPULATIONS = ["always-go", "gap-acceptance", "people of pure", "people of pure-stand-ins"]


def test_the_car_learns_from_as_much_in_each_training():
    """The shares are of all environments, which differ, so that the driver's own stay the same."""
    fast = RECIPES["fast"]
    found = cells(fast)
    assert list(found) == CARS
    assert {own_environments(one.train, "driver") for one in found.values()} == {512}
    assert (found["mixed-stand-ins"], found["alone"]) == (fast, single_agent(fast))
    always_go = {name: one.train.roles["pedestrian"].fixed * one.train.environments for name, one in found.items()}
    assert always_go == {"pure": 0, "pure-stand-ins": 0, "mixed": 384, "mixed-stand-ins": 384, "alone": 512}
    careless = {name: (one.train.roles["driver"].fixed, one.train.roles["driver"].early) for name, one in found.items()}
    with_stand_ins = {"pure-stand-ins": (1 / 4, 1 / 12), "mixed-stand-ins": (1 / 4, 1 / 12)}
    assert careless == dict.fromkeys(CARS, (0, 0)) | with_stand_ins


@pytest.fixture(scope="module")
def made(tiny, tmp_path_factory):
    """The folder, the document and the page of two training seeds; and what was said, by a second time too."""
    folder, said = tmp_path_factory.mktemp("co-training") / "out", (io.StringIO(), io.StringIO())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tournament, "evaluate_grid", partial(evaluate_grid, batch=PLAN.episodes))
        for file in said:
            page = co_training(folder, PLAN, base=tiny, console=Console(file=file, width=200))
    document = json.loads((folder / "co-training.json").read_text(encoding="utf-8"))
    return folder, document, page.read_text(encoding="utf-8"), [file.getvalue() for file in said]


@pytest.mark.long
def test_everybody_meets_the_same_scenarios_and_people(made):
    _, document, _, _ = made
    assert document["street"]["sim"]["contact"] == "footprint"
    cells = [(c["pedestrians"], c["driver"], c["training_seed"]) for c in document["cells"]]
    seeds = {people: [3, 4] if people.startswith("people") else [None] for people in POPULATIONS}
    rule = [(people, "clearance", seed) for people in POPULATIONS for seed in seeds[people]]
    cars = [(people, car, seed) for people in POPULATIONS for car in CARS for seed in (3, 4)]
    assert sorted(map(str, cells)) == sorted(map(str, rule + cars))
    of = {(x["ending"], x["a"]["driver"], x["b"]["driver"]) for x in document["paired"]}
    alone = {(ending, "alone", car) for ending in ("moving contact", "goal") for car in CARS[:4]}
    assert alone < of
    assert len(of) == 12
    assert len(document["paired_delays"]) == 16


@pytest.mark.long
def test_a_car_never_meets_those_who_learned_beside_it(made, tiny, quiet):
    folder, *_ = made
    work = module.CoTrainingWork(folder, PLAN, quiet, tiny)
    people = {
        seed: among["people of pure"]
        for seed, drivers, among in module._rounds(work, work.street())
        if "alone" in drivers
    }
    for seed, other in ((3, 4), (4, 3)):
        expected = load_policy(Run.open(folder / "runs" / "pure" / f"seed-{other}").policy, "pedestrian")
        assert (people[seed].actor.network.weights[0] == expected.actor.network.weights[0]).all()


@pytest.mark.long
def test_the_page(made):
    *_, page, (first, second) = made
    assert "**Whether co-training makes a better car cannot be judged**: there are 2 training seeds" in page
    assert [line[9:] for line in page.splitlines() if line.startswith("## Among ")] == POPULATIONS
    assert page.count("| clearance |") == 4
    assert "nan" not in page
    assert "10 trainings of 2 updates (" in first
    assert second.count("there already") == 11


@pytest.mark.long
def test_another_plan_needs_another_folder(made, quiet):
    with pytest.raises(RunError, match="was begun with another value of episodes"):
        co_training(made[0], replace(PLAN, episodes=9), console=quiet)
