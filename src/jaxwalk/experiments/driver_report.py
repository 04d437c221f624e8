"""`jaxwalk report`: evaluate any drivers, and show their collisions."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

from jaxwalk.evaluation import Match, ReplayError, every_two, paired_over_seeds, write_rows
from jaxwalk.evaluation.document_parts import PairedSeeds
from jaxwalk.evaluation.training_seeds import ENDINGS
from jaxwalk.experiments.curves import learning_curve
from jaxwalk.experiments.evaluating import replayed_cell
from jaxwalk.experiments.tournament import Scenarios, play_rounds, results_of
from jaxwalk.exports.gallery import Cast, gallery
from jaxwalk.metrics import Rows
from jaxwalk.provenance import provenance
from jaxwalk.report import Gallery, LearningCurve, Material, write_report
from jaxwalk.runs.contestant_names import run_folders
from jaxwalk.runs.folder import Run
from jaxwalk.runs.lock import held
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.scenarios import Drawn
from jaxwalk.wording import counted
from jaxwalk.writing import together, write_whole

MANY = 4
"""Number of drivers at the top of the page; its tables have the others too."""


def driver_report(
    folder: Path, cast: Cast, *, episodes: int, most: int, say: Callable[[str], None], replays: int = 0
) -> Path:
    """Evaluate every driver among every population, and write report, figures, tables and numbers into the folder.

    Args:
        folder: created if missing; files of an earlier report are replaced.
        cast: drivers and populations; sections about one driver show the first.
        episodes: number of scenarios for each driver and population.
        most: number of incidents of each kind in the gallery, for each driver and population; 0: no gallery.
        say: called with a line of text as the work progresses.
        replays: most collisions of each driver and population that are replayed with one thing changed, for a table.

    Returns:
        The path of the page.

    Raises:
        InUseError: another process is writing into the folder.
        ReplayError: ``replays`` is above 0, and a driver does not do the same again in the same scenario.
    """
    with held(folder):
        return _report(folder, cast, episodes, most, replays, say)


def _report(folder: Path, cast: Cast, episodes: int, most: int, replays: int, say: Callable[[str], None]) -> Path:
    """Do the work of `driver_report`, once the folder is locked."""
    began = time.monotonic()
    curves = _curves(cast.drivers)
    round_ = (None, cast.drivers, cast.populations)
    who = f"{counted(len(cast.drivers), 'driver')} among {counted(len(cast.populations), 'population')}"
    say(f"    playing {counted(episodes, 'scenario')}: {who}")
    scenarios, matches = play_rounds(cast.street, [round_], Scenarios(episodes, cast.seed), say)
    if replays:
        matches = [_replayed(cast, match, replays, say) for match in matches]
    results = replace(
        results_of(cast.street, scenarios, matches, paired=_pairs(cast, matches)),
        every_two=every_two(matches),
        drivers=tuple(policy_origin("driver", name) for name in cast.drivers),
        populations=tuple(policy_origin("pedestrian", name) for name in cast.populations),
    )
    watched = _gallery(cast, {match.names: match.rows for match in matches}, most, say)
    material = Material(
        results=results,
        curves=curves,
        provenance=provenance(),
        minutes={"all": (time.monotonic() - began) / 60},
        subject=next(iter(cast.drivers)),
        headline=tuple(cast.drivers)[:MANY],
        gallery=watched,
    )
    with together():
        write_rows(folder / "episodes.csv", [(*match.names, match.rows) for match in matches])
        write_whole(folder / "results.json", results.to_json())
        return write_report(folder, material, say)


def _replayed(cast: Cast, match: Match, replays: int, say: Callable[[str], None]) -> Match:
    """Return a match whose cell knows what would have avoided its first collisions."""
    driver, people = match.names
    say(f"    collisions of {driver} among {people}: would a careful human have avoided them?")
    policies = {"driver": cast.drivers[driver], "pedestrian": cast.populations[people]}
    source = Drawn(cast.street, cast.seed, match.rows.episodes)
    return replace(match, cell=replayed_cell(cast.street, policies, source, match, replays))


def _gallery(cast: Cast, played: dict[tuple[str, str], Rows], most: int, say: Callable[[str], None]) -> Gallery | None:
    """Return the gallery if incidents are wanted and can be played again."""
    try:
        return gallery(cast, played, most=most, say=say) if most else None
    except ReplayError as error:
        say(f"    no gallery: {error}")
        return None


def _pairs(cast: Cast, matches: Sequence[Match]) -> list[PairedSeeds]:
    """Compare the first driver with each other one on the same scenarios of each population; empty if it is alone."""
    found = {match.names: match for match in matches}
    first, *others = cast.drivers
    return [
        paired_over_seeds(ending, [found[other, people]], [found[first, people]])
        for ending in ENDINGS
        for people, other in product(cast.populations, others)
    ]


def _curves(drivers: Iterable[str]) -> dict[str, dict[int, LearningCurve]]:
    """Return the trainings of the drivers that are run folders with metrics."""
    runs = {name: Run.open(name) for name in run_folders(drivers)}
    return {name: {run.experiment.seed: learning_curve(run)} for name, run in runs.items() if run.metrics()}
