"""Does training a car together with people make a better car than training it alone?

runs/NAME/seed-N       the trainings: the five of `cells`, with every training seed
plan.json, minutes.json    what was requested; how long each part took
co-training.json       all of them and the clearance rule on the same scenarios (`jaxwalk.evaluation.Results`)
co-training.md         the answer and its tables (`jaxwalk.report.co_training_page`)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

from rich.console import Console

from jaxwalk.evaluation import Match, paired_delay, paired_over_seeds
from jaxwalk.evaluation.document_parts import PairedSeeds
from jaxwalk.evaluation.reading import Origin, as_results
from jaxwalk.experiments.tournament import Round, Scenarios, play_rounds, results_of
from jaxwalk.learning.config import own_environments
from jaxwalk.recipes import RECIPES, Experiment, single_agent, with_training
from jaxwalk.report import ALWAYS_GO, CLEARANCE, GAP_ACCEPTANCE
from jaxwalk.report.co_training_page import ALONE, FACTORS, MIXED, PEOPLE, PURE, STAND_INS, TOUCHED, page
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.effort import Effort
from jaxwalk.runs.study import P, Work
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import rules_of
from jaxwalk.wording import counted
from jaxwalk.writing import write_whole

WORLD = "paper-footprint"
"""The world of the evaluation."""
RULES = (ALWAYS_GO, GAP_ACCEPTANCE)
"""The populations that nobody trained."""
RESULT, PAGE = "co-training.json", "co-training.md"
STEPS_PER_SECOND, EPISODES_PER_SECOND = 40_000.0, 400.0
"""What two CPU cores manage of recipe ``fast`` and of evaluation, for the time that is said in advance."""


@dataclass(frozen=True)
class CoTrainingEffort(Effort):
    """The size of the study."""

    updates: int = 200
    episodes: int = 2000
    seed: int = 40
    seeds: int = 10

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible plan."""
        super().__post_init__()
        if self.seeds < 2:
            raise ValueError("seeds must be at least 2: cars meet people of another training seed")


class FootprintWork(Work[P]):
    """A study that is judged by contacts of the car's footprint."""

    def street(self) -> Street:
        """Return the street to evaluate on: that of the trainings, where a contact of the footprint is a collision."""
        base, rules = self.base, rules_of(WORLD, self.base.maps, self.base.sim)
        return Street.create(base.maps, rules, jaywalk_multiplier=base.jaywalk_multiplier)


class CoTrainingWork(FootprintWork[CoTrainingEffort]):
    """The study in a folder."""

    command = "co-training"


def co_training(
    folder: Path, plan: CoTrainingEffort, *, console: Console | None = None, base: Experiment | None = None
) -> Path:
    """Make whatever is missing in the folder; return the page's path. Raise Interrupted on Ctrl-C.

    ``base``: what to train instead of recipe ``fast``: its drivers' and its people's stand-ins are the treatments.
    """
    work = CoTrainingWork(folder, plan, console or Console(stderr=True), base or RECIPES["fast"])
    work.do(
        [
            ("training the car with people and alone", _train),
            ("all of them and the clearance rule on the same scenarios", _evaluate),
            ("tables", _write),
        ]
    )
    return folder / PAGE


def cells(base: Experiment) -> dict[str, Experiment]:
    """Return the five trainings by name. In each the car learns from as many environments as in the others.

    Pure: everybody that the car meets learns. Mixed: in some environments people always go, as many as in ``base``.
    Stand-ins: in further environments people meet careless cars and earlier versions of the car, as in ``base``.
    """
    train, own = base.train, own_environments(base.train, "driver")
    always_go = round(train.roles["pedestrian"].fixed * train.environments)
    found = {}
    for mixed, stand_ins in product((False, True), repeat=2):
        environments = train.environments if stand_ins else own
        driver, people = train.roles["driver"], train.roles["pedestrian"]
        driver = driver if stand_ins else replace(driver, fixed=0.0, early=0.0)
        people = replace(people, fixed=always_go / environments if mixed else 0.0)
        name = (MIXED if mixed else PURE) + (STAND_INS if stand_ins else "")
        roles = {"driver": driver, "pedestrian": people}
        found[name] = with_training(base, environments=environments, roles=roles)
    return {**found, ALONE: single_agent(base)}


def _cost(work: CoTrainingWork) -> str:
    """Return what there is to do, and about how long it takes."""
    plan, experiments = work.plan, list(cells(work.base).values())
    played = len(RULES) + plan.seeds * (len(PEOPLE) + len(experiments) * (len(RULES) + len(PEOPLE)))
    trained = [with_training(one, updates=plan.updates) for one in experiments * plan.seeds]
    return cost(trained, plan.episodes * played, speed=STEPS_PER_SECOND)


def cost(trained: Sequence[Experiment], episodes: int, *, speed: float) -> str:
    """Return how much there is to train and to evaluate, in words.

    And about how long it takes; ``speed`` is that of the trainings on two CPU cores [steps/s].
    """
    steps = sum(one.train.updates * one.steps_per_update for one in trained)
    hours = (steps / speed + episodes / EPISODES_PER_SECOND) / 3600
    updates = counted(trained[0].train.updates, "update")
    return (
        f"{counted(len(trained), 'training')} of {updates} ({steps:,} steps) and {counted(episodes, 'episode')} of "
        f"evaluation: about {hours:.1f} hours on two CPU cores"
    )


def _train(work: CoTrainingWork) -> None:
    work.say(f"    {_cost(work)}")
    for seed in work.plan.training_seeds:
        for name, experiment in cells(work.base).items():
            work.train(name, with_training(experiment, updates=work.plan.updates), seed)


def _evaluate(work: CoTrainingWork) -> None:
    if work.done(RESULT):
        return
    street, scenarios = work.street(), Scenarios(work.plan.episodes, work.plan.seed)
    chosen, matches = play_rounds(street, _rounds(work, street), scenarios, work.say)
    drivers, populations = (CLEARANCE, ALONE, *_others(work)), (*RULES, *PEOPLE)
    places = {names: place for place, names in enumerate(product(populations, drivers))}
    matches.sort(key=lambda match: places[match.cell.pedestrians, match.cell.driver])
    results = results_of(street, chosen, matches)
    later = [paired_delay(a, b) for a, b in _pairs(matches, [(ALONE, name) for name in _others(work)])]
    work.keep(RESULT, replace(results, paired=_compared(work, matches), paired_delays=tuple(later)).as_dict())


def _others(work: CoTrainingWork) -> list[str]:
    return [name for name in cells(work.base) if name != ALONE]


def _rounds(work: CoTrainingWork, street: Street) -> list[Round]:
    """Return who meets which people: a car those of the next training seed, the last seed's car those of the first.

    So no car meets anybody who learned beside it.
    """
    rules = {name: contestant(street, "pedestrian", name) for name in RULES}
    clearance = {CLEARANCE: contestant(street, "driver", CLEARANCE)}
    rounds: list[Round] = [(None, clearance, rules)]
    seeds = work.plan.training_seeds
    for number, seed in enumerate(seeds):
        drivers = {name: contestant(street, "driver", str(work.run(name, seed))) for name in cells(work.base)}
        other = seeds[(number + 1) % len(seeds)]
        people = {of: contestant(street, "pedestrian", str(work.run(name, other))) for of, name in PEOPLE.items()}
        rounds += [(seed, drivers, {**rules, **people}), (seed, clearance, people)]
    return rounds


def _compared(work: CoTrainingWork, matches: Sequence[Match]) -> tuple[PairedSeeds, ...]:
    """Compare each co-trained car with the car alone, and with the car whose training differs in one treatment."""
    with_alone = [(ALONE, name) for name in _others(work)]
    found = [paired_over_seeds(of, a, b) for of in (TOUCHED, "goal") for a, b in _pairs(matches, with_alone)]
    return (*found, *(paired_over_seeds(TOUCHED, a, b) for a, b in _pairs(matches, FACTORS)))


def _pairs(matches: Sequence[Match], drivers: Sequence[tuple[str, str]]) -> list[tuple[list[Match], list[Match]]]:
    """Return the matches of each pair of drivers among each population, over training seeds."""

    def found(*names: str) -> list[Match]:
        return [match for match in matches if match.names == names]

    return [(found(a, people), found(b, people)) for people in (*RULES, *PEOPLE) for a, b in drivers]


def _write(work: CoTrainingWork) -> None:
    origin = Origin(work.folder / RESULT, f"delete it and run `jaxwalk {work.command}` again")
    results = as_results(work.json(RESULT), origin)
    write_whole(work.folder / PAGE, page(results, updates=work.plan.updates))
