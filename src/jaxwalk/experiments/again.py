"""`jaxwalk evaluate --again`: make a document again from what it says about itself, and compare the two."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jaxwalk.evaluation.document_parts import PolicyOrigin
from jaxwalk.evaluation.reading import Origin, as_results
from jaxwalk.evaluation.results import Results
from jaxwalk.experiments.evaluating import Evaluation, prepared
from jaxwalk.experiments.tournament import Scenarios
from jaxwalk.maps import text_of
from jaxwalk.provenance import Provenance
from jaxwalk.runs.contestants import ContestantError
from jaxwalk.runs.policy_origins import policy_origin
from jaxwalk.sim.environment import Street

TOLERANCE = 1e-4
"""Numbers may differ by this between versions and processors: absolute below 1, relative above."""
MADE_THEN = ("made", "driver_ms_per_step", "in_words")
"""What isn't compared: when and where it was made, times, and sentences that repeat numbers."""
SHOWN = 3
"""Most differences that are named."""
ADVICE = "evaluate anew, with --out"


class AgainError(ValueError):
    """A document can't be made again. The message says what is missing and what to do, in one line."""


@dataclass(frozen=True)
class Comparison:
    """How a document differs from the one that was made before."""

    in_words: str
    differs: bool
    """Whether something differs by more than `TOLERANCE`."""


def read_document(path: Path) -> Results:
    """Return the results of a file.

    Raises AgainError if it is no JSON, DocumentError if it is damaged, and OSError if it can't be read.
    """
    try:
        content = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise AgainError(f"{path}: is no JSON document ({error}); {ADVICE}") from error
    return as_results(content, Origin(path, ADVICE))


def evaluation_again(path: Path, results: Results, *, out: Path | None, **loading: Any) -> Evaluation:
    """Return the evaluation that a document describes; ``loading`` is as in `prepared`.

    Raises:
        AgainError: the document lacks what is needed, or a driver or population is missing or another one now.
        MapError: this jaxwalk lacks a map that it should ship with.
    """
    street, options, seed = results.street, results.options, results.scenarios.seed
    if street is None or options is None or seed is None:
        raise AgainError(f"{path}: doesn't say how it was made: no `evaluate` of this version made it; {ADVICE}")
    for role, origins in (("driver", results.drivers), ("pedestrian", results.populations)):
        for origin in origins:
            _check_same(path, role, origin)
    names = [origin.name for origin in results.drivers], [origin.name for origin in results.populations]
    there = Street.create([text_of(found) for found in street.maps], street.sim)
    return prepared(there, names, Scenarios(results.scenarios.count, seed), options, out=out, **loading)


def _check_same(path: Path, role: str, origin: PolicyOrigin) -> None:
    """Raise AgainError unless a name stands for the same policy as in the document."""
    what = f"{path} was made with the {origin.kind} {origin.name}"
    try:
        found = policy_origin(role, origin.name)
    except ContestantError as error:
        raise AgainError(f"{what}, which is missing; put it there, or work in the folder of that evaluation") from error
    if found != origin:
        now = f"a {found.kind} of SHA-256 {found.sha256}" if found.sha256 else "missing, or of another kind"
        raise AgainError(f"{what} of SHA-256 {origin.sha256}, which now is {now}; put the same one there")


def compare_documents(before: Results, now: Results) -> Comparison:
    """Compare the results of two evaluations, and say whether they are equal, nearly equal or different."""
    old, new = (json.loads(results.to_json()) for results in (before, now))
    found = sorted(_differences(old, new, ""), key=lambda difference: -difference[0])
    beyond = [what for size, what in found if size > TOLERANCE]
    changed = _changed(before.made, now.made)
    versions = f"; made otherwise: {', '.join(changed)}" if changed else ", with the same versions and processor"
    if beyond:
        more = f" and {len(beyond) - SHOWN:,} more" if len(beyond) > SHOWN else ""
        what = f"different: {len(beyond):,} of its values differ by more than {TOLERANCE:g}{versions}"
        return Comparison(f"{what}. {'; '.join(beyond[:SHOWN])}{more}", differs=True)
    if found:
        return Comparison(f"not equal, but every number within {TOLERANCE:g}{versions}. {found[0][1]}", differs=False)
    return Comparison(f"equal{versions}", differs=False)


def _differences(before: Any, now: Any, place: str) -> Iterator[tuple[float, str]]:
    """Yield how large each difference is, and where; a difference that isn't one of numbers is infinitely large."""
    if isinstance(before, dict) and isinstance(now, dict):
        for name in (name for name in {**before, **now} if name not in MADE_THEN):
            yield from _differences(before.get(name), now.get(name), f"{place}.{name}" if place else name)
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        for number, pair in enumerate(zip(before, now, strict=True)):
            yield from _differences(*pair, f"{place}[{number}]")
    elif before != now:
        yield _size(before, now), f"{place} is {now!r:.60}, not {before!r:.60}"


def _size(before: Any, now: Any) -> float:
    """Return how large the difference of two numbers is; infinity unless both are numbers."""
    if type(before) not in (int, float) or type(now) not in (int, float):
        return float("inf")
    return abs(before - now) / max(1.0, abs(before))


def _changed(before: Provenance | None, now: Provenance | None) -> list[str]:
    """Return what differs in how two documents were made, in words."""
    old, new = ({} if made is None else _named(made) for made in (before, now))
    return [f"{name} {old.get(name)}, now {new.get(name)}" for name in {**old, **new} if old.get(name) != new.get(name)]


def _named(made: Provenance) -> dict[str, str | None]:
    return {"commit": made.commit, **made.versions, "processor": made.hardware}
