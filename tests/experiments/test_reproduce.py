"""The whole experiment with two training seeds, very small: what is made, from what, and that it goes on."""

import csv
import io
import json
from dataclasses import replace
from functools import partial

import pytest
from rich.console import Console

from jaxwalk.evaluation import evaluate, evaluate_grid, replay
from jaxwalk.evaluation.reading import DocumentError
from jaxwalk.experiments import reproduce as module
from jaxwalk.experiments import tournament, two_outcomes
from jaxwalk.experiments.reproduce import Plan, report, reproduce
from jaxwalk.policies import AlwaysGo, ConstantSpeed, read_metadata
from jaxwalk.runs import study
from jaxwalk.runs.folder import Run, RunError
from jaxwalk.runs.session import Session
from jaxwalk.runs.study import Interrupted
from jaxwalk.runs.training import TrainingEnd

PLAN = Plan(updates=3, episodes=8, seed=3, seeds=2)


@pytest.fixture(scope="module")
def made(tiny, tmp_path_factory):
    """The folder of two training seeds, interrupted in the second co-training; and what was said."""
    folder, said = tmp_path_factory.mktemp("reproduce") / "out", io.StringIO()
    again = partial(reproduce, folder, PLAN, base=tiny, console=Console(file=said, width=200))
    with pytest.MonkeyPatch.context() as patch:
        _play_little(patch)
        _interrupt_second(patch)
        with pytest.raises(Interrupted):
            again()
        patch.setattr(Session, "record", _RECORD)
        again()
    return folder, said.getvalue()


_RECORD = Session.record
RULES = ["random", "route-follower"]
MULTIPLIERS = (0.25, 1.0)


def _play_little(patch):
    """Two rules, two multipliers, and no more episodes at once than there are."""
    patch.setattr(tournament, "COMPARED", RULES)
    patch.setattr(tournament, "MULTIPLIERS", MULTIPLIERS)
    patch.setattr(tournament, "evaluate_grid", partial(evaluate_grid, batch=PLAN.episodes))
    for place in (module, two_outcomes):
        patch.setattr(place, "evaluate", partial(evaluate, batch=PLAN.episodes))
    patch.setattr("jaxwalk.evaluation.batches.BATCH", PLAN.episodes)
    for place in ("drawn_episode", "gallery", "replays"):
        patch.setattr(f"jaxwalk.exports.{place}.replay", partial(replay, batch=PLAN.episodes))


def _interrupt_second(patch):
    """Ctrl-C in the first update of the second training."""

    def record(self, *update):
        _RECORD(self, *update)
        self.stop.requested |= self.run.path.name == "seed-4"

    patch.setattr(Session, "record", record)


def _json(folder, name):
    return json.loads((folder / name).read_text(encoding="utf-8"))


@pytest.mark.long
def test_a_training_for_each_seed_and_driver(made):
    folder, said = made
    both = ("co-trained", "single-agent")
    for name in both:
        runs = sorted((folder / "runs" / name).iterdir())
        assert [run.name for run in runs] == ["seed-3", "seed-4"]
        for run, seed in zip(runs, PLAN.training_seeds, strict=True):
            metadata = read_metadata(Run.open(run).policy)
            assert (metadata["seed"], metadata["single_agent"]) == (seed, name == "single-agent")
            assert [line["update"] for line in Run.open(run).metrics()] == [1, 2, 3]
    steps = {name: 3 * Run.open(folder / "runs" / name / "seed-4").experiment.steps_per_update for name in both}
    assert f"co-trained, seed 3: there already, {steps['co-trained']:,} steps" in said
    assert f"single-agent, seed 4: {steps['single-agent']:,} steps" in said


@pytest.mark.long
def test_every_cell_once_for_each_seed(made):
    folder, said = made
    rules, trained = RULES, ["single-agent", "co-trained"]
    among = (("always-go", None), ("learned", 3), ("learned", 4), ("gap-acceptance", None))
    expected = [(d, p, s) for d in rules for p, s in among]
    expected += [(d, p, s) for d in trained for p in ("always-go", "learned", "gap-acceptance") for s in (3, 4)]
    document = _json(folder, "results.json")
    assert [(c["driver"], c["pedestrians"], c["training_seed"]) for c in document["cells"]] == expected
    assert document["scenarios"]["seed"] == 3
    over = [(found["driver"], found["pedestrians"], found["training_seeds"]) for found in document["over_seeds"]]
    assert over[:2] == [("random", "always-go", [None]), ("random", "learned", [3, 4])]
    assert over[-3:] == [("co-trained", p, [3, 4]) for p in ("always-go", "learned", "gap-acceptance")]
    with (folder / "episodes.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    found = dict.fromkeys((row["driver"], row["pedestrians"], row["training_seed"]) for row in rows)
    assert list(found) == [(d, p, "" if s is None else str(s)) for d, p, s in expected]
    assert len(rows) == 8 * len(expected)
    assert "co-trained among learned, seed 4: 8 episodes" in said
    assert "random among always-go: 8 episodes" in said


@pytest.mark.long
def test_each_seed_has_its_own_policies(made):
    cells = _json(made[0], "results.json")["cells"]
    found = {tuple(cell.values())[:3]: list(cell.values())[3:] for cell in cells}
    for driver in ("co-trained", "single-agent"):
        assert found[driver, "always-go", 3] != found[driver, "always-go", 4]


def test_everybody_meets_the_pedestrians_of_the_seed(street, monkeypatch):
    rounds = []

    def play(street, found, scenarios, say):
        rounds.extend(found)
        raise Interrupted

    monkeypatch.setattr(tournament, "play_rounds", play)
    people = {seed: AlwaysGo() for seed in (3, 4)}
    cars = {seed: {"single-agent": ConstantSpeed(), "co-trained": ConstantSpeed()} for seed in people}
    trained = [tournament.TrainedPolicies(seed, cars[seed], people[seed]) for seed in people]
    for play_all in (tournament.tournament, tournament.ablation):
        with pytest.raises(Interrupted):
            play_all(street, trained, tournament.Scenarios(8, 0), print)
    assert [(seed, list(drivers), list(among)) for seed, drivers, among in rounds] == [
        (None, tournament.COMPARED, ["always-go", "gap-acceptance"]),
        (3, tournament.COMPARED, ["learned"]),
        (3, ["single-agent", "co-trained"], ["always-go", "gap-acceptance", "learned"]),
        (4, tournament.COMPARED, ["learned"]),
        (4, ["single-agent", "co-trained"], ["always-go", "gap-acceptance", "learned"]),
        (3, ["co-trained"], ["always-go", "learned"]),
        (4, ["co-trained"], ["always-go", "learned"]),
    ]
    for seed, drivers, among in rounds:
        assert "learned" not in among or among["learned"] is people[seed]
        assert "co-trained" not in drivers or drivers["co-trained"] is cars[seed]["co-trained"]


@pytest.mark.long
def test_pairs(made):
    pairs = _json(made[0], "results.json")["paired"]
    names = [(p["ending"], *(tuple(p[side].values())[:2] for side in ("a", "b"))) for p in pairs]
    drivers = [*RULES, "single-agent", "co-trained"]
    assert names[:-2] == [("collision", (d, "always-go"), (d, "learned")) for d in drivers]
    assert names[-2:] == [
        (e, ("single-agent", "always-go"), ("co-trained", "always-go")) for e in ("collision", "goal")
    ]
    assert {(p["training_seeds"], p["pairs"]) for p in pairs} == {(2, 16)}


@pytest.mark.long
def test_the_ablation_has_every_seed(made):
    document = _json(made[0], "ablation.json")
    cells = [(c["jaywalk_multiplier"], c["pedestrians"], c["training_seed"]) for c in document["cells"]]
    assert cells == [(m, p, s) for m in MULTIPLIERS for p in ("always-go", "learned") for s in (3, 4)]
    assert [found["training_seeds"] for found in document["over_seeds"]] == [[3, 4]] * 4


@pytest.mark.long
def test_what_the_first_seed_did_worst_can_be_watched(made):
    folder = made[0]
    gallery = json.loads((folder / "gallery.json").read_text())
    drivers = {(one["driver"], one["pedestrians"]) for one in gallery["episodes"]}
    cars = ("single-agent", "co-trained", "route-follower")
    assert drivers == {(car, people) for car in cars for people in ("always-go", "learned")}
    assert any(one["kind"] == "collision" for one in gallery["incidents"])
    assert '<dialog class="watch"' in (folder / "report.html").read_text(encoding="utf-8")


@pytest.mark.long
def test_what_is_there_is_not_made_again(made, tiny):
    folder, _ = made
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*.json") if path.parent.name != "tables"}
    said = io.StringIO()
    reproduce(folder, PLAN, base=tiny, console=Console(file=said, width=200))
    changed = {path.name for path, written in before.items() if path.stat().st_mtime_ns != written}
    assert changed <= {"plan.json", "provenance.json", "minutes.json"}
    assert said.getvalue().count("there already") >= 3


@pytest.mark.long
def test_the_report_can_be_made_again(made):
    folder, _ = made
    (folder / "report.html").unlink()
    table = (folder / "tables" / "training_seeds.csv").read_bytes()
    assert "2 training seeds, 3 to 4" in report(folder).read_text(encoding="utf-8")
    assert (folder / "tables" / "training_seeds.csv").read_bytes() == table


@pytest.mark.parametrize(
    ("plan", "message"),
    [
        ({"seed": 0, "updates": 3}, "of another version"),
        ({"seeds": 0}, r"damaged .seeds must lie in \[1, 1,000\], not 0."),
        ({"sed": 1}, "damaged"),
        ([], "damaged"),
    ],
)
def test_a_report_needs_a_whole_plan(plan, message, tmp_path):
    for name in ("results", "ablation", "provenance", "minutes", "gallery", "episode"):
        (tmp_path / f"{name}.json").write_text("{}")
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    with pytest.raises((RunError, DocumentError), match=f"plan.json: {message}"):
        report(tmp_path)


@pytest.mark.long
def test_another_number_of_seeds_needs_another_folder(made, tiny, quiet):
    with pytest.raises(RunError, match="was begun with another value of seeds"):
        reproduce(made[0], replace(PLAN, seeds=3), base=tiny, console=quiet)


def test_later_co_trainings_are_as_long_as_the_first(tiny, tmp_path, quiet, monkeypatch):
    """The minutes are for the first one alone: the number that it planned is asked of the others."""
    asked = []

    def train(run, *, resume, display):
        minutes = run.experiment.minutes
        if minutes is not None:
            run.describe(replace(module.with_training(run.experiment, updates=17), minutes=None))
        asked.append((display.name.strip(), minutes, run.experiment.train.updates, run.experiment.seed))
        return TrainingEnd(1, 1, 1.0, False)

    monkeypatch.setattr(study, "train_in", train)
    work = module.Reproduction(tmp_path, Plan(minutes=5.0, seeds=3), quiet, tiny)
    module._co_train(work)
    module._train_alone(work)
    assert asked == [("co-trained, seed 0", 5.0, 17, 0)] + [
        (f"{name}, seed {seed}", None, 17, seed)
        for name, seeds in (("co-trained", (1, 2)), ("single-agent", (0, 1, 2)))
        for seed in seeds
    ]
