"""What does it cost a car not to know who is likely to jaywalk, or not to see everybody?

runs/blind/seed-0, ...     the car trained alone; and so for each other one of `trainings`
plan.json, minutes.json    what was requested; how long each part took
SETTING.json               all of them and the clearance rule on the same scenarios, in pairs; how much could be known;
                           for each of `IntentWork.settings` (`jaxwalk.report.intent_document`)
hidden-intent.json         all of that in one document
hidden-intent.md           the answer and its tables (`jaxwalk.report.intent_page`)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console

from jaxwalk.evaluation import Match, evaluate, paired_delay, paired_over_seeds
from jaxwalk.evaluation.equal_delay import AT_EQUAL_DELAY, EqualDelay, equal_delay
from jaxwalk.evaluation.harm_numbers import Harm, paired_harm, seed_harms
from jaxwalk.evaluation.reading import Origin
from jaxwalk.experiments.tournament import Round, Scenarios, play_rounds, results_of
from jaxwalk.metrics import CROSSINGS, ENCOUNTERS, OUTCOMES, Rows
from jaxwalk.metrics.identifiability import crossings_of_people, identifiability
from jaxwalk.policies import ConstantSpeed
from jaxwalk.recipes import FAST, RECIPES, Experiment, single_agent, with_training
from jaxwalk.report import ALWAYS_GO, CLEARANCE
from jaxwalk.report.intent_document import IntentStreet, KnownIntent, as_intent_street, priced
from jaxwalk.report.intent_page import BLIND, ENDINGS, compared, page
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.effort import Effort
from jaxwalk.runs.study import Work
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.observation import AWARE, BELIEF, DECIDED, FOOTPRINT, MEMORY, PLACEBO, TOLD, X_RAY
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.suites import SUITES
from jaxwalk.wording import counted
from jaxwalk.writing import write_whole

INTENT = {BLIND: FOOTPRINT, "placebo": PLACEBO, "belief": BELIEF, "told": TOLD}
"""Cars and what they see. Their critics all see the same: only the drivers differ."""
SIGHT = {BLIND: FOOTPRINT, "x-ray": X_RAY, "memory": MEMORY, "aware": AWARE, **INTENT, "decided": DECIDED}
"""More of them, where people can be hidden: first those that tell what it costs that people are."""
MULTIPLIERS = (0.25, 1.0)
"""Jaywalk multipliers of the evaluation, beside that of the trainings."""
FEW_PARKED = 0.3
"""Where vehicles hide people, fewer of them are parked in another setting: the share of the slots."""
MOST_TIME = 1000.0
"""Largest price of time, as a multiple of the recipe's."""
AFTER = (1, 2, 5, 10, 20, 50)
"""Numbers of crossings seen, for which what could be known is computed as well."""
INJURIES: Harm = "serious injuries"
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
    time_weights: tuple[float, ...] = (1.0,)
    """Prices of time, as multiples of the recipe's: each car is trained with each of them."""
    pace_correlation: float = 0.0
    """How far people's pace tells of their tendency (`SimConfig`), in trainings and evaluations."""
    only_as_trained: bool = False
    """Whether to evaluate in the setting of the trainings alone."""

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible value."""
        super().__post_init__()
        known = cars_of(RECIPES[self.recipe])
        for name in self.cars:
            if name not in known:
                raise ValueError(f"cars: no car '{name}' in recipe {self.recipe}; there are: {', '.join(known)}")
        if self.cars and BLIND not in self.cars:
            raise ValueError(f"cars: the others are compared with {BLIND}; name it too")
        names = [priced("", weight) for weight in self.time_weights]
        if "" not in names or len(set(names)) < len(names):
            raise ValueError(f"time_weights: name each once, and 1 among them, not {self.time_weights}")
        for weight in self.time_weights:
            if not 0 <= weight <= MOST_TIME:
                raise ValueError(f"time_weights must lie in [0, {MOST_TIME:g}], not {weight:g}")
        telling(RECIPES[self.recipe], self.pace_correlation)  # only for its ValueError


class IntentWork(Work[IntentEffort]):
    """The experiment in a folder."""

    command = "hidden-intent"
    may_change = ("only_as_trained",)

    def maps(self) -> tuple[str, ...]:
        """Return the maps to evaluate on: streets that no training has, if there are many."""
        return self.base.maps if self.base.maps == FAST.maps else SUITES[self.plan.recipe].maps

    def settings(self) -> dict[str, SimConfig]:
        """Return the rules of the trainings, and other ones if they are asked for, by names for readers."""
        rules = self.base.sim
        if self.base.maps != FAST.maps:
            rules = replace(rules, pedestrians=SUITES[self.plan.recipe].people or rules.pedestrians)
        others = () if self.plan.only_as_trained else MULTIPLIERS
        found = {
            f"jaywalk multiplier {multiplier:g}": replace(rules, jaywalk_multiplier=multiplier)
            for multiplier in dict.fromkeys((rules.jaywalk_multiplier, *others))
        }
        if others and rules.parked > FEW_PARKED:
            found[f"vehicles parked in {100 * FEW_PARKED:.0f} of 100 slots"] = replace(rules, parked=FEW_PARKED)
        return found


def hidden_intent(
    folder: Path, plan: IntentEffort, *, console: Console | None = None, base: Experiment | None = None
) -> Path:
    """Make whatever is missing in the folder; return the page's path. Raise Interrupted on Ctrl-C.

    ``base``: what to train instead of only the car of the plan's recipe; its driver's observation set is replaced,
    and how far people's pace tells of their tendency.
    """
    base = base or acquainted(single_agent(RECIPES[plan.recipe]))
    work = IntentWork(folder, plan, console or Console(stderr=True), telling(base, plan.pace_correlation))
    work.do(
        [
            ("training cars that know more or less", _train),
            ("all of them and the clearance rule on the same scenarios", _evaluate),
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


def telling(experiment: Experiment, pace_correlation: float) -> Experiment:
    """Return the experiment where people's pace tells of their tendency. Raise ValueError for an impossible number."""
    return replace(experiment, sim=replace(experiment.sim, pace_correlation=pace_correlation))


def cars_of(experiment: Experiment, chosen: Sequence[str] = ()) -> dict[str, str]:
    """Return the cars by name, and what they see: all of them, or the chosen ones."""
    cars = SIGHT if experiment.sim.perception else INTENT
    return {name: observes for name, observes in cars.items() if not chosen or name in chosen}


def trainings(base: Experiment, plan: IntentEffort) -> dict[str, Experiment]:
    """Return what is trained with every seed, by name: each car with each price of time."""
    return {
        priced(car, weight): _seeing(base, observes, weight)
        for weight in plan.time_weights
        for car, observes in cars_of(base, plan.cars).items()
    }


def _seeing(base: Experiment, observes: str, weight: float) -> Experiment:
    roles = base.train.roles
    roles = roles | {"driver": replace(roles["driver"], observes=observes)}
    weights = base.driver_weights | {"time": weight * base.driver_weights["time"]}
    return replace(with_training(base, roles=roles), driver_weights=weights)


def _train(work: IntentWork) -> None:
    for name, experiment in trainings(work.base, work.plan).items():
        for seed in work.plan.training_seeds:
            work.train(name, with_training(experiment, updates=work.plan.updates), seed)


def _file(setting: str) -> str:
    """Return the name of the file of one setting."""
    return setting.replace(" ", "-") + ".json"


def _evaluate(work: IntentWork) -> None:
    for setting, rules in work.settings().items():
        work.say(f"    {setting}")
        if not work.done(_file(setting)):
            work.keep(_file(setting), _findings(work, setting, Street.create(work.maps(), rules)).as_dict())


def _findings(work: IntentWork, setting: str, street: Street) -> IntentStreet:
    """Return what everybody does in one setting."""
    plan, scenarios = work.plan, Scenarios(work.plan.episodes, work.plan.seed)
    people, names = {ALWAYS_GO: contestant(street, "pedestrian", ALWAYS_GO)}, list(trainings(work.base, plan))
    rounds: list[Round] = []
    for seed in plan.training_seeds:
        drivers = {name: contestant(street, "driver", str(work.run(name, seed))) for name in names}
        rounds.append((seed, drivers, people))
    rounds.append((None, {CLEARANCE: contestant(street, "driver", CLEARANCE)}, people))
    chosen, matches = play_rounds(street, rounds, scenarios, work.say)
    of: dict[str, list[Match]] = {}
    for match in matches:
        of.setdefault(match.cell.driver, []).append(match)
    cars = list(cars_of(work.base, plan.cars))
    pairs = [(of[a], of[b]) for a, b in compared(cars)]
    results = results_of(street, chosen, matches, paired=[paired_over_seeds(end, *p) for end in ENDINGS for p in pairs])
    return IntentStreet(
        setting=setting,
        results=replace(results, paired_delays=tuple(paired_delay(*pair) for pair in pairs)),
        identifiability=_identifiability(street, Rows.join([match.rows for match in of[BLIND]]), scenarios),
        harms=seed_harms(INJURIES, matches),
        paired_harms=tuple(paired_harm(INJURIES, *pair) for pair in pairs),
        equal_delays=_equal_delays(plan, cars, of),
    )


def _equal_delays(plan: IntentEffort, cars: Sequence[str], of: Mapping[str, Sequence[Match]]) -> tuple[EqualDelay, ...]:
    """Return the same comparisons at equal delay; nothing if there is one price of time."""
    if len(plan.time_weights) == 1:
        return ()
    groups = {car: [of[priced(car, weight)] for weight in plan.time_weights] for car in cars}
    return tuple(equal_delay(what, groups[a], groups[b]) for what in AT_EQUAL_DELAY for a, b in compared(cars))


def _identifiability(street: Street, blind: Rows, scenarios: Scenarios) -> tuple[KnownIntent, ...]:
    """Return how much could be known in a whole episode, in one of the blind car's, and at an encounter.

    Whole episodes are those of a car that stands; episodes that end early because somebody walks into it are left out.
    What the car saw of each person before its episode counts as crossings too, as in `jaxwalk.sim.belief`.
    """
    people, seconds = street.world.rules.pedestrians, street.world.rules.horizon * street.world.rules.dt
    always_go = contestant(street, "pedestrian", ALWAYS_GO)
    source = Drawn(street, scenarios.seed, scenarios.episodes)
    stands = evaluate(street, {"driver": ConstantSpeed(throttle=0.0), "pedestrian": always_go}, source)
    whole = _crossings(stands, people)[stands[OUTCOMES].steps == street.world.rules.horizon]
    mean, tendencies = blind[OUTCOMES].steps.mean() * blind.dt, street.config.tendencies
    before = street.config.earlier_decisions
    said = f", and {counted(before, 'decision')} of each from before" if before else ""
    cases = [
        (f"in a whole episode ({seconds:g} s){said}", before + whole.ravel()),
        (f"in an episode of the blind car ({mean:.1f} s){said}", before + _crossings(blind, people).ravel()),
        (f"before a crossing at which the blind car meets somebody{said}", before + blind[ENCOUNTERS].number - 1),
        *((f"crossings of each: {number}", np.array([number])) for number in AFTER),
    ]
    known = partial(identifiability, multiplier=street.config.jaywalk_multiplier, tendencies=tendencies)
    return tuple(KnownIntent(seen, known(count) if len(count) else None) for seen, count in cases)


def _crossings(rows: Rows, people: int) -> np.ndarray:
    """Return the number of crossings of each person, of shape (episode, ped)."""
    episodes = rows.episodes
    return crossings_of_people(rows[CROSSINGS], episodes=episodes, people=people).reshape(episodes, people)


def _write(work: IntentWork) -> None:
    plan, again = work.plan, f"delete it and run `jaxwalk {work.command}` again"
    files = [work.folder / _file(setting) for setting in work.settings()]
    streets = [as_intent_street(work.json(file.name), plan.seeds, Origin(file, again)) for file in files]
    work.keep(RESULT, {"plan": asdict(plan), "streets": [street.as_dict() for street in streets]})
    text = page(
        streets, recipe=plan.recipe, updates=plan.updates, time_weights=plan.time_weights,
        pace_correlation=plan.pace_correlation,
    )  # fmt: skip
    write_whole(work.folder / PAGE, text)
