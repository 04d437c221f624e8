"""How much do the numbers that the paper leaves open matter? An exploratory sweep: one training each, not to the end.

runs/NAME/seed-N       the trainings: recipe ``paper``, with one free weight changed in each (`weights`)
plan.json, minutes.json    what was requested; how long each part took
paper-weights.json     each car among always-go and among its own people (`jaxwalk.evaluation.Results`)
paper-weights.md       the table (`jaxwalk.report.paper_weights_page`)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from jaxwalk.evaluation import Match
from jaxwalk.evaluation.reading import Origin, as_results
from jaxwalk.experiments.co_training import FootprintWork, cost
from jaxwalk.experiments.tournament import Round, Scenarios, play_rounds, results_of
from jaxwalk.recipes import RECIPES, Experiment, with_training
from jaxwalk.report import ALWAYS_GO, LEARNED
from jaxwalk.report.paper_weights_page import page
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.effort import Effort
from jaxwalk.writing import write_whole

CAUTION = ("crosswalk_speeding", "jaywalker_speeding")
"""The terms of the car's caution near people."""
CAUTIONS, PROGRESS = (5.0, 10.0), 2.0
"""Factors on the caution's weights, and on that of progress."""
RESULT, PAGE = "paper-weights.json", "paper-weights.md"
STEPS_PER_SECOND = 11_000.0
"""What two CPU cores manage of recipe ``paper``, for the time that is said in advance."""


@dataclass(frozen=True)
class SweepEffort(Effort):
    """The size of the sweep."""

    updates: int = 400
    episodes: int = 2000
    seed: int = 40
    seeds: int = 1


class SweepWork(FootprintWork[SweepEffort]):
    """The sweep in a folder."""

    command = "co-training --sweep"


def paper_weights(
    folder: Path, plan: SweepEffort, *, console: Console | None = None, base: Experiment | None = None
) -> Path:
    """Make whatever is missing in the folder; return the page's path. Raise Interrupted on Ctrl-C.

    ``base``: what to train instead of recipe ``paper``.
    """
    work = SweepWork(folder, plan, console or Console(stderr=True), base or RECIPES["paper"])
    work.do([("training with other weights", _train), ("each among its own people", _evaluate), ("table", _write)])
    return folder / PAGE


def weights(base: Experiment) -> dict[str, Experiment]:
    """Return the trainings by name: ``base``, and ``base`` with one weight changed that the paper doesn't state."""
    car, people = base.driver_weights, base.pedestrian_weights
    cautious = {
        f"caution-x{factor:g}": replace(base, driver_weights=car | {name: factor * car[name] for name in CAUTION})
        for factor in CAUTIONS
    }
    hasty = replace(base, driver_weights=car | {"crow_progress": PROGRESS * car["crow_progress"]})
    others = {name: weight for name, weight in people.items() if name != "waiting"}
    anywhere = replace(base, pedestrian_weights=others | {"waiting_anywhere": people["waiting"]})
    return {"as-it-is": base, **cautious, f"progress-x{PROGRESS:g}": hasty, "bonus-anywhere": anywhere}


def _train(work: SweepWork) -> None:
    plan = work.plan
    trained = [with_training(one, updates=plan.updates) for one in weights(work.base).values()] * plan.seeds
    work.say(f"    {cost(trained, 2 * len(trained) * plan.episodes, speed=STEPS_PER_SECOND)}")
    for seed in plan.training_seeds:
        for name, experiment in weights(work.base).items():
            work.train(name, with_training(experiment, updates=plan.updates), seed)


def _evaluate(work: SweepWork) -> None:
    if work.done(RESULT):
        return
    street, scenarios = work.street(), Scenarios(work.plan.episodes, work.plan.seed)
    always_go = contestant(street, "pedestrian", ALWAYS_GO)
    rounds: list[Round] = []
    for seed in work.plan.training_seeds:
        for name in weights(work.base):
            car, people = (contestant(street, role, str(work.run(name, seed))) for role in ("driver", "pedestrian"))
            rounds.append((seed, {name: car}, {ALWAYS_GO: always_go, LEARNED: people}))
    chosen, matches = play_rounds(street, rounds, scenarios, work.say)
    matches.sort(key=_place)
    work.keep(RESULT, results_of(street, chosen, matches).as_dict())


def _place(match: Match) -> bool:
    """Return what puts matches among always-go first."""
    return match.cell.pedestrians != ALWAYS_GO


def _write(work: SweepWork) -> None:
    origin = Origin(work.folder / RESULT, f"delete it and run `jaxwalk {work.command}` again")
    results = as_results(work.json(RESULT), origin)
    write_whole(work.folder / PAGE, page(results, updates=work.plan.updates, planned=work.base.train.updates))
