"""Reproduce the paper's whole experiment as a plain list of parts. A part whose file exists is not made again.

runs/co-trained/seed-0, ...      the trainings of car and pedestrians, one for each training seed
runs/single-agent/seed-0, ...    the trainings of the car alone, with equally many updates
plan.json                        what was requested
results.json, episodes.csv       every driver among every population (`jaxwalk.experiments.tournament`)
ablation.json                    the co-trained drivers with less and more jaywalking
gallery.json                     the worst collisions and the nearest misses, to watch
episode.png, episode.svg, .json  a jaywalker avoided (the paper's figure 1b)
collision.png, .svg, .json       a jaywalker hit (figure 1a); none if nobody was
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
from jaxwalk.evaluation.reading import Origin, as_document, as_results
from jaxwalk.experiments.curves import learning_curve
from jaxwalk.experiments.tournament import Scenarios, TrainedPolicies, ablation, load_trained, tournament
from jaxwalk.experiments.two_outcomes import two_outcomes
from jaxwalk.exports.drawn_episode import draw_episode
from jaxwalk.exports.gallery import Cast, gallery
from jaxwalk.provenance import Provenance, provenance
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
from jaxwalk.runs.study import Work, read_json, run_folder
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.writing import together

ABLATED = 2000
"""Most scenarios of the ablation, which has ten cells for each training seed."""
WATCHED, INCIDENTS = 300, 20
"""The gallery searches this many scenarios, and has this many incidents of each kind per driver and population."""


@dataclass(frozen=True)
class Plan(Effort):
    """What to reproduce, and at what size."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    recipe: str = "fast"
    """Recipe of all trainings."""
    minutes: float = 3.0
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
            ("drawing a collision and an avoidance", _draw),
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
    cast = _cast(work, street)
    source = Drawn(street, seed, min(WATCHED, work.plan.episodes))
    played = {
        (driver, crowd): evaluate(street, {"driver": policy, "pedestrian": among}, source)
        for driver, policy in cast.drivers.items()
        for crowd, among in cast.populations.items()
    }
    work.keep("gallery.json", gallery(cast, played, most=INCIDENTS, say=work.say).as_dict())


def _cast(work: Reproduction, street: Street) -> Cast:
    """Return the first training seed's drivers and the one that ignores people, and both populations."""
    seed = work.plan.seed
    trained = _trained(work, street, seed)
    blind = {ROUTE_FOLLOWER: contestant(street, "driver", ROUTE_FOLLOWER)}
    people = {ALWAYS_GO: contestant(street, "pedestrian", ALWAYS_GO), LEARNED: trained.learned}
    return Cast(street, {**trained.drivers, **blind}, people, seed)


def _draw(work: Reproduction) -> None:
    """Draw a collision with a jaywalker, if there was one, and an avoidance (`jaxwalk.experiments.two_outcomes`)."""
    if (work.folder / "episode.json").is_file():
        return
    cast, plan = _cast(work, work.street()), work.plan
    watched = as_document(Gallery, work.json("gallery.json"), _origin(work.folder / "gallery.json"))
    chosen = two_outcomes(cast, watched, episodes=plan.episodes, training_seed=plan.seed)
    for name, drawn in chosen.items():
        policies = {"driver": cast.drivers[drawn.driver], "pedestrian": cast.populations[drawn.pedestrians]}
        for kind in ("png", "svg"):
            time, file = drawn.frame * cast.street.world.rules.dt, work.folder / f"{name}.{kind}"
            draw_episode(cast.street, policies, Drawn(cast.street, drawn.seed), drawn.scenario, file, time=time)
        work.keep(f"{name}.json", asdict(drawn))


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
    collision = read_json(folder / "collision.json", Reproduction.command)
    return Material(
        results=as_results(contents["results"], origins["results"]),
        ablation=as_results(contents["ablation"], origins["ablation"]),
        provenance=as_document(Provenance, contents["provenance"], origins["provenance"]),
        minutes=as_document(dict[str, float], contents["minutes"], origins["minutes"]),
        gallery=as_document(Gallery, contents["gallery"], origins["gallery"]),
        episode=as_document(DrawnEpisode, contents["episode"], origins["episode"]),
        episode_svg=_drawing(folder / "episode.svg"),
        collision=collision and as_document(DrawnEpisode, collision, _origin(folder / "collision.json")),
        collision_svg=_drawing(folder / "collision.svg"),
        trainings=Trainings(plan.recipe, tuple(plan.training_seeds)),
        curves={name: _curves(folder, name, plan) for name in (CO_TRAINED, SINGLE_AGENT)},
    )


def _drawing(file: Path) -> str | None:
    return file.read_text(encoding="utf-8", errors="replace") if file.is_file() else None


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
