"""Does learning with limits of costs make a car whose worst contacts are slower?

runs/NAME/seed-N       the trainings: the three of `trainings`, with every training seed
plan.json, minutes.json    what was requested; how long each part took
risk-aware.json        all of them and the clearance rule on the same scenarios (`jaxwalk.report.risk_document`)
risk-aware.md          the answer and its tables (`jaxwalk.report.risk_page`)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from jaxwalk.evaluation import paired_delay, paired_over_seeds
from jaxwalk.evaluation.harm_numbers import Harm, paired_harm, seed_harms
from jaxwalk.evaluation.reading import Origin
from jaxwalk.evaluation.training_seeds import Ending
from jaxwalk.experiments.co_training import cost
from jaxwalk.experiments.tournament import Round, Scenarios, play_rounds, results_of
from jaxwalk.recipes import (
    BLIND_CORNER,
    BLIND_CORNER_CVAR,
    BLIND_CORNER_LAGRANGIAN,
    Experiment,
    with_limits,
    with_training,
)
from jaxwalk.report import ALWAYS_GO, CLEARANCE
from jaxwalk.report.risk_document import LimitKept, RiskDocument, as_risk_document
from jaxwalk.report.risk_page import CVAR, LAGRANGIAN, PLAIN, page
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.effort import Effort
from jaxwalk.runs.folder import Run
from jaxwalk.runs.study import Work
from jaxwalk.sim.environment import Street
from jaxwalk.sim.suites import SUITES
from jaxwalk.writing import write_whole

LIMITED = {LAGRANGIAN: BLIND_CORNER_LAGRANGIAN, CVAR: BLIND_CORNER_CVAR}
"""The recipes with limits, by the names of their trainings."""
COMPARED: tuple[Ending, ...] = ("moving contact", "goal")
"""How episodes end that are compared, beside the worst contacts and the delay."""
WORST: Harm = "worst hundredth"
"""The number that the limits are to lower."""
RESULT, PAGE = "risk-aware.json", "risk-aware.md"
LAST = 50
"""Updates at the end of a training over which the costs that it reached are averaged."""
STEPS_PER_SECOND = 21_000.0
"""What two cores manage (AMD EPYC, all trainings of the published study, with what is compiled), for the time that is
said in advance."""


@dataclass(frozen=True)
class RiskEffort(Effort):
    """The size of the study."""

    updates: int = 200
    episodes: int = 4000
    seed: int = 90
    seeds: int = 5


class RiskWork(Work[RiskEffort]):
    """The study in a folder."""

    command = "risk-aware"

    def street(self) -> Street:
        """Return the street to evaluate on: the suite ``blind-corner``, whose streets no training has."""
        where = SUITES[BLIND_CORNER.recipe]
        if self.base.maps != BLIND_CORNER.maps:
            return super().street()
        return Street.create(where.maps, replace(self.base.sim, pedestrians=where.people or self.base.sim.pedestrians))


def risk_aware(
    folder: Path, plan: RiskEffort, *, console: Console | None = None, base: Experiment = BLIND_CORNER
) -> Path:
    """Make whatever is missing in the folder; return the page's path. Raise Interrupted on Ctrl-C.

    ``base``: what to train instead of recipe ``blind-corner``, without and with the limits of its variants.
    """
    work = RiskWork(folder, plan, console or Console(stderr=True), base)
    work.do(
        [
            ("training without and with limits", _train),
            ("all of them and the clearance rule on the same scenarios", _evaluate),
            ("tables", _write),
        ]
    )
    return folder / PAGE


def trainings(base: Experiment) -> dict[str, Experiment]:
    """Return the three trainings by name: they differ only in their limits."""
    limits = {name: recipe.train.roles["driver"].limits for name, recipe in LIMITED.items()}
    return {PLAIN: base, **{name: with_limits(base, *found) for name, found in limits.items()}}


def _train(work: RiskWork) -> None:
    plan, experiments = work.plan, trainings(work.base)
    planned = [with_training(one, updates=plan.updates) for one in list(experiments.values()) * plan.seeds]
    played = plan.episodes * (len(experiments) * plan.seeds + 1)
    work.say(f"    {cost(planned, played, speed=STEPS_PER_SECOND)}")
    for seed in plan.training_seeds:
        for name, experiment in experiments.items():
            work.train(name, with_training(experiment, updates=plan.updates), seed)


def _evaluate(work: RiskWork) -> None:
    if work.done(RESULT):
        return
    street, scenarios = work.street(), Scenarios(work.plan.episodes, work.plan.seed)
    chosen, matches = play_rounds(street, _rounds(work, street), scenarios, work.say)
    drivers = (*trainings(work.base), CLEARANCE)
    of = {name: [match for match in matches if match.cell.driver == name] for name in drivers}
    ordered = [match for group in of.values() for match in group]
    pairs = [(of[PLAIN], of[name]) for name in LIMITED]
    endings = [paired_over_seeds(ending, *pair) for ending in COMPARED for pair in pairs]
    results = results_of(street, chosen, ordered, paired=endings)
    results = replace(results, paired_delays=tuple(paired_delay(*pair) for pair in pairs))
    compared = tuple(paired_harm(WORST, *pair) for pair in pairs)
    work.keep(RESULT, RiskDocument(results, seed_harms(WORST, ordered), compared, tuple(_kept(work))).as_dict())


def _rounds(work: RiskWork, street: Street) -> list[Round]:
    people = {ALWAYS_GO: contestant(street, "pedestrian", ALWAYS_GO)}
    rounds: list[Round] = [(None, {CLEARANCE: contestant(street, "driver", CLEARANCE)}, people)]
    for seed in work.plan.training_seeds:
        drivers = {name: contestant(street, "driver", str(work.run(name, seed))) for name in trainings(work.base)}
        rounds.append((seed, drivers, people))
    return rounds


def _kept(work: RiskWork) -> list[LimitKept]:
    """Return what each training reached of its limits."""
    runs = [(name, seed) for name in LIMITED for seed in work.plan.training_seeds]
    return [kept for name, seed in runs for kept in _kept_in(Run.open(work.run(name, seed)), name, seed)]


def _kept_in(run: Run, name: str, seed: int) -> Iterator[LimitKept]:
    """Yield what one training reached of each limit, from its run folder."""
    lines = run.metrics()[-LAST:]
    for role, limit in run.experiment.train.limits.values():
        costs = [line[f"cost/{role}/{limit.cost}"] for line in lines]
        multiplier = lines[-1][f"multiplier/{role}/{limit.cost}"]
        yield LimitKept(name, seed, limit.cost, limit.limit, sum(costs) / len(costs), multiplier)


def _write(work: RiskWork) -> None:
    origin = Origin(work.folder / RESULT, f"delete it and run `jaxwalk {work.command}` again")
    document = as_risk_document(work.json(RESULT), origin)
    write_whole(work.folder / PAGE, page(document, updates=work.plan.updates))
