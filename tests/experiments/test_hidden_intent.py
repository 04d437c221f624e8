"""The cost of hidden intent, very small: what is made, from what, and that it goes on."""

import io
import json
from dataclasses import replace
from functools import partial

import pytest
from rich.console import Console

from jaxwalk.evaluation import evaluate, evaluate_grid
from jaxwalk.evaluation.reading import DocumentError, Origin
from jaxwalk.experiments import hidden_intent as module
from jaxwalk.experiments import tournament
from jaxwalk.experiments.hidden_intent import IntentEffort, cars_of, hidden_intent
from jaxwalk.policies import read_metadata
from jaxwalk.recipes import BLIND_CORNER, single_agent, with_training
from jaxwalk.report.intent_document import as_intent_street
from jaxwalk.runs.folder import Run, RunError
from jaxwalk.sim.observation import BELIEF, FOOTPRINT, PLACEBO, TOLD, X_RAY
from jaxwalk.sim.suites import SUITES, Where

pytestmark = pytest.mark.long
PLAN = IntentEffort(updates=2, episodes=8, seed=3, seeds=2)
TIMED = ("blind", "told", "blind-time-4", "told-time-4")
SEES = {"blind": FOOTPRINT, "placebo": PLACEBO, "belief": BELIEF, "told": TOLD}


@pytest.fixture(scope="module")
def made(tiny, tmp_path_factory):
    """The folder, the document and the page of two training seeds; and what was said, by a second time too."""
    folder, said = tmp_path_factory.mktemp("intent") / "out", (io.StringIO(), io.StringIO())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tournament, "evaluate_grid", partial(evaluate_grid, batch=PLAN.episodes))
        patch.setattr(module, "evaluate", partial(evaluate, batch=PLAN.episodes))
        for file in said:
            page = hidden_intent(folder, PLAN, base=single_agent(tiny), console=Console(file=file, width=200))
    document = json.loads((folder / "hidden-intent.json").read_text(encoding="utf-8"))
    return folder, document, page.read_text(encoding="utf-8"), [file.getvalue() for file in said]


def test_each_car_sees_its_own(made):
    folder, *_ = made
    for name, observes in SEES.items():
        for seed in PLAN.training_seeds:
            run = Run.open(folder / "runs" / name / f"seed-{seed}")
            metadata = read_metadata(run.policy)
            assert (metadata["seed"], metadata["single_agent"]) == (seed, True)
            assert metadata["roles"]["driver"]["observes"] == observes
            assert run.experiment.train.roles["driver"].critic_observes == (FOOTPRINT, "global")
            assert [line["update"] for line in run.metrics()] == [1, 2]


def test_everybody_meets_the_same_scenarios(made):
    _, document, _, _ = made
    assert [street["setting"] for street in document["streets"]] == ["jaywalk multiplier 0.25", "jaywalk multiplier 1"]
    hashes = {street["scenarios"]["hash"] for street in document["streets"]}
    assert len(hashes) == 1
    for street, multiplier in zip(document["streets"], (0.25, 1.0), strict=True):
        *cells, rule = [(c["driver"], c["driver_observes"], c["training_seed"]) for c in street["cells"]]
        assert cells == [(name, observes, seed) for seed in (3, 4) for name, observes in SEES.items()]
        assert rule[::2] == ("clearance", None)
        assert {c["jaywalk_multiplier"] for c in street["cells"]} == {multiplier}
        pairs = [(p["ending"], p["a"]["driver"], p["b"]["driver"], p["pairs"]) for p in street["paired"]]
        against = [
            ("blind", "placebo"),
            ("blind", "belief"),
            ("blind", "told"),
            ("placebo", "belief"),
            ("placebo", "told"),
        ]
        assert pairs == [(end, *pair, 16) for end in ("moving contact", "goal") for pair in against]
        for part in ("paired_harms", "paired_delays"):
            assert [(one["a"], one["b"]) for one in street[part]] == against
        assert [one["driver"] for one in street["harms"]] == [*SEES, "clearance"]
        assert street["equal_delays"] == []


def test_how_much_could_be_known(made):
    _, document, _, _ = made
    for street in document["streets"]:
        whole, typical, met, *after = street["identifiability"]
        assert whole["seen"] == "in a whole episode (50 s)"
        assert 0 < whole["people"] <= 8 * 12
        assert typical["people"] == 2 * 8 * 12
        assert typical["crossings"] <= whole["crossings"]
        assert met["seen"].startswith("before a crossing")
        assert [row["crossings"] for row in after] == list(module.AFTER)
        assert 0 < after[0]["bits"] < after[-1]["bits"]


def test_the_page(made):
    *_, page, _ = made
    assert page.count("## Jaywalk multiplier") == 2
    assert page.count("`route-footprint-told` (no real car could)") == 2
    assert page.count("| moving contacts | blind among always-go | told among always-go |") == 2
    assert page.count("| serious injuries in 1,000 | blind | told |") == 2
    assert "**What hidden intent costs cannot be judged**" in page
    assert "nan" not in page


def test_what_is_finished_is_kept(made):
    *_, (first, second) = made
    assert "[1/3]" in first
    assert "belief, seed 4: there already" in second
    assert second.count("there already") == 10


def test_another_plan_needs_another_folder(made, quiet):
    with pytest.raises(RunError, match="was begun with another value of updates"):
        hidden_intent(made[0], replace(PLAN, updates=3), console=quiet)


def test_a_damaged_document_is_said(made, tiny, quiet):
    file = made[0] / "jaywalk-multiplier-1.json"
    whole = file.read_bytes()
    file.write_bytes(whole[:100])
    with pytest.raises(RunError, match=r"jaywalk-multiplier-1.json: damaged .* run `jaxwalk hidden-intent` again"):
        hidden_intent(made[0], PLAN, console=quiet, base=single_agent(tiny))
    file.write_bytes(whole)
    content = json.loads(whole)
    with pytest.raises(DocumentError, match=r"multiplier-1.json.*over_seeds.*all training seeds"):
        as_intent_street(content, 3, Origin(file, "delete it"))
    with pytest.raises(DocumentError, match=r"multiplier-1.json.*harms"):
        as_intent_street({**content, "harms": content["harms"][1:]}, 2, Origin(file, "delete it"))


def test_a_setting_is_kept_as_soon_as_it_was_played(made, tiny, monkeypatch):
    """The other one is played again, to the same document; and who computed it is not who asks again."""
    monkeypatch.setattr(tournament, "evaluate_grid", partial(evaluate_grid, batch=PLAN.episodes))
    monkeypatch.setattr(module, "evaluate", partial(evaluate, batch=PLAN.episodes))
    folder, document, *_ = made
    (folder / "jaywalk-multiplier-1.json").unlink()
    said = io.StringIO()
    hidden_intent(folder, PLAN, console=Console(file=said, width=200), base=single_agent(tiny))
    again = json.loads((folder / "hidden-intent.json").read_text("utf-8"))
    assert said.getvalue().split("[2/3]")[1].count("there already") == 1
    assert [one["cells"] for one in again["streets"]] == [one["cells"] for one in document["streets"]]


def test_where_people_are_hidden_there_are_cars_that_see_more(tiny, tmp_path, monkeypatch):
    """On streets that no training has; the page says what each car knows."""
    monkeypatch.setitem(SUITES, "blind-corner", Where(("test-2000000003",), "blind-corner", 3))
    roles = {"driver": replace(tiny.train.roles["driver"], critic_observes=(FOOTPRINT,))}
    small = with_training(tiny, roles=tiny.train.roles | roles)
    base = single_agent(replace(small, maps=("training:1",), sim=BLIND_CORNER.sim, crowds=(2, 3)))
    cars = ("x-ray", "blind", "aware", "decided")
    plan = IntentEffort(updates=2, episodes=4, seed=3, seeds=1, recipe="blind-corner", cars=cars)
    text = hidden_intent(tmp_path / "out", plan, base=base, console=Console(file=io.StringIO())).read_text("utf-8")
    document = json.loads((tmp_path / "out" / "hidden-intent.json").read_text("utf-8"))
    assert [one["setting"] for one in document["streets"]] == [
        "jaywalk multiplier 1", "jaywalk multiplier 0.25", "vehicles parked in 30 of 100 slots",
    ]  # fmt: skip
    assert [one["street"]["sim"]["parked"] for one in document["streets"]] == [0.9, 0.9, 0.3]
    street = document["streets"][0]
    assert street["street"]["maps"][0]["name"] == "test-2000000003"
    seen = {cell["driver"]: cell["driver_observes"] for cell in street["cells"]}
    assert list(seen) == ["blind", "x-ray", "aware", "decided", "clearance"]
    assert list(cars_of(base)) == ["blind", "x-ray", "memory", "aware", "placebo", "belief", "told", "decided"]
    assert document["plan"]["cars"] == list(cars)
    assert seen["x-ray"] == X_RAY
    assert "with the recipe `blind-corner`" in text
    assert "`x-ray` sees what `blind` sees, but of everybody, hidden or not." in text


def test_with_other_prices_of_time_cars_are_compared_at_equal_delay(tiny, tmp_path, quiet):
    plan = replace(PLAN, episodes=4, seeds=1, cars=("blind", "told"), time_weights=(1.0, 4.0))
    base = single_agent(tiny)
    page = hidden_intent(tmp_path / "out", plan, base=base, console=quiet).read_text("utf-8")
    price = {n: Run.open(tmp_path / "out/runs" / n / "seed-3").experiment.driver_weights["time"] for n in TIMED}
    own = base.driver_weights["time"]
    assert price == {"blind": own, "told": own, "blind-time-4": 4 * own, "told-time-4": 4 * own}
    street = json.loads((tmp_path / "out" / "hidden-intent.json").read_text("utf-8"))["streets"][0]
    assert [(one["of"], one["a"], one["b"], one["prices"]) for one in street["equal_delays"]] == [
        ("moving contacts %", "blind", "told", 2),
        ("serious injuries in 1,000", "blind", "told", 2),
    ]
    assert "`-time-4` stands for 4 times the recipe's price of time" in page
    assert "equally quick" in page


def test_evaluated_as_trained_alone_the_same_folder_goes_on_with_the_other_settings(tiny, tmp_path, quiet):
    plan = replace(PLAN, episodes=4, seeds=1, cars=("blind", "told"), only_as_trained=True)
    found = []
    for asked in (plan, replace(plan, only_as_trained=False)):
        hidden_intent(tmp_path / "out", asked, base=single_agent(tiny), console=quiet)
        found.append(json.loads((tmp_path / "out" / "hidden-intent.json").read_text("utf-8"))["streets"])
    (alone,), both = found
    assert [one["setting"] for one in both] == ["jaywalk multiplier 0.25", "jaywalk multiplier 1"]
    assert alone == both[0]


def test_pace_that_tells_is_there_in_trainings_and_evaluations(tiny, tmp_path, quiet):
    plan = replace(PLAN, episodes=4, seeds=1, cars=("blind", "told"), pace_correlation=0.9)
    page = hidden_intent(tmp_path / "out", plan, base=single_agent(tiny), console=quiet).read_text("utf-8")
    for name in plan.cars:
        assert Run.open(tmp_path / "out/runs" / name / "seed-3").experiment.sim.pace_correlation == 0.9
    streets = json.loads((tmp_path / "out" / "hidden-intent.json").read_text("utf-8"))["streets"]
    assert [one["street"]["sim"]["pace_correlation"] for one in streets] == [0.9, 0.9]
    assert "People's pace tells of their tendency (`pace_correlation` 0.9)" in page
