"""The study of learning with limits: what the page says of numbers, and a very small study."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from rich.console import Console

from jaxwalk.evaluation import (
    Cell,
    Match,
    Results,
    ScenarioSet,
    evaluate_grid,
    over_training_seeds,
    paired_delay,
    paired_over_seeds,
)
from jaxwalk.evaluation.harm_numbers import paired_harm, seed_harms
from jaxwalk.evaluation.reading import DocumentError, Origin
from jaxwalk.experiments import tournament
from jaxwalk.experiments.risk_aware import WORST, RiskEffort, risk_aware, trainings
from jaxwalk.metrics import crossed_mean, measure, summarise
from jaxwalk.metrics.impact_tail import tail_parts
from jaxwalk.recipes import BLIND_CORNER, RECIPES, single_agent
from jaxwalk.report.risk_document import LimitKept, RiskDocument, as_risk_document
from jaxwalk.report.risk_page import answer, page
from jaxwalk.runs.folder import Run, RunError
from metrics.scenes import Scene, Walk, trajectory

PLAN = RiskEffort(updates=2, episodes=8, seed=3, seeds=2)
CARS = ["plain", "lagrangian", "cvar"]
HIT, NOBODY = Walk(2.0, 0.0), Walk(0.0, 50.0)


def test_the_three_trainings_are_the_recipes_and_differ_in_limits_alone():
    found = trainings(BLIND_CORNER)
    assert list(found) == CARS
    for name, recipe in zip(CARS, ("blind-corner", "blind-corner-lagrangian", "blind-corner-cvar"), strict=True):
        assert replace(found[name], recipe=recipe) == RECIPES[recipe]


def _match(driver, seed, speeds):
    """Episodes that end with a contact at each speed; 0 stands for an arrival."""
    scenes = [Scene(4, [HIT], speed=x, touched=[0]) if x else Scene(4, [NOBODY], goal=True) for x in speeds]
    rows = measure(trajectory(*scenes))
    cell = Cell(driver, "always-go", "mode", "mode", 0.25, summarise(rows, resamples=20), "route", "kerb")
    return Match(replace(cell, training_seed=seed), rows)


def _document(speeds, seeds):
    """The document of cars whose contacts have the given speeds: by driver, for each seed, in ten episodes."""
    of = {name: [_match(name, seed, each[seed]) for seed in range(seeds)] for name, each in speeds.items()}
    of["clearance"] = [_match("clearance", None, [3.0] + [0] * 9)]
    matches = [match for group in of.values() for match in group]
    pairs = [(of["plain"], of[name]) for name in CARS[1:]]
    results = Results(
        ScenarioSet(10, "0123456789abcdef", 90),
        tuple(match.cell for match in matches),
        over_seeds=over_training_seeds(matches),
        paired=tuple(paired_over_seeds("moving contact", *pair) for pair in pairs),
        paired_delays=tuple(paired_delay(*pair) for pair in pairs),
    )
    limits = tuple(LimitKept("cvar", seed, "impact_speed", 5.0, 4.5, 0.25) for seed in range(seeds))
    return RiskDocument(results, seed_harms(WORST, matches), tuple(paired_harm(WORST, *pair) for pair in pairs), limits)


SPEEDS = {
    "plain": [[9.0 + seed, 2] + [0] * 8 for seed in range(5)],
    "lagrangian": [[2.0 + seed / 2, 2] + [0] * 8 for seed in range(5)],
    "cvar": [[9.5 + seed * (-1) ** seed, 2] + [0] * 8 for seed in range(5)],
}
"""A hundredth of ten episodes is a tenth of the worst one: the fastest contact counts alone."""


def test_tails_over_seeds_by_hand():
    """Worst contacts of 9, 10, 11, 12 and 13 m/s and of 2, 2.5, ... 4: 11 and 3 on average, a difference of -8."""
    document = _document(SPEEDS, 5)
    plain, lagrangian, _, rule = document.tails
    assert plain.number.each == pytest.approx((9, 10, 11, 12, 13))
    assert (plain.number.mean.value, lagrangian.number.mean.value) == (pytest.approx(11), 3)
    parts = np.stack([tail_parts(np.array(each, float)) for each in SPEEDS["plain"]])
    low, high = crossed_mean(parts).ends()
    assert (plain.number.mean.low, plain.number.mean.high) == (pytest.approx(max(low, 0)), high)
    assert (rule.training_seeds, rule.number.mean.value) == ((None,), pytest.approx(3))
    assert document.compared[0].difference.value == pytest.approx(-8)
    assert document.compared[0].p is not None


def test_too_few_seeds_judge_nothing():
    few = _document(SPEEDS, 4)
    assert [one.p for one in few.compared] == [None, None]
    assert "cannot be judged" in answer(few)
    assert few.tails[0].number.mean.low is None


def test_the_answer_follows_from_the_numbers():
    document = _document(SPEEDS, 5)
    said = {
        p: answer(replace(document, compared=tuple(replace(x, p=p) for x in document.compared))) for p in (0.001, 0.2)
    }
    assert said[0.001].startswith("**The worst contacts of `lagrangian` are slower than those of `plain`**: -8.00 [")
    assert "**The worst contacts of `cvar` are slower" in said[0.001]
    assert "No effect of `lagrangian`" in said[0.2] and "p = 0.400" in said[0.2], "Holm's of two"


def test_the_page_and_its_document_go_together():
    document = _document(SPEEDS, 5)
    text = page(document, updates=7)
    assert "| plain | 11.00 [" in text and "| 9.00, 10.00, 11.00, 12.00, 13.00 |" in text
    assert "7 updates each" in text and "0123456789abcdef" in text
    assert "| cvar | impact_speed | 5 | 4.5, 4.5, 4.5, 4.5, 4.5 | 0.25, 0.25, 0.25, 0.25, 0.25 |" in text
    assert "nan" not in text


@pytest.fixture(scope="module")
def made(tiny, tmp_path_factory):
    """The folder, the document and the page of two training seeds; and what was said, by a second time too."""
    folder, said = tmp_path_factory.mktemp("risk") / "out", (io.StringIO(), io.StringIO())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tournament, "evaluate_grid", partial(evaluate_grid, batch=PLAN.episodes))
        for file in said:
            text = risk_aware(folder, PLAN, base=single_agent(tiny), console=Console(file=file, width=200))
    document = json.loads((folder / "risk-aware.json").read_text(encoding="utf-8"))
    return folder, document, text.read_text(encoding="utf-8"), [file.getvalue() for file in said]


@pytest.mark.long
def test_all_are_trained_alike_and_meet_the_same_scenarios(made):
    folder, document, *_ = made
    for name in CARS:
        for seed in PLAN.training_seeds:
            run = Run.open(folder / "runs" / name / f"seed-{seed}")
            assert [line["update"] for line in run.metrics()] == [1, 2]
    limits = [(x["driver"], x["training_seed"], x["cost"]) for x in document["limits"]]
    expected = {"lagrangian": ("contact", "critical_time"), "cvar": ("impact_speed",)}
    assert limits == [(name, seed, cost) for name, costs in expected.items() for seed in (3, 4) for cost in costs]
    cells = [(x["driver"], x["training_seed"]) for x in document["results"]["cells"]]
    assert cells == [*((name, seed) for name in CARS for seed in (3, 4)), ("clearance", None)]
    assert [x["difference"]["low"] for x in document["compared"]] == [None, None]


@pytest.mark.long
def test_the_cost_is_said_first_and_what_is_finished_is_kept(made):
    *_, page_text, (first, second) = made
    assert "6 trainings of 2 updates (480 steps) and 56 episodes of evaluation" in first.split("seed 3")[0]
    assert second.count("there already") == 7
    assert "among always-go" not in second
    assert "cannot be judged" in page_text and "nan" not in page_text


@pytest.mark.long
def test_another_plan_or_a_damaged_document_is_said(made, quiet):
    with pytest.raises(RunError, match="was begun with another value of episodes"):
        risk_aware(made[0], replace(PLAN, episodes=9), console=quiet)
    origin = Origin(made[0] / "risk-aware.json", "delete it")
    with pytest.raises(DocumentError, match=r"risk-aware.json: .*results, tails, compared, limits are not what it has"):
        as_risk_document({"results": {}}, origin)
    with pytest.raises(DocumentError, match=r"tails.*harm"):
        as_risk_document({**made[1], "tails": [{"driver": 1}]}, origin)
