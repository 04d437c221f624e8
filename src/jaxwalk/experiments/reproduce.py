"""Reproduce the paper's whole experiment as a plain list of parts. A part whose file exists is not made again.

runs/co-trained/seed-0, ...      the trainings of car and pedestrians, one for each training seed
runs/single-agent/seed-0, ...    the trainings of the car alone, with equally many updates
plan.json                        what was requested
results.json, episodes.csv       every driver among every population (`jaxwalk.experiments.tournament`)
ablation.json                    the co-trained drivers with less and more jaywalking
gallery.json                     the worst collisions and the nearest misses, to watch
episode.png, episode.svg, .json   one episode
provenance.json, minutes.json    commit, hardware, versions; how long each part took
report.html, figures/, tables/   `jaxwalk.report`
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from rich.console import Console

from jaxwalk.evaluation import evaluate, write_rows
from jaxwalk.evaluation.document_parts import Provenance
from jaxwalk.evaluation.reading import Origin, as_document, as_results
from jaxwalk.experiments.curves import learning_curve
from jaxwalk.experiments.tournament import Scenarios, TrainedPolicies, ablation, load_trained, tournament
from jaxwalk.exports.drawn_episode import draw_episode
from jaxwalk.exports.gallery import Cast, gallery
from jaxwalk.interfaces import Policy
from jaxwalk.metrics import ENCOUNTERS, OUTCOMES
from jaxwalk.recipes import LONGEST, RECIPES, Experiment, single_agent, with_training
from jaxwalk.report import (
    ALWAYS_GO,
    CO_TRAINED,
    LEARNED,
    ROUTE_FOLLOWER,
    SINGLE_AGENT,
    DrawnEpisode,
    Gallery,
    LearningCurve,
    Material,
    Trainings,
    write_report,
)
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.effort import Effort
from jaxwalk.runs.folder import Run, RunError
from jaxwalk.runs.provenance import provenance
from jaxwalk.runs.study import Work, read_json, run_folder
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.crossing_kind import JAYWALK
from jaxwalk.sim.environment import Street
from jaxwalk.writing import together

ABLATED = 2000
"""Most scenarios of the ablation, which has ten cells for each training seed."""
WATCHED, INCIDENTS = 500, 20
"""The gallery searches this many scenarios, and has this many incidents of each kind per driver and population."""
INTERESTING = 200
"""Number of scenarios from which the episode to draw is chosen."""


@dataclass(frozen=True)
class Plan(Effort):
    """What to reproduce, and at what size."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    recipe: str = "fast"
    """Recipe of all trainings."""
    minutes: float = 4.0
    """Duration of the first co-training [min]; all others make as many updates. Ignored if ``updates`` is given."""

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible plan."""
        super().__post_init__()
        if not 0 < self.minutes <= LONGEST:
            raise ValueError(f"minutes must be above 0 and at most {LONGEST:,}, not {self.minutes:g}")
        if self.recipe not in RECIPES:
            raise ValueError(f"recipe must be one of {', '.join(RECIPES)}, not {self.recipe}")


class Reproduction(Work[Plan]):
    """The paper's experiment in a folder."""

    command = "reproduce"


def reproduce(folder: Path, plan: Plan, *, console: Console | None = None, base: Experiment | None = None) -> Path:
    """Make whatever is missing in the folder; return the report's path. Raise Interrupted on Ctrl-C.

    ``base``: what to train instead of the plan's recipe.
    """
    work = Reproduction(folder, plan, console or Console(stderr=True), base or RECIPES[plan.recipe])
    work.do(
        [
            ("co-training car and pedestrians", _co_train),
            ("training the car alone", _train_alone),
            ("every driver among every population", _evaluate),
            ("less and more jaywalking", _ablate),
            ("collecting collisions and near misses", _collect),
            ("drawing an episode", _draw),
            ("report", _report),
        ]
    )
    return folder / "report.html"


def _co_train(work: Reproduction) -> None:
    """Train the first seed by minutes or updates, and the others with as many updates as the first one made."""
    plan = work.plan
    first = with_training(work.base, updates=plan.updates)
    work.train(CO_TRAINED, first if plan.updates else replace(first, minutes=plan.minutes), plan.seed)
    for seed in plan.training_seeds[1:]:
        work.train(CO_TRAINED, with_training(work.base, updates=_made(work)), seed)


def _train_alone(work: Reproduction) -> None:
    """Train the car alone, with as many updates as the co-trainings made."""
    for seed in work.plan.training_seeds:
        work.train(SINGLE_AGENT, with_training(single_agent(work.base), updates=_made(work)), seed)


def _made(work: Reproduction) -> int:
    """Return the number of updates of the first co-training."""
    return Run.open(work.run(CO_TRAINED, work.plan.seed)).experiment.train.updates


def _trained(work: Reproduction, street: Street, seed: int) -> TrainedPolicies:
    return load_trained(street, seed, {name: work.run(name, seed) for name in (SINGLE_AGENT, CO_TRAINED)})


def _evaluate(work: Reproduction) -> None:
    if work.done("results.json"):
        return
    street, scenarios = work.street(), Scenarios(work.plan.episodes, work.plan.seed)
    trained = [_trained(work, street, seed) for seed in work.plan.training_seeds]
    results, matches = tournament(street, trained, scenarios, work.say)
    names = ("driver", "pedestrians", "training_seed")
    write_rows(work.folder / "episodes.csv", [(*m.names, m.cell.training_seed, m.rows) for m in matches], names=names)
    work.keep("results.json", results.as_dict())


def _ablate(work: Reproduction) -> None:
    if work.done("ablation.json"):
        return
    street, scenarios = work.street(), Scenarios(min(ABLATED, work.plan.episodes), work.plan.seed)
    trained = [_trained(work, street, seed) for seed in work.plan.training_seeds]
    work.keep("ablation.json", ablation(street, trained, scenarios, work.say).as_dict())


def _collect(work: Reproduction) -> None:
    """Collect the worst failures of the first training seed's drivers, and of the driver that ignores people."""
    if work.done("gallery.json"):
        return
    street, seed = work.street(), work.plan.seed
    trained = _trained(work, street, seed)
    blind = {ROUTE_FOLLOWER: contestant(street, "driver", ROUTE_FOLLOWER)}
    people = {ALWAYS_GO: contestant(street, "pedestrian", ALWAYS_GO), LEARNED: trained.learned}
    cast = Cast(street, {**trained.drivers, **blind}, people, seed)
    source = Drawn(street, seed, min(WATCHED, work.plan.episodes))
    played = {
        (driver, crowd): evaluate(street, {"driver": policy, "pedestrian": among}, source)
        for driver, policy in cast.drivers.items()
        for crowd, among in cast.populations.items()
    }
    work.keep("gallery.json", gallery(cast, played, most=INCIDENTS, say=work.say).as_dict())


def _draw(work: Reproduction) -> None:
    """Draw the scenario in which the first training seed's car came nearest to a jaywalker and still arrived."""
    if (work.folder / "episode.json").is_file():
        return
    street, seed = work.street(), work.plan.seed
    trained = _trained(work, street, seed)
    driver = trained.drivers[CO_TRAINED]
    scenario, frame = _interesting(work, street, driver, trained.learned)
    for kind in ("png", "svg"):
        file = work.folder / f"episode.{kind}"
        policies = {"driver": driver, "pedestrian": trained.learned}
        time = frame * street.world.rules.dt
        draw_episode(street, policies, Drawn(street, seed), scenario, file, time=time)
    drawn = DrawnEpisode(scenario=scenario, seed=seed, training_seed=seed, frame=frame)
    work.keep("episode.json", asdict(drawn))


def _interesting(work: Reproduction, street: Street, driver: Policy, people: Policy) -> tuple[int, int]:
    """Return the scenario with the nearest encounter with a jaywalker without a touch, and the frame of its start."""
    source = Drawn(street, work.plan.seed, min(INTERESTING, work.plan.episodes))
    rows = evaluate(street, {"driver": driver, "pedestrian": people}, source)
    found, reached = rows[ENCOUNTERS], rows[OUTCOMES].goal
    fit = [i for i in range(len(found.type)) if found.type[i] == JAYWALK and reached[found.episode[i]]]
    if not fit:
        return 0, 0
    best = min(fit, key=lambda i: (found.min_gap[i] == 0, found.min_gap[i]))
    return int(found.scenario[best]), int(found.start[best])


def _report(work: Reproduction) -> None:
    work.keep("provenance.json", asdict(provenance()))
    report(work.folder)


def report(folder: Path) -> Path:
    """Make the report of a folder from its files; return the report's path.

    Raises:
        RunError: a file is missing, or the plan or a run is damaged.
        DocumentError: another file is damaged.
        ReportError: the results lack a driver, a population or a training seed.
    """
    contents = {name: read_json(folder / f"{name}.json", Reproduction.command) for name in _PARTS}
    missing = [name for name, content in contents.items() if content is None]
    if missing:
        raise RunError(f"{folder}: has no {missing[0]}.json; make it with: jaxwalk reproduce --out {folder}")
    plan = _plan(contents["plan"], folder / "plan.json")
    with together():
        return write_report(folder, _material(folder, contents, plan))


def _material(folder: Path, contents: Mapping[str, Any], plan: Plan) -> Material:
    """Return the typed material of a report from the contents of the folder's files."""
    origins = {name: _origin(folder / f"{name}.json") for name in _PARTS}
    drawing = folder / "episode.svg"
    return Material(
        results=as_results(contents["results"], origins["results"]),
        ablation=as_results(contents["ablation"], origins["ablation"]),
        provenance=as_document(Provenance, contents["provenance"], origins["provenance"]),
        minutes=as_document(dict[str, float], contents["minutes"], origins["minutes"]),
        gallery=as_document(Gallery, contents["gallery"], origins["gallery"]),
        episode=as_document(DrawnEpisode, contents["episode"], origins["episode"]),
        episode_svg=drawing.read_text(encoding="utf-8", errors="replace") if drawing.is_file() else None,
        trainings=Trainings(plan.recipe, tuple(plan.training_seeds)),
        curves={name: _curves(folder, name, plan) for name in (CO_TRAINED, SINGLE_AGENT)},
    )


def _origin(file: Path) -> Origin:
    return Origin(file, f"delete it and run `jaxwalk {Reproduction.command}` again")


def _plan(content: Any, file: Path) -> Plan:
    """Return the plan. Raise DocumentError if it is damaged, RunError if another version wrote it."""
    plan = as_document(Plan, content, Origin(file, "run `jaxwalk reproduce` in another folder"))
    if asdict(plan) != content:
        raise RunError(f"{file}: of another version of jaxwalk; run `jaxwalk reproduce` in another folder")
    return plan


def _curves(folder: Path, name: str, plan: Plan) -> dict[int, LearningCurve]:
    """Return the trainings of a driver by training seed. Raise RunError unless they have equally many updates."""
    runs = {seed: Run.open(run_folder(folder, name, seed)) for seed in plan.training_seeds}
    curves = {seed: learning_curve(run) for seed, run in runs.items()}
    for seed, curve in curves.items():
        if len(curve.steps) != len(curves[plan.seed].steps):
            raise RunError(f"{runs[seed].path}: has fewer or more updates than seed {plan.seed}; copy the folder again")
    return curves


_PARTS = ("plan", "results", "ablation", "provenance", "minutes", "gallery", "episode")
"""Documents from which the report is made."""
