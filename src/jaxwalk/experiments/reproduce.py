"""The paper's whole experiment as a plain list of parts. A part whose file is there is not made again.

runs/co-trained/seed-0, ...      the trainings of car and pedestrians, one for each training seed
runs/single-agent/seed-0, ...    those of the car alone, with equally many updates
plan.json                        what was asked for
results.json, episodes.csv       every driver among every population (`jaxwalk.experiments.tournament`)
ablation.json                    the co-trained drivers with less and more jaywalking
episode.png, episode.svg, .json   one episode
provenance.json, minutes.json    commit, hardware, versions; how long each part took
report.html, figures/, tables/   `jaxwalk.report`
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from jaxwalk.evaluation import write_rows
from jaxwalk.experiments.episodes import draw_episode
from jaxwalk.experiments.provenance import provenance
from jaxwalk.experiments.recipes import RECIPES, Experiment, single_agent, with_training
from jaxwalk.experiments.runs import Run, RunError, check_writable, write_whole
from jaxwalk.experiments.tournament import Scenarios, Trained, ablation, load_trained, tournament
from jaxwalk.experiments.training import train
from jaxwalk.interfaces import Policy
from jaxwalk.report import CO_TRAINED, SINGLE_AGENT, write_report
from jaxwalk.sim.environment import Street

ABLATED = 2000
"""The ablation, which has ten cells for each training seed, takes at most so many scenarios."""
INTERESTING = 200
"""The episode to be drawn is chosen among so many scenarios."""


class Interrupted(Exception):
    """Ctrl-C: what is finished stays."""


@dataclass(frozen=True)
class Plan:
    """What to reproduce, and how thoroughly."""

    recipe: str = "fast"
    """Of all trainings."""
    minutes: float = 4.0
    """For the first co-training [min]; all others make as many updates. Ignored where ``updates`` is given."""
    updates: int | None = None
    """Updates of each training."""
    episodes: int = 1000
    """Scenarios in each cell."""
    seed: int = 0
    """Of the first trainings, and of the scenarios."""
    seeds: int = 1
    """Training seeds: ``seed``, ``seed`` + 1, ..."""

    def __post_init__(self) -> None:
        """Refuse what can't be done."""
        if not 0 < self.minutes < float("inf"):
            raise ValueError(f"minutes must be above 0, not {self.minutes}")
        if self.recipe not in RECIPES:
            raise ValueError(f"recipe must be one of {', '.join(RECIPES)}, not {self.recipe}")
        if self.updates is not None and not 1 <= self.updates < 2**31:
            raise ValueError(f"updates must lie in [1, 2^31), not {self.updates}")
        if self.episodes < 1:
            raise ValueError(f"episodes must be at least 1, not {self.episodes}")
        if self.seeds < 1:
            raise ValueError(f"seeds must be at least 1, not {self.seeds}")
        if not 0 <= self.seed < 2**31:
            raise ValueError(f"seed must lie in [0, 2^31), not {self.seed}")
        if self.seed + self.seeds > 2**31:
            raise ValueError(f"seed + seeds must be at most 2^31, not {self.seed} + {self.seeds}")

    @property
    def training_seeds(self) -> range:
        """All of them."""
        return range(self.seed, self.seed + self.seeds)


@dataclass(frozen=True)
class Reproduction:
    """A folder, a plan, and where to tell how it goes."""

    folder: Path
    plan: Plan
    console: Console
    base: Experiment
    """What all trainings start from."""

    def run(self, name: str, seed: int) -> Path:
        """Folder of a training."""
        return run_folder(self.folder, name, seed)

    def json(self, name: str) -> Any:
        """A part that is finished; None if it isn't."""
        return read_json(self.folder / name)

    def keep(self, name: str, document: Any) -> None:
        """Write a finished part."""
        write_whole(self.folder / name, json.dumps(document, indent=2, allow_nan=False) + "\n")

    def say(self, text: str) -> None:
        """Tell how it goes."""
        self.console.print(text, soft_wrap=True)


def reproduce(folder: Path, plan: Plan, *, console: Console | None = None, base: Experiment | None = None) -> Path:
    """Make whatever is missing in the folder; returns the report's path. Raises Interrupted on Ctrl-C.

    ``base``: what to train instead of the plan's recipe.
    """
    work = Reproduction(folder, plan, console or Console(stderr=True), base or RECIPES[plan.recipe])
    _begin(work)
    steps: list[tuple[str, Callable[[Reproduction], None]]] = [
        ("co-training car and pedestrians", _co_train),
        ("training the car alone", _train_alone),
        ("every driver among every population", _evaluate),
        ("less and more jaywalking", _ablate),
        ("drawing an episode", _draw),
        ("report", _report),
    ]
    for number, (name, step) in enumerate(steps, 1):
        work.say(f"[{number}/{len(steps)}] {name}")
        begun = time.monotonic()
        try:
            step(work)
        finally:
            _count_minutes(work, step.__name__.strip("_"), time.monotonic() - begun)
    return folder / "report.html"


def run_folder(folder: Path, name: str, seed: int) -> Path:
    """Where a training is kept in a folder of `jaxwalk reproduce`."""
    return folder / "runs" / name / f"seed-{seed}"


def read_json(path: Path) -> Any:
    """The document of a file; None if there is no file."""
    if not path.is_file():
        return None
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise RunError(f"{path}: damaged ({error}); delete it and run `jaxwalk reproduce` again") from error


def _begin(work: Reproduction) -> None:
    """Make the folder, or see that it was made for the same plan."""
    asked, there = asdict(work.plan), work.json("plan.json")
    folder = work.folder
    if there is None and folder.is_dir() and any(folder.iterdir()):
        raise RunError(f"{folder}: the folder is not empty and no `jaxwalk reproduce` made it; name another one")
    if there is not None and there != asked:
        name = next((n for n in asked if not isinstance(there, dict) or there.get(n) != asked[n]), "plan")
        raise RunError(
            f"{folder}: was begun with another value of {name}; ask for the same again, or name another folder"
        )
    check_writable(folder)
    folder.mkdir(parents=True, exist_ok=True)
    work.keep("plan.json", asked)


def _co_train(work: Reproduction) -> None:
    """The first by minutes or updates, the others with as many updates as the first one made."""
    plan = work.plan
    first = with_training(work.base, updates=plan.updates)
    _train(work, CO_TRAINED, first, plan.seed, None if plan.updates else plan.minutes)
    for seed in plan.training_seeds[1:]:
        _train(work, CO_TRAINED, with_training(work.base, updates=_made(work)), seed, None)


def _train_alone(work: Reproduction) -> None:
    """As many updates as the co-trainings made."""
    for seed in work.plan.training_seeds:
        _train(work, SINGLE_AGENT, with_training(single_agent(work.base), updates=_made(work)), seed, None)


def _made(work: Reproduction) -> int:
    """Updates of the first co-training."""
    return Run.open(work.run(CO_TRAINED, work.plan.seed)).experiment.train.updates


def _train(work: Reproduction, name: str, experiment: Experiment, seed: int, minutes: float | None) -> None:
    folder, said = work.run(name, seed), f"    {name}, seed {seed}"
    begun = (folder / "config.json").is_file()
    run = Run.open(folder) if begun else Run.create(folder, replace(experiment, seed=seed))
    lines = run.metrics()
    if lines and lines[-1]["update"] >= run.experiment.train.updates and run.policy.is_file():
        work.say(f"{said}: there already, {lines[-1]['steps']:,} steps")
        return
    resume = begun and run.checkpoints.is_dir()
    trained = train(run, minutes=None if resume else minutes, resume=begun, console=work.console, name=said)
    if trained.interrupted:
        raise Interrupted
    work.say(f"{said}: {trained.steps:,} steps in {trained.seconds / 60:.1f} minutes")


def _street(work: Reproduction) -> Street:
    return Street.create(work.base.maps, work.base.sim, jaywalk_multiplier=work.base.jaywalk_multiplier)


def _trained(work: Reproduction, street: Street, seed: int) -> Trained:
    return load_trained(street, seed, {name: work.run(name, seed) for name in (SINGLE_AGENT, CO_TRAINED)})


def _evaluate(work: Reproduction) -> None:
    if work.json("results.json") is not None:
        work.say("    there already")
        return
    street, scenarios = _street(work), Scenarios(work.plan.episodes, work.plan.seed)
    trained = [_trained(work, street, seed) for seed in work.plan.training_seeds]
    document, matches = tournament(street, trained, scenarios, work.say)
    names = ("driver", "pedestrians", "training_seed")
    write_rows(work.folder / "episodes.csv", [(*m.names, m.training_seed, m.rows) for m in matches], names=names)
    work.keep("results.json", document)


def _ablate(work: Reproduction) -> None:
    if work.json("ablation.json") is not None:
        work.say("    there already")
        return
    street, scenarios = _street(work), Scenarios(min(ABLATED, work.plan.episodes), work.plan.seed)
    trained = [_trained(work, street, seed) for seed in work.plan.training_seeds]
    work.keep("ablation.json", ablation(street, trained, scenarios, work.say))


def _draw(work: Reproduction) -> None:
    """Of the first training seed: the scenario in which the car came nearest to a jaywalker and still arrived."""
    if (work.folder / "episode.json").is_file():
        return
    street, seed = _street(work), work.plan.seed
    trained = _trained(work, street, seed)
    driver = trained.drivers[CO_TRAINED]
    scenario, frame = _interesting(work, street, driver, trained.learned)
    for kind in ("png", "svg"):
        file = work.folder / f"episode.{kind}"
        draw_episode(street, driver, trained.learned, file, scenario=scenario, seed=seed, frame=frame)
    work.keep("episode.json", {"scenario": scenario, "seed": seed, "training_seed": seed, "frame": frame})


def _interesting(work: Reproduction, street: Street, driver: Policy, people: Policy) -> tuple[int, int]:
    """The scenario with the encounter that came nearest without a touch to a jaywalker, and the frame it began in."""
    from jaxwalk.evaluation import evaluate
    from jaxwalk.sim.trajectory import JAYWALK

    episodes = min(INTERESTING, work.plan.episodes)
    rows = evaluate(street, driver, people, episodes=episodes, seed=work.plan.seed)
    found, reached = rows.encounters, rows.episodes.goal
    fit = [i for i in range(len(found.type)) if found.type[i] == JAYWALK and reached[found.episode[i]]]
    if not fit:
        return 0, 0
    best = min(fit, key=lambda i: found.min_distance[i])
    return int(found.scenario[best]), int(found.start[best])


def _count_minutes(work: Reproduction, name: str, seconds: float) -> None:
    """Add to what each part took, over interruptions."""
    document = work.json("minutes.json") or {}
    document[name] = round(document.get(name, 0.0) + seconds / 60, 3)
    work.keep("minutes.json", document)


def _report(work: Reproduction) -> None:
    work.keep("provenance.json", provenance())
    report(work.folder)


def report(folder: Path) -> Path:
    """Make the report of a folder from what is in it; returns its path."""
    documents = {name: read_json(folder / f"{name}.json") for name in _PARTS}
    missing = [name for name, document in documents.items() if document is None]
    if missing:
        raise RunError(f"{folder}: has no {missing[0]}.json; make it with: jaxwalk reproduce --out {folder}")
    curves = {name: _curves(folder, name, documents["plan"]) for name in (CO_TRAINED, SINGLE_AGENT)}
    drawing = folder / "episode.svg"
    documents["episode_svg"] = drawing.read_text(encoding="utf-8") if drawing.is_file() else None
    return write_report(folder, documents | {"curves": curves})


def _curves(folder: Path, name: str, plan: Any) -> dict[int, list[dict[str, Any]]]:
    """Metrics of each update, by training seed."""
    file = folder / "plan.json"
    try:
        read = Plan(**plan)
    except (TypeError, ValueError) as error:
        raise RunError(f"{file}: damaged ({error}); run `jaxwalk reproduce` in another folder") from error
    if asdict(read) != plan:
        raise RunError(f"{file}: of another version of jaxwalk; run `jaxwalk reproduce` in another folder")
    return {seed: Run.open(run_folder(folder, name, seed)).metrics() for seed in read.training_seeds}


_PARTS = ("plan", "results", "ablation", "provenance", "minutes", "episode")
"""Documents that the report is made of."""
