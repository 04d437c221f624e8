"""`jaxwalk report`: any drivers, evaluated, with the collisions to watch."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Sequence
from itertools import product
from pathlib import Path
from typing import Any

from jaxwalk.evaluation import Match, ReplayError, paired_over_seeds, write_rows
from jaxwalk.experiments.tournament import Scenarios, document_of, play_rounds
from jaxwalk.exports.gallery import Cast, gallery
from jaxwalk.metrics import Rows
from jaxwalk.report import write_report
from jaxwalk.runs.contestants import run_folders
from jaxwalk.runs.folder import Run
from jaxwalk.runs.lock import held
from jaxwalk.runs.provenance import provenance
from jaxwalk.writing import write_whole

MANY = 4
"""Numbers of so many drivers stand at the top of the page; the others in its tables."""


def driver_report(folder: Path, cast: Cast, *, episodes: int, most: int, say: Callable[[str], None]) -> Path:
    """Evaluate every driver among every population, and write report, figures, tables and numbers into the folder.

    Args:
        folder: made if it is not there; files of an earlier report are replaced.
        cast: who; the first driver is the one that sections about one driver are about.
        episodes: scenarios for each driver and population.
        most: incidents of each kind in the gallery, for each driver and population; 0: no gallery.
        say: called with a line as the work goes on.

    Returns:
        The path of the page.

    Raises:
        InUseError: another process writes into the folder.
    """
    with held(folder):
        return _report(folder, cast, episodes, most, say)


def _report(folder: Path, cast: Cast, episodes: int, most: int, say: Callable[[str], None]) -> Path:
    """`driver_report`, alone in the folder."""
    began = time.monotonic()
    curves = _curves(cast.drivers)
    round_ = (None, cast.drivers, cast.populations)
    start, matches = play_rounds(cast.street, [round_], Scenarios(episodes, cast.seed), say)
    results = document_of(start, matches)
    if len(cast.drivers) > 1:
        results["paired"] = _pairs(cast, matches)
    write_rows(folder / "episodes.csv", [(*match.names, match.rows) for match in matches])
    text = json.dumps(results, indent=2, allow_nan=False) + "\n"
    write_whole(folder / "results.json", text)
    watched = _gallery(cast, {match.names: match.rows for match in matches}, most, say)
    documents = {
        "results": json.loads(text),
        "curves": curves,
        "provenance": provenance(),
        "minutes": {"all": (time.monotonic() - began) / 60},
        "subject": next(iter(cast.drivers)),
        "headline": tuple(cast.drivers)[:MANY],
        "gallery": watched,
    }
    say("    drawing")
    return write_report(folder, documents)


def _gallery(
    cast: Cast, played: dict[tuple[str, str], Rows], most: int, say: Callable[[str], None]
) -> dict[str, Any] | None:
    """The gallery, if incidents are asked for, and can be played again."""
    try:
        return gallery(cast, played, most=most, say=say) if most else None
    except ReplayError as error:
        say(f"    no gallery: {error}")
        return None


def _pairs(cast: Cast, matches: Sequence[Match]) -> list[dict[str, Any]]:
    """The first driver against each other one, in the same scenarios: collisions and goals, among each population."""
    found = {match.names: match for match in matches}
    first, *others = cast.drivers
    return [
        paired_over_seeds(ending, [found[other, people]], [found[first, people]])
        for ending, people, other in product(("collision", "goal"), cast.populations, others)
    ]


def _curves(drivers: Iterable[str]) -> dict[str, dict[int, list[dict[str, Any]]]]:
    """Metrics of each update of those drivers that are run folders."""
    runs = {name: Run.open(name) for name in run_folders(drivers)}
    return {name: {run.experiment.seed: run.metrics()} for name, run in runs.items() if run.metrics()}
