"""What does it cost a car not to know who is likely to jaywalk, or not to see everybody?

runs/blind/seed-0, ...     the car trained alone; and so for each other car of `cars_of`
plan.json, minutes.json    what was requested; how long each part took
hidden-intent.json         all of them on the same scenarios, in pairs, and how much could be known
hidden-intent.md           the tables (`jaxwalk.report.intent_page`)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console

from jaxwalk.evaluation import Match, evaluate, paired_over_seeds, with_jaywalk_multiplier
from jaxwalk.evaluation.document_parts import PairedSeeds
from jaxwalk.evaluation.reading import Origin
from jaxwalk.evaluation.training_seeds import ENDINGS
from jaxwalk.experiments.tournament import Round, Scenarios, play_rounds, results_of
from jaxwalk.metrics import CROSSINGS, ENCOUNTERS, OUTCOMES, Rows
from jaxwalk.metrics.identifiability import crossings_of_people, identifiability
from jaxwalk.policies import ConstantSpeed
from jaxwalk.provenance import provenance
from jaxwalk.recipes import FAST, RECIPES, Experiment, single_agent, with_training
from jaxwalk.report import ALWAYS_GO
from jaxwalk.report.intent_document import IntentDocument, IntentPlan, IntentStreet, KnownIntent, as_intent_document
from jaxwalk.report.intent_page import BLIND, page
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.effort import Effort
from jaxwalk.runs.study import Work
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.observation import AWARE, BELIEF, DECIDED, FOOTPRINT, MEMORY, PLACEBO, TOLD, X_RAY
from jaxwalk.sim.suites import SUITES
from jaxwalk.writing import write_whole

INTENT = {BLIND: FOOTPRINT, "placebo": PLACEBO, "belief": BELIEF, "told": TOLD}
"""Cars and what they see. Their critics all see the same: only the drivers differ."""
SIGHT = {BLIND: FOOTPRINT, "x-ray": X_RAY, "memory": MEMORY, "aware": AWARE, **INTENT, "decided": DECIDED}
"""More of them, where people can be hidden: first those that tell what it costs that people are."""
OFTEN = 1.0
"""A jaywalk multiplier of the evaluation beside that of the trainings: with it, intentions matter more."""
AFTER = (1, 2, 5, 10, 20, 50)
"""Numbers of crossings seen, for which what could be known is computed as well."""
RESULT, PAGE = "hidden-intent.json", "hidden-intent.md"


@dataclass(frozen=True)
class IntentEffort(Effort):
    """The size of the experiment, and the recipe of its trainings."""

    recipe: str = FAST.recipe
    updates: int = 200
    episodes: int = 2000
    seeds: int = 5
    cars: tuple[str, ...] = ()
    """The cars to train; none: all."""

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible value."""
        super().__post_init__()
        known = cars_of(RECIPES[self.recipe])
        for name in self.cars:
            if name not in known:
                raise ValueError(f"cars: no car '{name}' in recipe {self.recipe}; there are: {', '.join(known)}")
        if self.cars and BLIND not in self.cars:
            raise ValueError(f"cars: the others are compared with {BLIND}; name it too")


class IntentWork(Work[IntentEffort]):
    """The experiment in a folder."""

    command = "hidden-intent"

    def street(self) -> Street:
        """Return the street to evaluate on: streets that no training has, if there are many."""
        if self.base.maps == FAST.maps:
            return super().street()
        where = SUITES[self.plan.recipe]
        return Street.create(where.maps, replace(self.base.sim, pedestrians=where.people or self.base.sim.pedestrians))


def hidden_intent(
    folder: Path, plan: IntentEffort, *, console: Console | None = None, base: Experiment | None = None
) -> Path:
    """Make whatever is missing in the folder; return the page's path. Raise Interrupted on Ctrl-C.

    ``base``: what to train instead of only the car of the plan's recipe; its driver's observation set is replaced.
    """
    base = base or acquainted(single_agent(RECIPES[plan.recipe]))
    work = IntentWork(folder, plan, console or Console(stderr=True), base)
    work.do(
        [
            ("training cars that know more or less", _train),
            ("all of them on the same scenarios", _evaluate),
            ("tables", _write),
        ]
    )
    return folder / PAGE


def acquainted(experiment: Experiment) -> Experiment:
    """Return the experiment where, if people can be hidden, the car saw one decision of each of them before.

    Those who are in a hurry nearly always jaywalk and the others hardly ever, so one decision tells nearly all.
    """
    if not experiment.sim.perception:
        return experiment
    return replace(experiment, sim=replace(experiment.sim, earlier_decisions=1))


def cars_of(experiment: Experiment, chosen: Sequence[str] = ()) -> dict[str, str]:
    """Return the cars by name, and what they see: all of them, or the chosen ones."""
    cars = SIGHT if experiment.sim.perception else INTENT
    return {name: observes for name, observes in cars.items() if not chosen or name in chosen}


def _train(work: IntentWork) -> None:
    for name, observes in cars_of(work.base, work.plan.cars).items():
        roles = work.base.train.roles
        roles = roles | {"driver": replace(roles["driver"], observes=observes)}
        for seed in work.plan.training_seeds:
            work.train(name, with_training(work.base, roles=roles, updates=work.plan.updates), seed)


def _evaluate(work: IntentWork) -> None:
    if work.done(RESULT):
        return
    street, scenarios = work.street(), Scenarios(work.plan.episodes, work.plan.seed)
    people = {ALWAYS_GO: contestant(street, "pedestrian", ALWAYS_GO)}
    rounds: list[Round] = []
    for seed in work.plan.training_seeds:
        drivers = {
            name: contestant(street, "driver", str(work.run(name, seed))) for name in cars_of(work.base, work.plan.cars)
        }
        rounds.append((seed, drivers, people))
    streets = []
    for multiplier in dict.fromkeys((street.config.jaywalk_multiplier, OFTEN)):
        work.say(f"    multiplier {multiplier:g}")
        there = with_jaywalk_multiplier(street, multiplier)
        chosen, matches = play_rounds(there, rounds, scenarios, work.say)
        known = _identifiability(there, multiplier, _rows(matches, BLIND), scenarios)
        streets.append(IntentStreet(multiplier, results_of(there, chosen, matches, paired=_pairs(matches)), known))
    document = IntentDocument(IntentPlan(**asdict(work.plan)), provenance(), tuple(streets))
    work.keep(RESULT, document.as_dict())


def _rows(matches: Sequence[Match], driver: str) -> Rows:
    """Return the rows of all training seeds."""
    return Rows.join([match.rows for match in matches if match.cell.driver == driver])


def _pairs(matches: Sequence[Match]) -> list[PairedSeeds]:
    """Compare each of the other cars with the blind one."""
    of: dict[str, list[Match]] = {}
    for match in matches:
        of.setdefault(match.cell.driver, []).append(match)
    blind = of.pop(BLIND)
    return [paired_over_seeds(end, blind, other) for end in ENDINGS for other in of.values()]


def _identifiability(street: Street, multiplier: float, blind: Rows, scenarios: Scenarios) -> tuple[KnownIntent, ...]:
    """Return how much could be known in a whole episode, in one of the blind car's, and at an encounter.

    Whole episodes are those of a car that stands; episodes that end early because somebody walks into it are left out.
    """
    people, seconds = street.world.rules.pedestrians, street.world.rules.horizon * street.world.rules.dt
    always_go = contestant(street, "pedestrian", ALWAYS_GO)
    source = Drawn(street, scenarios.seed, scenarios.episodes)
    stands = evaluate(street, {"driver": ConstantSpeed(throttle=0.0), "pedestrian": always_go}, source)
    whole = _crossings(stands, people)[stands[OUTCOMES].steps == street.world.rules.horizon]
    mean, tendencies = blind[OUTCOMES].steps.mean() * blind.dt, street.config.tendencies
    cases = [
        (f"in a whole episode ({seconds:g} s)", whole.ravel()),
        (f"in an episode of the blind car ({mean:.1f} s)", _crossings(blind, people).ravel()),
        ("before a crossing at which the blind car meets somebody", blind[ENCOUNTERS].number - 1),
        *((f"crossings of each: {number}", np.array([number])) for number in AFTER),
    ]
    known = partial(identifiability, multiplier=multiplier, tendencies=tendencies)
    return tuple(KnownIntent(seen, known(count) if len(count) else None) for seen, count in cases)


def _crossings(rows: Rows, people: int) -> np.ndarray:
    """Return the number of crossings of each person, of shape (episode, ped)."""
    episodes = rows.episodes
    return crossings_of_people(rows[CROSSINGS], episodes=episodes, people=people).reshape(episodes, people)


def _write(work: IntentWork) -> None:
    origin = Origin(work.folder / RESULT, f"delete it and run `jaxwalk {work.command}` again")
    write_whole(work.folder / PAGE, page(as_intent_document(work.json(RESULT), origin)))
