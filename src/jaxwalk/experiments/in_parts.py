"""`jaxwalk evaluate --part K/N` and `jaxwalk merge`: an evaluation in parts, played anywhere, put together exactly.

A part keeps the rows of its scenarios. They are a small share of what was recorded, and every number follows from them:
so a merge has the numbers of one evaluation of all, resampled intervals included.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice, product
from pathlib import Path

import numpy as np

from jaxwalk.evaluation import BATCH, Cell, Results, acts_by, episodes_at_once, jaywalk_multiplier, named
from jaxwalk.evaluation.batches import evaluate_batches
from jaxwalk.evaluation.document_parts import ScenarioSet, StreetOrigin
from jaxwalk.evaluation.map_rates import rates_by_map
from jaxwalk.evaluation.parts import (
    FORMAT,
    PART,
    Part,
    PartCell,
    PartDocument,
    PartError,
    StoredPart,
    complete,
    pieces_of,
)
from jaxwalk.evaluation.results import driver_cost, ms_per_step
from jaxwalk.evaluation.row_files import RowDigest, RowWriter
from jaxwalk.evaluation.stored_rows import StoredRowsError, stored_rows
from jaxwalk.experiments.evaluating import Evaluation, Played, Tell, keep_evaluation, with_comparisons
from jaxwalk.experiments.tournament import Scenarios
from jaxwalk.interfaces import Policy
from jaxwalk.maps import text_of
from jaxwalk.metrics import Rows, summarise
from jaxwalk.metrics.statistics import CHUNK
from jaxwalk.provenance import Provenance, provenance
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.scenarios import Drawn
from jaxwalk.scenarios.source import HASH_DIGITS, hash_of, scenario_bytes
from jaxwalk.sim.environment import Street
from jaxwalk.writing import remove_unfinished, together, write_whole

ADVICE = "merge with the same jaxwalk as that of the parts, or evaluate them again"


def evaluate_part(work: Evaluation, part: Part, out: Path, tell: Tell, *, batch: int = BATCH) -> PartDocument:
    """Evaluate one part of drawn scenarios, and write it into a folder; return what it says about itself.

    Memory doesn't grow with the number of episodes: a piece of at most `CHUNK` is written as soon as it is played. The
    files appear together at the end, or none.

    Raises:
        PartError: there are fewer blocks than parts, or the scenarios aren't drawn ones.
        ValueError: ``batch`` doesn't divide `CHUNK`.
        DriverError: a driver that is not JAX failed.
        ActionError: an action of another policy isn't in its space.
    """
    planned = planned_part(work, part, batch=batch)  # before drivers can change
    span = planned.span
    out.mkdir(parents=True, exist_ok=True)
    remove_unfinished(out)
    with together():
        with RowWriter(out) as writer:
            cells = tuple(_played_cell(work, planned, number, writer, tell) for number in range(len(planned.cells)))
        drawn = hash_of(scenario_bytes(work.source(work.streets[0]), span))
        document = replace(planned, scenarios_hash=drawn, cells=cells)
        write_whole(out / PART, document.to_json())
    return document


def planned_part(work: Evaluation, part: Part, *, batch: int = BATCH) -> PartDocument:
    """Return what a part will say about itself, without the hashes and times that are known when it is played.

    Raises PartError and ValueError as `evaluate_part` does.
    """
    if not isinstance(work.scenarios, Scenarios):
        raise PartError("only drawn scenarios are evaluated in parts")
    if CHUNK % batch:
        raise ValueError(f"batch must divide {CHUNK}, so that parts can be merged, not be {batch}")
    part.span(work.episodes, batch)
    street = work.streets[0]
    return PartDocument(
        format=FORMAT,
        part=part,
        scenarios_hash="",
        seed=work.scenarios.seed,
        episodes=work.episodes,
        batch=batch,
        dt=float(street.world.rules.dt),
        street=StreetOrigin.of(street),
        drivers=tuple(policy_origin("driver", name) for name in work.drivers),
        populations=tuple(policy_origin("pedestrian", name) for name in work.populations),
        options=work.options,
        cells=tuple(_planned_cell(*cell) for cell in _cells(work)),
        made=provenance(),
    )


def _cells(work: Evaluation) -> list[tuple[Street, tuple[str, Policy], tuple[str, Policy]]]:
    """Return street, driver and population of each cell, in the order of an evaluation."""
    return list(product(work.streets, work.drivers.items(), work.populations.items()))


def _planned_cell(street: Street, driver: tuple[str, Policy], people: tuple[str, Policy]) -> PartCell:
    """Return what is known about a cell before it is played."""
    return PartCell(
        driver=driver[0],
        pedestrians=people[0],
        driver_mode=acts_by(driver[1]),
        pedestrian_mode=acts_by(people[1]),
        jaywalk_multiplier=jaywalk_multiplier(street),
        driver_observes=driver[1].view.name,
        pedestrian_observes=people[1].view.name,
        driver_seconds=0.0,
        driver_steps=0,
        sha256="",
    )


def _played_cell(work: Evaluation, planned: PartDocument, number: int, writer: RowWriter, tell: Tell) -> PartCell:
    """Play a part of a cell, and write its rows; return what is known about it."""
    street, (driver, car), (population, people) = _cells(work)[number]
    digest, before = RowDigest(), driver_cost(car)
    policies, source = {"driver": car, "pedestrian": people}, work.source(street)

    def progress(done: int, total: int) -> None:
        tell(f"{driver} among {population}", number * total + done, len(planned.cells) * total)

    batch = min(planned.batch, episodes_at_once(street, policies))  # as an evaluation of all plays
    played = evaluate_batches(street, policies, source, batch=batch, progress=progress, span=planned.span)
    with named({"driver": driver, "pedestrian": population}):
        for piece in pieces_of(planned.span):
            rows = Rows.join([*islice(played, -(-len(piece) // batch))])
            writer.write(number, rows)
            digest.update(rows)
        next(played, None)  # its end relieves the process of old programs
    seconds, steps = (driver_cost(car) - before).tolist()
    return replace(planned.cells[number], driver_seconds=seconds, driver_steps=int(steps), sha256=digest.digits)


@dataclass(frozen=True)
class Merged:
    """The results of all parts together, and lines about the parts."""

    results: Results
    said: tuple[str, ...]


def merge_parts(parts: Sequence[StoredPart], out: Path, tell: Tell) -> Merged:
    """Put the parts of an evaluation together, and write the files that an evaluation of all would write.

    The same numbers come out, to the bit if the parts were played by processors of one kind.

    Args:
        parts: in any order; a part may be there twice if both have the same rows.
        out: folder to write into.
        tell: called with the current task, how much of it is done, and the total.

    Raises:
        PartError: they are parts of different evaluations or of another jaxwalk, one is missing, two of one number
            differ, or one played other scenarios.
        StoredRowsError: the rows of a part are damaged.
        MapError: this jaxwalk lacks a map that it should ship with.
    """
    parts, said = complete(parts)
    first = parts[0].document
    said += _made_otherwise(parts[0], provenance())
    scenarios = _same_scenarios(parts, tell)
    groups: list[Played] = [{} for _ in first.options.jaywalk_multipliers]
    cells = []
    for number, about in enumerate(first.cells):
        tell(f"{about.driver} among {about.pedestrians}", number, len(first.cells))
        _check_rows(parts, number)
        rows = stored_rows([part.cell(number) for part in parts])
        groups[number * len(groups) // len(first.cells)][about.driver, about.pedestrians] = rows
        cells.append(_cell(parts, number, rows))
    results = Results(
        scenarios,
        tuple(cells),
        street=first.street,
        drivers=first.drivers,
        populations=first.populations,
        options=first.options,
        made=_made(parts),
    )
    results = with_comparisons(results, groups, first.options.compare, first.street.sim.contact)
    out.mkdir(parents=True, exist_ok=True)
    keep_evaluation(out, results, groups, encounters=first.options.encounters)
    return Merged(results, tuple(said))


def _made_otherwise(part: StoredPart, now: Provenance) -> list[str]:
    """Return a line if other versions of other packages merge. Raise PartError for another jaxwalk."""
    then = part.document.made
    for what, a, b in (
        ("version", then.versions.get("jaxwalk"), now.versions.get("jaxwalk")),
        ("commit", then.commit, now.commit),
    ):
        if a != b:
            raise PartError(f"{part.folder}: was made by {what} {a} of jaxwalk, and this is {b}; {ADVICE}")
    other = [f"{name} {then.versions.get(name)}, now {found}" for name, found in now.versions.items()
             if then.versions.get(name) != found]  # fmt: skip
    return [f"parts and merge have other versions ({'; '.join(other)}): last digits may differ"] if other else []


def _same_scenarios(parts: Sequence[StoredPart], tell: Tell) -> ScenarioSet:
    """Return the set of all scenarios, which are drawn for its hash. Raise PartError for a part that played others."""
    first = parts[0].document
    street = Street.create([text_of(found) for found in first.street.maps], first.street.sim)
    source = Drawn(street, first.seed, first.episodes)
    whole = hashlib.sha256()
    for part in parts:
        tell("drawing the scenarios again for their hash", part.document.span.start, first.episodes)
        own = hashlib.sha256()
        for content in scenario_bytes(source, part.document.span):
            own.update(content)
            whole.update(content)
        found = own.hexdigest()[:HASH_DIGITS]
        if found != part.document.scenarios_hash:
            played = f"played scenarios of hash {part.document.scenarios_hash}, not {found}"
            raise PartError(f"{part.folder}: {played}; evaluate it again with the same jaxwalk, jax and maps")
    return ScenarioSet(first.episodes, whole.hexdigest()[:HASH_DIGITS], first.seed)


def _cell(parts: Sequence[StoredPart], number: int, rows: Rows) -> Cell:
    """Return a cell of all parts together; ``rows`` are all its rows."""
    about = [part.document.cells[number] for part in parts]
    cost = np.sum([(cell.driver_seconds, cell.driver_steps) for cell in about], axis=0)
    return Cell(
        **about[0].about(),
        summary=summarise(rows),
        driver_ms_per_step=ms_per_step(cost),
        by_map=rates_by_map(rows),
    )


def _check_rows(parts: Sequence[StoredPart], number: int) -> None:
    """Raise StoredRowsError unless the rows of a cell are what was written."""
    for part in parts:
        digest, episodes = RowDigest(), 0
        for rows in part.cell(number).rows():
            digest.update(rows)
            episodes += rows.episodes
        if digest.digits != part.document.cells[number].sha256 or episodes != len(part.document.span):
            raise StoredRowsError(
                f"{part.folder}: its rows were changed after they were written; evaluate this part again"
            )


def _made(parts: Sequence[StoredPart]) -> Provenance:
    """Return what made the parts, with all kinds of hardware."""
    made = parts[0].document.made
    hardware = dict.fromkeys(part.document.made.hardware for part in parts)
    return Provenance(made.commit, "; ".join(hardware), made.versions)
