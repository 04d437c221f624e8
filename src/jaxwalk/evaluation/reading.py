"""Read documents back: the program gets either a complete typed document or one error message."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from textwrap import shorten
from typing import Any, TypeVar, cast

from pydantic import TypeAdapter, ValidationError

from jaxwalk.evaluation.document_parts import SeedNumbers
from jaxwalk.evaluation.results import HEADLINE, SCHEMA, Cell, Results
from jaxwalk.metrics import (
    JAYWALK_RATE,
    METRICS,
    PASSING,
    SPEED_DIFFERENTIAL,
    SURROGATE_DISTRIBUTIONS,
    WAITING,
    OverSeeds,
)
from jaxwalk.metrics.contacts import CELLS, MEASURED_CONTACTS
from jaxwalk.metrics.decisions import QUARTERS
from jaxwalk.metrics.meetings import BINS
from jaxwalk.metrics.passing import CLEARANCES
from jaxwalk.metrics.severity import Distribution, Distributions
from jaxwalk.metrics.waiting import DISTANCES, MISSES, SPEEDS, WaitBin

LARGEST = 1e39
"""Upper limit of numbers; percentages of larger ones would overflow."""
LONGEST = 200
"""Most characters of a field's name, and of the problem, in a message."""

T = TypeVar("T")
Place = tuple[str | int, ...]
"""Names and indices that lead to a field."""


class DocumentError(ValueError):
    """Raised for a file that is not a complete document of this version; the message names the file and the field."""


@dataclass(frozen=True)
class Origin:
    """The origin of a document, for messages."""

    path: Path
    advice: str
    """What the user can do about a damaged file."""
    place: Place = ()
    """Place of the document in the file."""

    def inside(self, *place: str | int) -> Origin:
        """Return the origin of a part of the document."""
        return replace(self, place=(*self.place, *place))

    def damaged(self, place: Place, what: str) -> DocumentError:
        """Return the error that says what is wrong with a field."""
        where = shorten(".".join(str(part) for part in (*self.place, *place) if part != "summary"), LONGEST)
        said = f"{where}: {what}" if where else what
        return DocumentError(f"{self.path}: damaged ({shorten(said, 2 * LONGEST)}); {self.advice}")


def as_document(kind: Callable[..., T], content: Any, origin: Origin) -> T:
    """Return the content of a JSON file as a typed document.

    Args:
        kind: a frozen dataclass, or another type that pydantic knows.
        content: dicts, lists, strings, numbers, booleans and None.
        origin: where the content comes from.

    Raises:
        DocumentError: a field is missing, unknown or of the wrong type, or a number is not finite or too large.
    """
    try:
        for place in _wrong_numbers(content, ()):
            raise origin.damaged(place, f"the number is not finite or above {LARGEST:g}")
        reader: TypeAdapter[T] = TypeAdapter(cast("Any", kind))
        return reader.validate_json(json.dumps(content), strict=True)
    except RecursionError as error:
        raise origin.damaged((), "lists inside lists without end") from error
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise origin.damaged(first["loc"], first["msg"].removeprefix("Value error, ")) from error


def as_results(content: Any, origin: Origin) -> Results:
    """Return the content of a JSON file as typed results.

    Raises:
        DocumentError: the schema differs, a metric or a field is missing, unknown or of the wrong type, or a table's
            size differs from that of the metrics.
    """
    if not isinstance(content, Mapping) or content.get("schema") != SCHEMA:
        raise DocumentError(f"{origin.path}: of another version (its schema is not {SCHEMA}); {origin.advice}")
    nested = {name: value for name, value in content.items() if name != "schema"}
    if isinstance(nested.get("cells"), list):
        _check_metrics(nested["cells"], origin)
        nested["cells"] = [_nested(cell) for cell in nested["cells"]]
    results = as_document(Results, nested, origin)
    for number, cell in enumerate(results.cells):
        _check_headline(content["cells"][number], cell, origin.inside("cells", number))
        _check_sizes(cell, origin.inside("cells", number))
    for number, numbers in enumerate(results.over_seeds):
        _check_seeds(numbers, origin.inside("over_seeds", number))
    return results


def _check_metrics(cells: list[Any], origin: Origin) -> None:
    """Raise DocumentError if every cell lacks a metric: then the file is whole, but was written without it."""
    for metric in METRICS:
        if cells and all(isinstance(cell, dict) and metric.name not in cell for cell in cells):
            lacks = f"of another version (it lacks the metric {metric.name})"
            raise DocumentError(f"{origin.path}: {lacks}; {origin.advice}")


def _nested(cell: Any) -> Any:
    """Return a cell of a file with its metrics under ``summary``, and without the headline, which repeats some."""
    if not isinstance(cell, dict):
        return cell
    own = {field.name for field in fields(Cell)} - {"summary"}
    rest = {name: value for name, value in cell.items() if name not in own and name not in HEADLINE}
    return {name: value for name, value in cell.items() if name in own} | {"summary": rest}


def _check_headline(written: Mapping[str, Any], cell: Cell, origin: Origin) -> None:
    """Raise DocumentError if the headline in the file differs from the summary."""
    for name, number in cell.headline().items():
        if written.get(name) != number:
            raise origin.damaged((name,), "differs from the same number in the rest of the cell")


def _check_sizes(cell: Cell, origin: Origin) -> None:
    """Raise DocumentError if a table's size differs from that of the metrics."""
    summary = cell.summary
    _check_size(summary[SPEED_DIFFERENTIAL], BINS, origin.inside("speed_differential"))
    _check_size(summary[PASSING], len(CLEARANCES) - 1, origin.inside("passing"))
    for rule, found in vars(summary[MEASURED_CONTACTS]).items():
        _check_size(found.hit_points, CELLS, origin.inside("contacts", rule, "hit_points"))
    _check_size(summary[JAYWALK_RATE].quarters, QUARTERS, origin.inside("jaywalk_rate", "quarters"))
    _check_wait_bins(summary[WAITING].by_distance, DISTANCES, origin.inside("waiting", "by_distance"))
    _check_wait_bins(summary[WAITING].by_speed, SPEEDS, origin.inside("waiting", "by_speed"))
    for kind, found in (("crosswalk", summary[SURROGATE_DISTRIBUTIONS].crosswalk),
                        ("jaywalk", summary[SURROGATE_DISTRIBUTIONS].jaywalk)):  # fmt: skip
        for name, distribution in _distributions(found):
            for column in (distribution.value, distribution.low, distribution.high):
                _check_size(column, len(distribution.threshold), origin.inside("surrogate_distributions", kind, name))


def _check_wait_bins(bins: Sequence[WaitBin], edges: Sequence[float], origin: Origin) -> None:
    _check_size(bins, len(edges) - 1, origin)
    for number, found in enumerate(bins):
        _check_size(found.rates, len(MISSES), origin.inside(number, "rates"))


def _distributions(found: Distributions) -> tuple[tuple[str, Distribution], ...]:
    names = ("ttc", "pet", "drac", "gap")
    return tuple(zip(names, (found.ttc, found.pet, found.drac, found.gap), strict=True))


def _check_seeds(numbers: SeedNumbers, origin: Origin) -> None:
    """Raise DocumentError unless every number has a value for each training seed."""
    for field in fields(numbers):
        found = getattr(numbers, field.name)
        if isinstance(found, OverSeeds):
            _check_size(found.each, len(numbers.training_seeds), origin.inside(field.name, "each"))


def _check_size(values: Sequence[Any], size: int, origin: Origin) -> None:
    if len(values) != size:
        raise origin.damaged((), f"has {len(values)} entries, not {size}")


def _wrong_numbers(content: Any, place: Place) -> Iterator[Place]:
    """Yield the place of every number that is infinite, too large or NaN."""
    if isinstance(content, (int, float)) and not abs(content) <= LARGEST:
        yield place
    inner = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    for name, value in inner:
        yield from _wrong_numbers(value, (*place, name))
