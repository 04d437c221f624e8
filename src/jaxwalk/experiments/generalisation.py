"""Does a car cope with streets that it has never seen, and how much do more streets in training help?

runs/streets-N/seed-S  the trainings: recipe ``town`` on N streets, with every training seed
plan.json, minutes.json    what was requested; how long each part took
scores/NAME.json       how everybody's episodes ended on each street of a set (`jaxwalk.evaluation.over_streets`)
generalisation.json    all of them, with the plan and where they were made
generalisation.md      the answer and its tables (`jaxwalk.report.generalisation_page`)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path

from rich.console import Console

from jaxwalk.evaluation.over_streets import StreetSet, scores_of
from jaxwalk.evaluation.reading import Origin, as_document
from jaxwalk.experiments.tournament import Round, Scenarios, play_rounds
from jaxwalk.interfaces import Policy
from jaxwalk.maps import each_map, map_labels
from jaxwalk.provenance import provenance
from jaxwalk.recipes import RECIPES, Experiment, single_agent, with_training
from jaxwalk.report import ALWAYS_GO
from jaxwalk.report.generalisation_page import OWN, TEST, USUAL, page
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.effort import Effort
from jaxwalk.runs.study import Work
from jaxwalk.sim.environment import Street
from jaxwalk.wording import counted
from jaxwalk.writing import write_whole

STREETS = (1, 8, 64, 256)
"""Numbers of streets to train on; each divides the last one."""
TESTS = {TEST: "test:200", "unseen-ranges": "unseen-ranges:200", "paper": "paper"}
"""The sets of streets on which everybody is tested, by name."""
CROWDS = (USUAL // 2, USUAL, 2 * USUAL, 4 * USUAL)
"""Numbers of people on the streets of `TEST`; elsewhere there are `USUAL`."""
RULES = ("route-follower", "clearance", "oracle")
"""Drivers that nobody trained."""
SCORES, RESULT, PAGE = "scores", "generalisation.json", "generalisation.md"


@dataclass(frozen=True)
class GeneralisationEffort(Effort):
    """The size of the study."""

    updates: int = 400
    episodes: int = 2000
    seed: int = 60
    seeds: int = 5


class GeneralisationWork(Work[GeneralisationEffort]):
    """The study in a folder."""

    command = "generalisation"

    def street_on(self, maps: Sequence[str]) -> Street:
        """Return the world of the trainings on other maps."""
        return Street.create(maps, self.base.sim, jaywalk_multiplier=self.base.jaywalk_multiplier)


def generalisation(
    folder: Path, plan: GeneralisationEffort, *, console: Console | None = None, base: Experiment | None = None
) -> Path:
    """Make whatever is missing in the folder; return the page's path. Raise Interrupted on Ctrl-C.

    ``base``: what to train instead of only the car of recipe ``town``; its maps are replaced.
    """
    base = base or single_agent(RECIPES["town"])
    work = GeneralisationWork(folder, plan, console or Console(stderr=True), base)
    work.do(
        [
            ("training on few and on many streets", _train),
            ("everybody on unseen streets", _test),
            ("each car on its own streets", _test_at_home),
            ("tables", _write),
        ]
    )
    return folder / PAGE


def own_streets(count: int, place: int) -> tuple[str, ...]:
    """Return the streets to train on; ``place`` is that of the seed among the training seeds.

    Trainings of other seeds have other streets, until all of the largest number have been taken.
    """
    every = each_map([f"training:{max(STREETS)}"])
    first = place * count % len(every)
    return every[first : first + count]


def _name(count: int) -> str:
    return f"streets-{count}"


def _train(work: GeneralisationWork) -> None:
    plan, updates = work.plan, with_training(work.base, updates=work.plan.updates)
    steps = len(STREETS) * plan.seeds * plan.updates * updates.steps_per_update
    trainings = counted(len(STREETS) * plan.seeds, "training")
    work.say(f"    {trainings} of {counted(plan.updates, 'update')} ({steps:,} steps)")
    for place, seed in enumerate(plan.training_seeds):
        for count in STREETS:
            work.train(_name(count), replace(updates, maps=own_streets(count, place)), seed)


def _test(work: GeneralisationWork) -> None:
    for name, maps in TESTS.items():
        crowds = [people for people in CROWDS if name == TEST or people == USUAL]
        missing = [people for people in crowds if work.json(_file(name, people)) is None]
        if not missing:
            work.say(f"    {name}: there already")
            continue
        street = work.street_on([maps])
        rules = {rule: contestant(street, "driver", rule) for rule in RULES}
        rounds = [*_trained(work, street), (None, rules)]
        for people in missing:
            _measure(work, name, street.with_people(people), rounds)


def _test_at_home(work: GeneralisationWork) -> None:
    for (place, seed), count in product(enumerate(work.plan.training_seeds), STREETS):
        name = f"{OWN}-{count}-seed-{seed}"
        if work.done(_file(name, USUAL)):
            continue
        street = work.street_on(own_streets(count, place)).with_people(USUAL)
        car = contestant(street, "driver", str(work.run(_name(count), seed)))
        _measure(work, name, street, [(seed, {_name(count): car})])


Drivers = tuple[int | None, Mapping[str, Policy]]
"""A training seed (None: nobody was trained) and drivers by name."""


def _trained(work: GeneralisationWork, street: Street) -> list[Drivers]:
    """Return the trained cars of each seed."""
    return [
        (seed, {_name(count): contestant(street, "driver", str(work.run(_name(count), seed))) for count in STREETS})
        for seed in work.plan.training_seeds
    ]


def _measure(work: GeneralisationWork, name: str, street: Street, drivers: Sequence[Drivers]) -> None:
    """Play everybody among people who always go, and keep the scores on each street."""
    people, count = {ALWAYS_GO: contestant(street, "pedestrian", ALWAYS_GO)}, street.config.pedestrians
    work.say(f"    {name}: {counted(len(street.maps), 'street')}, {count} people")
    rounds: list[Round] = [(seed, cars, people) for seed, cars in drivers]
    _, matches = play_rounds(street, rounds, Scenarios(work.plan.episodes, work.plan.seed), work.say)
    streets = tuple(map_labels(street.maps))
    scores = sorted((scores_of(match, streets) for match in matches), key=lambda one: _place(one.driver))
    (work.folder / SCORES).mkdir(exist_ok=True)
    kind = OWN if name.startswith(OWN) else name
    work.keep(_file(name, count), asdict(StreetSet(kind, count, streets, tuple(scores))))


def _place(driver: str) -> int:
    return [*map(_name, STREETS), *RULES].index(driver)


def _file(name: str, people: int) -> str:
    return f"{SCORES}/{name}-{people}-people.json"


def _write(work: GeneralisationWork) -> None:
    files = [_file(name, people) for name in TESTS for people in CROWDS if name == TEST or people == USUAL]
    files += [_file(f"{OWN}-{n}-seed-{seed}", USUAL) for n in STREETS for seed in work.plan.training_seeds]
    sets = [_read(work, file) for file in files]
    made = provenance()
    work.keep(RESULT, {"plan": asdict(work.plan), "made": asdict(made), "sets": [asdict(one) for one in sets]})
    write_whole(work.folder / PAGE, page(sets, updates=work.plan.updates, made=made))


def _read(work: GeneralisationWork, file: str) -> StreetSet:
    origin = Origin(work.folder / file, f"delete it and run `jaxwalk {work.command}` again")
    return as_document(StreetSet, work.json(file), origin)
