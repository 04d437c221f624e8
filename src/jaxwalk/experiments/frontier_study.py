"""`jaxwalk frontier`: contacts against delay, each driver with its knob turned, and who is beaten in both.

plan.json, minutes.json    what was requested; how long it took
scores/SUITE/NN-NAME.json  how one driver's episodes ended in a suite (`jaxwalk.evaluation.frontier_scores`)
frontier.json          all of them, with the plan and where they were made
frontier-SUITE.svg, .png   the plots
frontier.md            who is dominated, in words, and the tables (`jaxwalk.report.frontier_page`)
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import chain
from pathlib import Path

from rich.console import Console

from jaxwalk.evaluation import evaluate, named
from jaxwalk.evaluation.frontier_scores import Contender, FrontierSuite, scores_of_rows
from jaxwalk.evaluation.reading import Origin, as_document
from jaxwalk.interfaces import Policy
from jaxwalk.policies.knobs import KNOBS
from jaxwalk.policies.policy_names import ON_THE_FRONTIER
from jaxwalk.policies.shield_names import SHIELD_NAMES, unshielded
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.provenance import provenance
from jaxwalk.recipes import RECIPES
from jaxwalk.report.figures.frontier_plot import draw_frontiers
from jaxwalk.report.frontier_page import frontier_page
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.runs.effort import Effort
from jaxwalk.runs.folder import RunError
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.runs.study import Work
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.observation import PRIVILEGED_SETS
from jaxwalk.sim.suites import SUITES
from jaxwalk.wording import counted
from jaxwalk.writing import write_whole

SUITES_COMPARED = ("paper", "town", "blind-corner")
"""The suites, unless others are named."""
SCORES, RESULT, PAGE = "scores", "frontier.json", "frontier.md"


@dataclass(frozen=True)
class FrontierEffort(Effort):
    """The size of the study. Nothing is trained."""

    episodes: int = 2000
    seed: int = 73
    suites: tuple[str, ...] = SUITES_COMPARED
    drivers: tuple[str, ...] = ON_THE_FRONTIER
    shields: tuple[str, ...] = SHIELD_NAMES
    """The shields around drivers without a knob."""
    pedestrians: str = "always-go"
    own_settings: bool = False
    """Whether drivers with a knob play with their own setting alone."""


@dataclass(frozen=True)
class FrontierWork(Work[FrontierEffort]):
    """The study in a folder."""

    command = "frontier"

    trust: bool = False
    """Whether to load drivers from files that can run any code."""


@dataclass(frozen=True)
class Entrant:
    """A contender, and how its policy is made for a street."""

    contender: Contender
    make: Callable[[Street], Policy]


def frontier_study(folder: Path, plan: FrontierEffort, *, console: Console | None = None, trust: bool = False) -> Path:
    """Play whatever is missing in the folder; return the page's path.

    Args:
        folder: created if missing; what is there is kept.
        plan: how much to play.
        console: where progress is told (default: standard error).
        trust: also load drivers from files that can run any code.

    Raises:
        KeyboardInterrupt: on Ctrl-C; the drivers that were played are kept.
        RunError: the folder was begun with another plan, or something in it is damaged.
    """
    work = FrontierWork(folder, plan, console or Console(stderr=True), RECIPES["fast"], trust)  # trains nothing
    work.do([("everybody in every suite", _play), ("plots and tables", _write)])
    return folder / PAGE


def entrants(plan: FrontierEffort, *, trust: bool = False) -> list[Entrant]:
    """Return everybody who plays: each driver with its knob turned, or bare and behind each shield if it has none."""
    found: list[Entrant] = []
    for driver in dict.fromkeys(plan.drivers):
        if driver in KNOBS and plan.own_settings:
            found.append(_named(driver, driver, trust))
            continue
        if driver in KNOBS:
            found += [_turned(driver, setting) for setting in KNOBS[driver].settings]
            continue
        shielded = unshielded("driver", driver)[1] is not None
        shields = () if shielded else tuple(dict.fromkeys(plan.shields))
        found += [_named(driver, name, trust) for name in (driver, *(f"{driver}+{shield}" for shield in shields))]
    return found


def _turned(driver: str, setting: float) -> Entrant:
    """Return a driver with a setting of its knob."""
    knob = KNOBS[driver]
    return Entrant(
        Contender(knob.label(driver, setting), driver),
        lambda street: with_limits(knob.turned(setting), street.config),
    )


def _named(family: str, name: str, trust: bool) -> Entrant:
    """Return a driver as `contestant` finds it, of a family."""
    return Entrant(Contender(name, family), lambda street: contestant(street, "driver", name, trust=trust))


def _play(work: FrontierWork) -> None:
    everybody, plan = entrants(work.plan, trust=work.trust), work.plan
    suites = tuple(dict.fromkeys(plan.suites))
    missing = {
        suite: [one for one in enumerate(everybody) if work.json(_file(suite, one[0], one[1].contender)) is None]
        for suite in suites
    }
    cells, to_play = len(everybody) * len(suites), sum(map(len, missing.values()))
    size = f"{counted(len(everybody), 'driver')}, {counted(len(suites), 'suite')}, {plan.episodes:,} scenarios each"
    there = (cells - to_play) * plan.episodes
    work.say(f"    {size}: {counted(cells * plan.episodes, 'episode')}, {there:,} of them there already")
    clock = Remaining(to_play)
    for suite, some in missing.items():
        if some:
            _play_suite(work, suite, some, clock)


class Remaining:
    """Says how long the rest will take, if it takes as long as what was played so far."""

    def __init__(self, parts: int) -> None:
        """Start the clock, with this many parts to play."""
        self.parts, self.done, self.begun = parts, 0, time.monotonic()

    def after_one_more(self) -> str:
        """Return how far it is in words, after another part."""
        self.done += 1
        said = f"{self.done:,} of {self.parts:,}"
        if self.done == self.parts:
            return said
        left = (time.monotonic() - self.begun) / self.done * (self.parts - self.done)
        return f"{said}, about {counted(math.ceil(left / 60), 'minute')} left"


def _play_suite(work: FrontierWork, suite: str, some: Sequence[tuple[int, Entrant]], clock: Remaining) -> None:
    """Play some drivers in a suite, and keep the scores of each."""
    plan = work.plan
    street = world_of(plan.drivers, SUITES[suite])
    source, people = Drawn(street, plan.seed, plan.episodes), contestant(street, "pedestrian", plan.pedestrians)
    (work.folder / SCORES / suite).mkdir(parents=True, exist_ok=True)
    for number, entrant in some:
        driver, who = entrant.make(street), entrant.contender
        with named({"driver": who.name, "pedestrian": plan.pedestrians}):
            rows = evaluate(street, {"driver": driver, "pedestrian": people}, source)
        scores = scores_of_rows(replace(who, hidden=driver.view.name in PRIVILEGED_SETS), rows)
        found = FrontierSuite(suite, plan.pedestrians, source.hash(), (scores,))
        work.keep(_file(suite, number, who), asdict(found))
        work.say(f"    {suite}: {who.name}; {clock.after_one_more()}")


def _file(suite: str, number: int, who: Contender) -> str:
    """Return the name of the file of a driver's scores; characters that don't suit a file's name become dashes."""
    return f"{SCORES}/{suite}/{number:02d}-{re.sub(r'[^0-9A-Za-z.+]+', '-', who.name)}.json"


def _write(work: FrontierWork) -> None:
    plan, made = work.plan, provenance()
    suites = [_joined(work, suite) for suite in dict.fromkeys(plan.suites)]
    origins = [policy_origin("driver", name) for name in dict.fromkeys(plan.drivers)]
    document = {"plan": asdict(plan), "made": asdict(made), "drivers": [asdict(one) for one in origins]}
    work.keep(RESULT, document | {"suites": [asdict(one) for one in suites]})
    draw_frontiers(suites, work.folder)
    write_whole(work.folder / PAGE, frontier_page(suites, seed=plan.seed, origins=origins, made=made))


def _joined(work: FrontierWork, suite: str) -> FrontierSuite:
    """Return the scores of everybody in a suite. Raise RunError if files are of different scenarios."""
    parts = [_read(work, _file(suite, number, one.contender)) for number, one in enumerate(entrants(work.plan))]
    if len({part.scenario_hash for part in parts}) > 1:
        folder = work.folder / SCORES / suite
        raise RunError(f"{folder}: files of different scenarios; delete it and run `jaxwalk {work.command}` again")
    return replace(parts[0], scores=tuple(chain.from_iterable(part.scores for part in parts)))


def _read(work: FrontierWork, file: str) -> FrontierSuite:
    origin = Origin(work.folder / file, f"delete it and run `jaxwalk {work.command}` again")
    return as_document(FrontierSuite, work.json(file), origin)
