"""`jaxwalk search`: search for failures of a driver, judge and explain them, and write what was found.

search.html              the grid of encounters, and a replay behind each of the worst failures
search.json              all numbers (`jaxwalk.search.found_failures`)
failures.csv             a row for each failure
scenarios.safetensors    the failures as scenarios, for `jaxwalk evaluate --scenarios`
minimised.safetensors    the worst ones with as few people and as ordinary draws as still fail
state.safetensors        the search, to go on
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.evaluation import BATCH, named
from jaxwalk.evaluation.document_parts import StreetOrigin
from jaxwalk.exports.replays import page_document, recording
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.maps import map_labels
from jaxwalk.provenance import provenance
from jaxwalk.report.search_page import write_search_page
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.scenarios.archive_file import SCENARIOS, write_archive
from jaxwalk.scenarios.archived import Archived
from jaxwalk.search.cube import Candidates
from jaxwalk.search.driving import SMALL_PART, Driving
from jaxwalk.search.found_failures import FoundFailure, SearchResults
from jaxwalk.search.grid import in_words
from jaxwalk.search.hunt import (
    STATE,
    Hunt,
    MethodName,
    begun,
    keep_hunt,
    kept_hunt,
    method_of,
    play_generation,
)
from jaxwalk.search.judging import judge
from jaxwalk.search.minimising import Minimised, minimise
from jaxwalk.sim.environment import Street
from jaxwalk.writing import remove_unfinished, together, write_whole

MINIMISED = "minimised.safetensors"
WATCHED = 60
"""Most failures with a replay: a page with more is slow to open."""
Tell = Callable[[str, int, int], None]
"""Called with what is being done, how much of it is done, and the total."""


@dataclass(frozen=True)
class FailureSearch:
    """What to search."""

    street: Street
    drivers: Mapping[str, Policy]
    """The driver, by its name."""
    people: Mapping[str, Policy]
    """The population, by its name."""
    method: MethodName
    simulations: int
    """How many scenarios to play; rounded up to whole generations, which are batches of an evaluation."""
    minimise: int
    """How many failures to explain, the worst first."""
    seed: int
    out: Path

    @property
    def names(self) -> Roles[str]:
        """Return the names of both."""
        return {"driver": next(iter(self.drivers)), "pedestrian": next(iter(self.people))}

    def driving(self, most: int | None = None) -> Driving:
        """Return what is searched, played as many candidates at once as in an evaluation, but at ``most`` this many."""
        names = self.names
        policies = {"driver": self.drivers[names["driver"]], "pedestrian": self.people[names["pedestrian"]]}
        return Driving(self.street, policies, self.seed, batch=min(BATCH, most or BATCH))

    def plan(self) -> dict[str, Any]:
        """Return what must be the same when a search goes on, as JSON."""
        street = StreetOrigin.of(self.street)
        origins = {role: asdict(policy_origin(role, name)) for role, name in self.names.items()}
        where = {"maps": [found.hash for found in street.maps], "sim": asdict(street.sim)}
        return {**origins, "street": where, "method": self.method, "seed": self.seed, "generation": BATCH}


def search_failures(work: FailureSearch, tell: Tell) -> SearchResults:
    """Search, judge, explain and write everything; return the results.

    Interrupted, it goes on where it stopped if it is called again; and with more simulations, if more are asked for.

    Raises:
        ArchiveError: the folder keeps another search, or is damaged.
        KeyboardInterrupt: on Ctrl-C; whole generations are kept.
        DriverError, ActionError: a policy failed.
    """
    remove_unfinished(work.out)
    with named(work.names):
        game = work.driving()
        hunt = _hunted(work, game, tell)
        return _keep(work, game, hunt, tell)


def _hunted(work: FailureSearch, game: Driving, tell: Tell) -> Hunt:
    """Return the search after all its generations."""
    method, plan, path = method_of(work.method, game), work.plan(), work.out / STATE
    hunt = begun(game, method)
    if path.exists():
        hunt = kept_hunt(path, hunt, plan)
    while hunt.simulations < work.simulations:
        cells = int(hunt.elites.best_failures.sum())
        tell(f"searching: {cells} kinds of failure", hunt.simulations, work.simulations)
        play_generation(game, method, hunt, work.seed)
        keep_hunt(path, hunt, plan)
    return hunt


def _keep(work: FailureSearch, game: Driving, hunt: Hunt, tell: Tell) -> SearchResults:
    """Judge and explain the failures that a search has found, and write all files."""
    found = hunt.elites.candidates.some(hunt.elites.best_failures)
    failures, kept = _judged(work, game, found, tell) if len(found) else ([], found)
    some = min(work.minimise, len(failures))
    minimal = None
    if some:
        peds = np.array([one.ped for one in failures[:some]])
        minimal = minimise(
            work.driving(SMALL_PART), kept.some(slice(some)), peds, lambda done: tell("minimising failures", done, 0)
        )
        failures = [*map(_explained, failures[:some], range(some), [minimal] * some), *failures[some:]]
    source = _archived(work, kept) if failures else None
    results = SearchResults(
        driver=policy_origin("driver", work.names["driver"]),
        pedestrians=policy_origin("pedestrian", work.names["pedestrian"]),
        method=work.method, seed=work.seed, log=tuple(hunt.log), failures=tuple(failures),
        hash=source.hash() if source else None, street=StreetOrigin.of(work.street), made=provenance(),
    )  # fmt: skip
    tell("recording replays and writing", 0, 0)
    _write(work, results, source, minimal)
    return results


def _judged(work: FailureSearch, game: Driving, found: Candidates, tell: Tell) -> tuple[list[FoundFailure], Candidates]:
    """Return the failures, the worst first, and their candidates in the same order."""
    tell("playing failures again", 0, 0)
    played = game.play(found)
    moments, count = played.moments, len(found)
    avoided = judge(
        game, found, moments, batch=min(BATCH, SMALL_PART), tell=lambda n: tell("who would avoid them?", n, count)
    )
    labels = map_labels(work.street.maps)
    scenarios, _ = _archived(work, found).take(np.arange(len(found)))
    failures = [
        FoundFailure(
            scenario=row, cell=cell, contact=in_words(cell).contact,
            speed=round(3.6 * float(moments.speed[row]), 3),
            time=round(float(moments.time[row]), 3) if np.isfinite(moments.time[row]) else None,
            bearing=round(float(np.degrees(moments.bearing[row])), 2),
            map=labels[int(scenarios.map[row])], ped=int(moments.ped[row]),
            percentile=float(played.percentiles[row]), judged=str(avoided.when_seen[row]),
            judged_from_start=str(avoided.from_start[row]),
        )
        for row, cell in enumerate(moments.cell.tolist())
    ]  # fmt: skip
    failures.sort(key=lambda one: (not (one.avoidable and one.plausible), -one.speed, one.cell))
    order = np.array([one.scenario for one in failures])
    return [replace(one, scenario=number) for number, one in enumerate(failures)], found.some(order)


def _explained(failure: FoundFailure, row: int, minimal: Minimised) -> FoundFailure:
    """Return a failure with what its minimal scenario says."""
    return replace(
        failure,
        people=int(minimal.present[row].sum()),
        changed=int(minimal.changed[row]),
        minimal_percentile=float(minimal.played.percentiles[row]) if minimal.played.moments.failed[row] else None,
    )


def _archived(work: FailureSearch, kept: Candidates, present: np.ndarray | None = None) -> Archived:
    people = work.street.world.rules.pedestrians
    there = np.ones((len(kept), people), bool) if present is None else present
    return Archived(work.street, kept.points, there, work.seed, kept.keys)


def _write(work: FailureSearch, results: SearchResults, source: Archived | None, minimal: Minimised | None) -> None:
    """Write the page, the document, the table and the scenarios."""
    about = {"search": work.plan()}
    document = page_document(work.street, [])
    if source is not None:
        numbers = list(range(min(WATCHED, len(source))))
        document = recording(work.street, work.drivers, work.people, {work.names["pedestrian"]: numbers}, source)
    with together():
        write_search_page(work.out / "search.html", results, document)
        write_whole(work.out / "search.json", results.to_json())
        write_whole(work.out / "failures.csv", results.to_csv())
        if source is not None:
            write_archive(work.out / SCENARIOS, source, about)
        if minimal is not None:
            write_archive(work.out / MINIMISED, _archived(work, minimal.candidates, minimal.present), about)
