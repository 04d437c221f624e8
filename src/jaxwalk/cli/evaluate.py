"""``jaxwalk evaluate``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rich.box import SIMPLE
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from jaxwalk.cli.options import Evaluate, Share, UsageError
from jaxwalk.cli.train import bad_values
from jaxwalk.evaluation import compare, with_jaywalk_multiplier, write_rows
from jaxwalk.experiments.contestants import contestant, world_of
from jaxwalk.experiments.runs import check_writable, write_whole
from jaxwalk.interfaces import Policy
from jaxwalk.metrics import Rows
from jaxwalk.sim.environment import Street
from jaxwalk.sim.observation import HIDDEN

Played = dict[tuple[str, str], Rows]


def run(options: Evaluate) -> int:
    """Evaluate and show; nothing is written unless ``--out`` says where."""
    check(options)
    names = [*options.driver, *options.pedestrians]
    with bad_values():
        streets = _streets(world_of(names, options.map), options.jaywalk_multiplier)
        driver_samples = True if options.sample_driver else None
        drivers = {x: contestant(streets[0], "driver", x, sample=driver_samples) for x in options.driver}
        people_sample = False if options.pedestrian_mode else None
        people = {x: contestant(streets[0], "pedestrian", x, sample=people_sample) for x in options.pedestrians}
    document, rows = _play(options, streets, drivers, people)
    text = json.dumps(document, indent=2, allow_nan=False) + "\n"
    if options.out:
        _keep(options.out, text, streets, rows)
    if options.json:
        print(text, end="")
    else:
        console = Console()
        console.width = max(console.width, 120)  # the numbers need it; a narrower terminal wraps
        console.print(table(document), document_line(document), sep="\n")
    return 0


def check(options: Evaluate) -> None:
    """Raise for options that can't be."""
    if not options.driver:
        raise UsageError(
            "--driver is missing: a name such as co-trained or route-follower, a run folder or a policy file"
        )
    if not options.pedestrians:
        raise UsageError("--pedestrians is missing: always-go, learned, a run folder or a policy file")
    check_scenarios(options)
    if not options.jaywalk_multiplier:
        raise UsageError("--jaywalk-multiplier needs a number, such as 0.25")
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
            bar.update(task, description=f"{driver} among {population}", completed=before + played)
            before += episodes if played >= episodes else 0

        for street in streets:
            found, played = compare(
                street, drivers, people, episodes=options.episodes, seed=options.seed, progress=tell
            )
            documents.append(found.as_dict())
            rows.append(played)
    cells = [cell for document in documents for cell in document["cells"]]
    return {**documents[0], "cells": cells}, rows


def _keep(out: Path, text: str, streets: list[Street], rows: list[Played]) -> None:
    """Write the document, and a row per episode for each multiplier."""
    out.mkdir(parents=True, exist_ok=True)
    for street, played in zip(streets, rows, strict=True):
        suffix = f"-x{float(street.jaywalk_multiplier):g}" if len(streets) > 1 else ""
        write_rows(out / f"episodes{suffix}.csv", [(*pair, found) for pair, found in played.items()])
    write_whole(out / "results.json", text)


def table(document: dict[str, Any]) -> Table:
    """The cells as a table with 95 % intervals."""
    multipliers = {cell["jaywalk_multiplier"] for cell in document["cells"]}
    shown = Table(title="95 % intervals in brackets", box=SIMPLE, padding=(0, 1))
    for name in ("driver", "pedestrians"):
        shown.add_column(name, overflow="fold")
    if len(multipliers) > 1:
        shown.add_column("multiplier", justify="right")
    for name in ("goal %", "collision %", "timeout %", "time to goal [s]"):
        shown.add_column(escape(name), justify="right", no_wrap=True)
    for cell in document["cells"]:
        extra = [f"{cell['jaywalk_multiplier']:g}"] if len(multipliers) > 1 else []
        rates = [percent(cell[name]) for name in ("goal_rate", "collision_rate", "timeout_rate")]
        observes = cell["driver_observes"]
        driver = cell["driver"] + (f" ({observes})" if observes in HIDDEN else "")
        shown.add_row(driver, cell["pedestrians"], *extra, *rates, seconds(cell["mean_time_to_goal"]))
    return shown


def document_line(document: dict[str, Any]) -> str:
    """Which scenarios it was."""
    chosen = document["scenarios"]
    return f"{chosen['count']:,} scenarios of seed {chosen['seed']}, hash {chosen['hash']}"


def percent(rate: dict[str, float | None]) -> str:
    """As in ``14.0 [11.2, 17.3]``."""
    return _with_interval(rate, 100.0, 1)


def seconds(number: dict[str, float | None]) -> str:
    """As in ``14.0 [11.2, 17.3]``."""
    return _with_interval(number, 1.0, 1)


def _with_interval(number: dict[str, float | None], scale: float, digits: int) -> str:
    value, low, high = (number[x] for x in ("value", "low", "high"))
    if value is None:
        return "-"
    ends = "" if low is None or high is None else f" [{scale * low:.{digits}f}, {scale * high:.{digits}f}]"
    return f"{scale * value:.{digits}f}{ends}"
