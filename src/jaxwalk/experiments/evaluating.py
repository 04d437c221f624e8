"""`jaxwalk evaluate`: play every driver among every population, compare two, replay collisions, write the results.

results.json            all numbers (`jaxwalk.evaluation.Results`)
suite.md                the same as tables (`jaxwalk.report.suite`)
episodes.csv            a row per episode; with several jaywalk multipliers a file for each
encounters.parquet      a row per encounter, if asked for
episodes-partial.csv    whole batches of an evaluation that a policy's error ended
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from jaxwalk.evaluation import (
    Cell,
    ComparedEnding,
    Match,
    Results,
    Stopped,
    compare_endings,
    counterfactuals,
    evaluate_grid,
    find_hits,
    jaywalk_multiplier,
    named,
    paired,
    summarise_counterfactuals,
    with_jaywalk_multiplier,
    write_encounters,
    write_rows,
)
from jaxwalk.evaluation.document_parts import EvaluationOptions
from jaxwalk.evaluation.shield_effects import shield_effects
from jaxwalk.experiments.tournament import Scenarios
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.metrics import Rows
from jaxwalk.provenance import provenance
from jaxwalk.report.suite import suite
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.scenarios import Archived, Drawn, Source
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import ContactRule
from jaxwalk.wording import counted
from jaxwalk.writing import together, write_whole

Tell = Callable[[str, int, int], None]
"""Called with the current task, how much of it is done, and the total."""
Played = dict[tuple[str, str], Rows]
"""The rows of one street, by driver and population."""


@dataclass(frozen=True)
class Evaluation:
    """What to evaluate, and which results to keep."""

    streets: tuple[Street, ...]
    """The same street with each jaywalk multiplier."""
    drivers: Mapping[str, Policy]
    populations: Mapping[str, Policy]
    scenarios: Scenarios | Archived
    """What everybody plays: drawn scenarios, or kept ones of the only street."""
    options: EvaluationOptions
    out: Path | None = None
    """Folder to write into; None writes nothing."""

    @property
    def episodes(self) -> int:
        """Return the number of scenarios in each cell."""
        return self.scenarios.episodes if isinstance(self.scenarios, Scenarios) else len(self.scenarios)

    def source(self, street: Street) -> Source:
        """Return the scenarios on one of the streets."""
        if isinstance(self.scenarios, Scenarios):
            return Drawn(street, self.scenarios.seed, self.scenarios.episodes)
        return self.scenarios


def prepared(
    street: Street, names: tuple[Sequence[str], Sequence[str]], scenarios: Scenarios | Archived,
    options: EvaluationOptions,
    *, out: Path | None, **loading: Any,
) -> Evaluation:  # fmt: skip
    """Return an evaluation with all policies loaded.

    Args:
        street: where it is.
        names: of the drivers and of the populations, as `contestant` takes them.
        scenarios: how many, and their seed; or kept ones.
        options: everything else that was asked for.
        out: folder to write into, if any.
        loading: how `contestant` loads drivers (``trust``, ``seconds``).
    """
    drivers, populations = names
    car, people = options.driver_acts == "sample", options.pedestrians_act == "sample"
    return Evaluation(
        streets=tuple(with_jaywalk_multiplier(street, x) for x in options.jaywalk_multipliers),
        drivers={name: contestant(street, "driver", name, sample=car, **loading) for name in drivers},
        populations={name: contestant(street, "pedestrian", name, sample=people) for name in populations},
        scenarios=scenarios,
        options=options,
        out=out,
    )


def evaluate_all(work: Evaluation, tell: Tell) -> Results:
    """Evaluate, and write the requested files; return all results.

    Results are written before collisions are replayed, which takes long, and once more afterwards.

    Raises:
        Stopped: a policy failed; the message says what was kept.
    """
    drivers = tuple(policy_origin("driver", name) for name in work.drivers)  # before they can change
    populations = tuple(policy_origin("pedestrian", name) for name in work.populations)
    results, rows = _play(work, tell)
    results = replace(results, drivers=drivers, populations=populations, options=work.options, made=provenance())
    results = with_comparisons(results, rows, work.options.compare, work.streets[0].config.contact)
    if work.out:
        keep_evaluation(work.out, results, rows, encounters=work.options.encounters)
    if work.options.counterfactuals:
        results = replace(results, cells=_replayed(work, results.cells, rows, tell))
        if work.out:
            _keep_results(work.out, results)
    return results


def with_comparisons(
    results: Results, rows: list[Played], compare: tuple[str, str] | None, contact: ContactRule
) -> Results:
    """Return results with a comparison of two drivers, if asked for, and with what shields change.

    ``rows`` are those of the cells, for each jaywalk multiplier; ``contact`` is the rule by which a contact counts.
    """
    groups = list(zip(_multipliers(results, rows), rows, strict=True))
    shields = tuple(effect for multiplier, played in groups for effect in shield_effects(played, multiplier, contact))
    return replace(results, shields=shields, compared=_compared(*compare, groups) if compare else ())


def keep_evaluation(out: Path, results: Results, rows: list[Played], *, encounters: bool) -> None:
    """Write all files of an evaluation; ``rows`` are as in `with_comparisons`."""
    multipliers = _multipliers(results, rows)
    with together():
        _write_episodes(out / "episodes", multipliers, rows)
        if encounters:
            groups = zip(multipliers, rows, strict=True)
            cells = [(*pair, multiplier, found) for multiplier, played in groups for pair, found in played.items()]
            write_encounters(out / "encounters.parquet", cells)
        _keep_results(out, results)


def _multipliers(results: Results, rows: list[Played]) -> list[float]:
    """Return the jaywalk multiplier of each group of rows, whose cells come one group after the other."""
    return [cell.jaywalk_multiplier for cell in results.cells[:: len(rows[0])]]


def _play(work: Evaluation, tell: Tell) -> tuple[Results, list[Played]]:
    """Return the results of all streets together, and the rows of each."""
    total = len(work.streets) * len(work.drivers) * len(work.populations) * work.episodes
    found: list[Results] = []
    rows: list[Played] = []
    before = 0

    def progress(driver: str, population: str, played: int, episodes: int) -> None:
        nonlocal before
        tell(f"{driver} among {population}", before + played, total)
        before += episodes if played >= episodes else 0

    for street in work.streets:
        try:
            results, played = evaluate_grid(
                street, work.drivers, work.populations, work.source(street), progress=progress
            )
        except Stopped as stopped:
            rows.append(stopped.rows)
            raise Stopped(f"{stopped}; {_keep_unfinished(work, rows)}", stopped.rows) from stopped
        found.append(results)
        rows.append(played)
    return replace(found[0], cells=tuple(cell for results in found for cell in results.cells)), rows


def _compared(a: str, b: str, groups: list[tuple[float, Played]]) -> tuple[ComparedEnding, ...]:
    """Compare two drivers among every population with every jaywalk multiplier."""
    among = [
        (people, multiplier, paired(played[a, people], played[b, people]))
        for multiplier, played in groups
        for people in dict.fromkeys(people for _, people in played)
    ]
    return compare_endings(a, b, among)


def _replayed(work: Evaluation, cells: tuple[Cell, ...], rows: list[Played], tell: Tell) -> tuple[Cell, ...]:
    """Return the cells with the changes that would have avoided their collisions."""
    played = [
        (street, *pair, found)
        for street, by_pair in zip(work.streets, rows, strict=True)
        for pair, found in by_pair.items()
    ]
    replayed = []
    for number, (cell, (street, driver, people, found)) in enumerate(zip(cells, played, strict=True)):
        tell(f"replaying collisions of {driver} among {people}", number, len(cells))
        policies = {"driver": work.drivers[driver], "pedestrian": work.populations[people]}
        source = work.source(street)
        replayed.append(replayed_cell(street, policies, source, Match(cell, found), work.options.counterfactuals))
    return tuple(replayed)


def replayed_cell(street: Street, policies: Roles[Policy], source: Source, match: Match, most: int) -> Cell:
    """Return the cell with what would have avoided its first ``most`` collisions. Raises as `counterfactuals` does."""
    with named({"driver": match.cell.driver, "pedestrian": match.cell.pedestrians}):
        table = counterfactuals(street, policies, source, find_hits(match.rows).first(most))
    return replace(match.cell, counterfactuals=summarise_counterfactuals(table))


def _keep_unfinished(work: Evaluation, rows: list[Played]) -> str:
    """Write what was evaluated before a driver failed, in whole batches; return a description of what was kept."""
    episodes = sum(found.episodes for played in rows for found in played.values())
    if not episodes:
        return "no batch had been finished before"
    if work.out is None:
        return f"--out DIR would have kept the {counted(episodes, 'episode')} evaluated before"
    with together():
        files = _write_episodes(work.out / "episodes-partial", list(map(jaywalk_multiplier, work.streets)), rows)
    return f"what was evaluated before, {counted(episodes, 'episode')}, is kept in {', '.join(map(str, files))}"


def _write_episodes(name: Path, multipliers: list[float], rows: list[Played]) -> list[Path]:
    """Write a row per episode, in one file for each multiplier; ``rows`` may cover only the first ones."""
    name.parent.mkdir(parents=True, exist_ok=True)
    files = []
    for multiplier, played in zip(multipliers, rows, strict=False):
        suffix = f"-x{multiplier:g}" if len(multipliers) > 1 else ""
        files.append(name.with_name(f"{name.name}{suffix}.csv"))
        write_rows(files[-1], [(*pair, found) for pair, found in played.items()])
    return files


def _keep_results(out: Path, results: Results) -> None:
    """Write the results, and their tables."""
    with together():
        write_whole(out / "suite.md", suite(results, results.made or provenance()))
        write_whole(out / "results.json", results.to_json())
