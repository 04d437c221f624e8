"""What varies in a sweep: fields of the training's file, each with a list of values or a range. Imports no JAX."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, ClassVar

from pydantic import TypeAdapter, ValidationError

from jaxwalk.recipes.experiment_file import explained_fault, quoted_value

MOST_COMBINATIONS = 10_000
"""Most trials of a grid."""
HINT = "give a list of values, or a range such as { low = 1e-4, high = 1e-2, log = true }"


class VariedError(ValueError):
    """A field can't vary as a file says. The message names the field and says what to do, without the file."""


@dataclass(frozen=True)
class ListedValues:
    """Values among which a trial has one."""

    values: tuple[Any, ...]
    """Numbers, truth values, texts, or lists of them."""

    @property
    def labels(self) -> tuple[Any, ...]:
        """Return a value for each that a journal can keep: a list is its JSON text."""
        return tuple(json.dumps(value) if isinstance(value, list) else value for value in self.values)

    def grid(self) -> tuple[Any, ...]:
        """Return the labels of all values."""
        return self.labels

    def value(self, label: Any) -> Any:
        """Return the value of a label."""
        return self.values[self.labels.index(label)]


@dataclass(frozen=True)
class ValueRange:
    """Numbers between two."""

    __pydantic_config__: ClassVar = {"extra": "forbid"}

    low: int | float
    """The smallest value."""
    high: int | float
    """The largest value."""
    log: bool = False
    """Whether to draw the logarithm evenly, for sizes of unknown order."""
    points: int | None = None
    """Number of values in a grid, from ``low`` to ``high``; needed there, and only there."""

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible range."""
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise ValueError(f"low must be below high, both finite, not {self.low} and {self.high}")
        if self.log and self.low <= 0:
            raise ValueError(f"low must be above 0 with log, not {self.low}")
        if self.points is not None and not 2 <= self.points <= MOST_COMBINATIONS:
            raise ValueError(f"points must lie in [2, {MOST_COMBINATIONS:,}], not {self.points}")

    @property
    def labels(self) -> tuple[int | float, ...]:
        """Return both ends."""
        return self.low, self.high

    def grid(self) -> tuple[int | float, ...]:
        """Return the values in a grid."""
        last = (self.points or 2) - 1
        shares = [k / last for k in range(last + 1)]
        if self.log:
            found = [self.low * (self.high / self.low) ** share for share in shares]
        else:
            found = [self.low + (self.high - self.low) * share for share in shares]
        found[0], found[-1] = self.low, self.high  # powers round
        return tuple(dict.fromkeys(round(x) for x in found)) if self.whole else tuple(map(float, found))

    @property
    def whole(self) -> bool:
        """Return whether the values are whole numbers, as both ends are written."""
        return isinstance(self.low, int) and isinstance(self.high, int)

    def value(self, label: Any) -> Any:
        """Return the value of a label: itself."""
        return label


Varied = ListedValues | ValueRange
"""How one field varies."""


def varied_fields(table: Mapping[str, Any], within: str = "") -> dict[str, Varied]:
    """Return how each field varies, by its name with dots.

    Args:
        table: a table of fields, in which tables are nested as in a training's file; a list stands for its values, and
            a table with ``low`` or ``high`` is a range.
        within: the name of the table, with a dot at its end.

    Raises:
        VariedError: something is neither a list nor a range, or is an impossible one.
    """
    found: dict[str, Varied] = {}
    for name, value in table.items():
        field = f"{within}{name}"
        if isinstance(value, list):
            found[field] = _listed(field, value)
        elif isinstance(value, dict) and value.keys() & {"low", "high"}:
            found[field] = _range(field, value)
        elif isinstance(value, dict) and value:
            found |= varied_fields(value, f"{field}.")
        else:
            raise VariedError(f"{field}: {quoted_value(value)} doesn't vary; {HINT}")
    return found


def _listed(field: str, values: list[Any]) -> ListedValues:
    """Return the values of a list. Raise VariedError unless they are at least two different ones."""
    listed = ListedValues(tuple(values))
    if any(isinstance(value, dict) for value in values):
        raise VariedError(f"{field}: a value can't be a table; name the fields inside it, each with its values")
    seen = {json.dumps(value) for value in values}
    if len(seen) < 2 or len(seen) < len(values):
        raise VariedError(f"{field}: needs at least two values, all different, not {quoted_value(values)}")
    return listed


def _range(field: str, table: Mapping[str, Any]) -> ValueRange:
    try:
        return TypeAdapter(ValueRange).validate_json(json.dumps(table, default=str), strict=True)
    except ValidationError as error:
        fault = dict(error.errors(include_url=False)[0])
        raise VariedError(f"{field}: {explained_fault(fault, {'low': 0, 'high': 0, 'log': 0, 'points': 0})}") from None


def changes_of(fields: Mapping[str, Varied], labels: Mapping[str, Any]) -> dict[str, Any]:
    """Return the nested table of a training's file that gives fields their values, by the labels of some of them."""
    found: dict[str, Any] = {}
    for field, label in labels.items():
        *tables, name = field.split(".")
        inner = found
        for table in tables:
            inner = inner.setdefault(table, {})
        inner[name] = fields[field].value(label)
    return found


def grid_of(fields: Mapping[str, Varied]) -> list[dict[str, Any]]:
    """Return all combinations as labels by field, the last field changing first.

    Raises:
        VariedError: a range has no ``points``, or there are too many combinations.
    """
    for name, field in fields.items():
        if isinstance(field, ValueRange) and field.points is None:
            raise VariedError(f"{name}: a grid needs points, the number of values of the range, or a list of values")
    axes = [field.grid() for field in fields.values()]
    count = math.prod(map(len, axes))
    if count > MOST_COMBINATIONS:
        raise VariedError(f"{next(iter(fields))}: the grid has {count:,} combinations; at most {MOST_COMBINATIONS:,}")
    return [dict(zip(fields, labels, strict=True)) for labels in product(*axes)]


def single_changes(fields: Mapping[str, Varied]) -> Iterator[dict[str, Any]]:
    """Yield labels that change one field each, to each of its values or to each end of its range."""
    for name, field in fields.items():
        yield from ({name: label} for label in field.labels)
