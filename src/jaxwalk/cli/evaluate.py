"""``jaxwalk evaluate``."""

from __future__ import annotations

import json
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from rich.box import SIMPLE
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from jaxwalk.cli.options import Evaluate, Share, UsageError
from jaxwalk.cli.train import bad_values
from jaxwalk.evaluation import (
    BATCH,
    Stopped,
    check_parquet,
    compare,
    compared,
    counterfactuals,
    find_hits,
    jaywalk_multiplier,
    paired,
    summarise_counterfactuals,
    with_jaywalk_multiplier,
    write_encounters,
    write_rows,
)
from jaxwalk.interfaces import Policy
from jaxwalk.metrics import Rows
from jaxwalk.report.suite import said, suite
from jaxwalk.report.table import shown
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.runs.folder import check_writable
from jaxwalk.runs.lock import held
from jaxwalk.runs.provenance import provenance
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.observation import HIDDEN
from jaxwalk.writing import write_whole

Played = dict[tuple[str, str], Rows]


def run(options: Evaluate) -> int:
    """Evaluate and show; nothing is written unless ``--out`` says where."""
    check(options)
    drivers = tuple(dict.fromkeys((*options.driver, *options.compare)))
    names = [*drivers, *options.pedestrians]
    with bad_values():
        streets = _streets(world_of(names, options.map), options.jaywalk_multiplier)
        chosen = {"sample": options.sample_driver or None, "trust": options.trust, "seconds": options.driver_seconds}
        cars = {x: contestant(streets[0], "driver", x, **chosen) for x in drivers}
        people_sample = False if options.pedestrian_mode else None
        people = {x: contestant(streets[0], "pedestrian", x, sample=people_sample) for x in options.pedestrians}
    with held(options.out) if options.out else nullcontext():
        document = _evaluate(options, streets, cars, people)
    if options.json:
        print(_text(document), end="")
    else:
        console = Console()
        console.width = max(console.width, 132)  # the numbers need it; a narrower terminal wraps
        lines = [*said(document), *cost_lines(document), document_line(document)]
        console.print(table(document), *map(escape, lines), sep="\n")
    return 0


def _evaluate(
    options: Evaluate, streets: list[Street], cars: dict[str, Policy], people: dict[str, Policy]
) -> dict[str, Any]:
    """The document, written as it grows if ``--out`` says where."""
    document, rows = _play(options, streets, cars, people)
    if options.compare:
        document["compared"] = _compared(options, streets, rows)
    if options.out:
        _keep_rows(options.out, streets, rows, encounters=options.encounters)
        _keep_document(options.out, document)
    if options.counterfactuals:
        _replay_collisions(options, document, streets, cars, people, rows)
    if options.counterfactuals and options.out:
        _keep_document(options.out, document)
    return document


def check(options: Evaluate) -> None:
    """Raise for options that can't be."""
    if options.compare and (len(options.compare) != 2 or len(set(options.compare)) != 2):
        raise UsageError(f"--compare needs two different drivers, not {' '.join(options.compare)}: as in --compare A B")
    if not options.driver and not options.compare:
        raise UsageError(
            "--driver is missing: a name such as co-trained or route-follower, a run folder or a policy file"
        )
    if not options.pedestrians:
        raise UsageError("--pedestrians is missing: always-go, learned, a run folder or a policy file")
    check_scenarios(options)
    if not options.jaywalk_multiplier:
        raise UsageError("--jaywalk-multiplier needs a number, such as 0.25")
    if options.counterfactuals < 0:
        raise UsageError(f"--counterfactuals must be 0 or more, not {options.counterfactuals}")
    if options.encounters and not options.out:
        raise UsageError("--encounters needs --out DIR, where encounters.parquet is to be")
    if options.encounters:
        check_parquet()
    if options.out:
        check_writable(options.out)


def check_scenarios(options: Evaluate | Share) -> None:
    """Raise for a number or a seed of scenarios that can't be."""
    if options.episodes < 1:
        raise UsageError(f"--episodes must be at least 1, not {options.episodes}")
    if not 0 <= options.seed < 2**31:
        raise UsageError(f"--seed must lie in [0, 2^31), not {options.seed}")


def _streets(street: Street, multipliers: tuple[float, ...]) -> list[Street]:
    return [with_jaywalk_multiplier(street, x) for x in dict.fromkeys(multipliers)]


def _play(
    options: Evaluate, streets: list[Street], drivers: dict[str, Policy], people: dict[str, Policy]
) -> tuple[dict[str, Any], list[Played]]:
    """The document of all cells, and the rows of each street."""
    total = len(streets) * len(drivers) * len(people) * options.episodes
    documents, rows = [], []
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task, before = bar.add_task("evaluating", total=total), 0

        def tell(driver: str, population: str, played: int, episodes: int) -> None:
            nonlocal before
            bar.update(task, description=escape(f"{driver} among {population}"), completed=before + played)
            before += episodes if played >= episodes else 0

        for street in streets:
            try:
                found, played = compare(
                    street, drivers, people, Drawn(street, options.seed, options.episodes), progress=tell
                )
            except Stopped as stopped:
                kept = _keep_unfinished(options.out, streets, [*rows, stopped.rows])
                raise UsageError(f"{stopped}; {kept}") from stopped
            documents.append(found.as_dict())
            rows.append(played)
    cells = [cell for document in documents for cell in document["cells"]]
    return {**documents[0], "cells": cells}, rows


def _replay_collisions(
    options: Evaluate,
    document: dict[str, Any],
    streets: list[Street],
    drivers: dict[str, Policy],
    people: dict[str, Policy],
    rows: list[Played],
) -> None:
    """Add to every cell of the document what would have avoided its collisions."""
    played = [
        (street, *pair, found) for street, cells in zip(streets, rows, strict=True) for pair, found in cells.items()
    ]
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("replaying collisions", total=len(played))
        for cell, (street, driver, population, found) in zip(document["cells"], played, strict=True):
            bar.update(task, description=escape(f"replaying collisions of {driver} among {population}"))
            replayed = counterfactuals(
                street,
                {"driver": drivers[driver], "pedestrian": people[population]},
                Drawn(street, options.seed, options.episodes),
                find_hits(found).first(options.counterfactuals),
            )
            cell["counterfactuals"] = summarise_counterfactuals(replayed).as_dict()
            bar.advance(task)


def _compared(options: Evaluate, streets: list[Street], rows: list[Played]) -> list[dict[str, Any]]:
    """The two drivers of ``--compare``, among every population on every street."""
    a, b = options.compare
    among = [
        (people, jaywalk_multiplier(street), paired(played[a, people], played[b, people]))
        for street, played in zip(streets, rows, strict=True)
        for people in dict.fromkeys(options.pedestrians)
    ]
    return compared(a, b, among)


def _keep_unfinished(out: Path | None, streets: list[Street], rows: list[Played]) -> str:
    """Write what was evaluated before a driver failed, whole batches; says what became of it."""
    episodes = sum(found.episodes for played in rows for found in played.values())
    if not episodes:
        return "no batch had been finished before"
    if out is None:
        return f"{episodes:,} episodes had been evaluated before: --out DIR would keep them"
    out.mkdir(parents=True, exist_ok=True)
    files = _write_episodes(out, "episodes-partial", streets, rows)
    return f"the {episodes:,} episodes evaluated before are kept in {', '.join(map(str, files))}"


def _write_episodes(out: Path, name: str, streets: list[Street], rows: list[Played]) -> list[Path]:
    """A row per episode, in a file for each multiplier; ``rows`` may be of the first streets only."""
    files = []
    for street, played in zip(streets, rows, strict=False):
        suffix = f"-x{float(street.world.jaywalk_multiplier):g}" if len(streets) > 1 else ""
        files.append(out / f"{name}{suffix}.csv")
        write_rows(files[-1], [(*pair, found) for pair, found in played.items()])
    return files


def _keep_rows(out: Path, streets: list[Street], rows: list[Played], *, encounters: bool) -> None:
    """Write a row per episode for each multiplier, and a row per encounter if asked for."""
    out.mkdir(parents=True, exist_ok=True)
    _write_episodes(out, "episodes", streets, rows)
    if encounters:
        of_street = zip(map(jaywalk_multiplier, streets), rows, strict=True)
        cells = [(*pair, multiplier, found) for multiplier, played in of_street for pair, found in played.items()]
        write_encounters(out / "encounters.parquet", cells)


def _keep_document(out: Path, document: dict[str, Any]) -> None:
    """Write the document, and the same as tables."""
    write_whole(out / "suite.md", suite(document, provenance()))
    write_whole(out / "results.json", _text(document))


def _text(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def table(document: dict[str, Any]) -> Table:
    """The cells as a table with 95 % intervals."""
    multipliers = {cell["jaywalk_multiplier"] for cell in document["cells"]}
    made = Table(title="95 % intervals in brackets", box=SIMPLE, padding=(0, 1))
    for name in ("driver", "pedestrians"):
        made.add_column(name, overflow="fold")
    if len(multipliers) > 1:
        made.add_column("multiplier", justify="right")
    for name in ("goal %", "collision %", "timeout %", "time to goal [s]"):
        made.add_column(escape(name), justify="right", no_wrap=True)
    for cell in document["cells"]:
        extra = [f"{cell['jaywalk_multiplier']:g}"] if len(multipliers) > 1 else []
        rates = [escape(shown(cell[name])) for name in ("goal_rate", "collision_rate", "timeout_rate")]
        observes = cell["driver_observes"]
        names = cell["driver"] + (f" ({observes})" if observes in HIDDEN else ""), cell["pedestrians"]
        time = shown(cell["mean_time_to_goal"], 1.0)
        made.add_row(*map(escape, names), *extra, *rates, escape(time))
    return made


def cost_lines(document: dict[str, Any]) -> list[str]:
    """What each driver that is not JAX took for a step, in each of its cells."""
    costs: dict[str, list[float]] = {}
    for cell in document["cells"]:
        if "driver_ms_per_step" in cell:
            costs.setdefault(cell["driver"], []).append(cell["driver_ms_per_step"])
    return [
        f"{driver}: {', '.join(f'{cost:.3g}' for cost in each)} ms for a step of {BATCH} episodes"
        for driver, each in costs.items()
    ]


def document_line(document: dict[str, Any]) -> str:
    """Which scenarios it was."""
    chosen = document["scenarios"]
    return f"{chosen['count']:,} scenarios of seed {chosen['seed']}, hash {chosen['hash']}"
