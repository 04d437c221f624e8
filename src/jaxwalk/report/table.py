"""What a table is, and how it shows a number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from jaxwalk.evaluation.document_parts import Number
from jaxwalk.metrics import holm
from jaxwalk.metrics.crossings import ByType

T = TypeVar("T")

NONE = "–"
"""Shown for a number that does not exist."""
MOVING = "moving contacts %"
"""The column of the share of episodes with a contact of the moving car, by its footprint."""


@dataclass(frozen=True)
class Table:
    """A table of a report."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    verdict: str = ""
    """What the numbers mean together, and how they compare with the paper's."""
    brief: str = ""
    """The comparison with the paper in a few words, under which the whole is folded."""

    def markdown(self) -> str:
        """Return the table as Markdown, without a line feed at the end."""
        return markdown_table(self.columns, self.rows)


def markdown_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table as Markdown, without a line feed at the end."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def by_type(found: ByType[T]) -> dict[str, T]:
    """Return the values of both types of crossing by the types' names."""
    return {"crosswalk": found.crosswalk, "jaywalk": found.jaywalk}


def shown(ours: Number, scale: float = 100.0, digits: int | None = None, *, sign: str = "") -> str:
    """Return a number and its interval as in ``14.0 [11.2, 17.3]``.

    ``digits`` after the point are 1 by default, and 2 for a percentage within 1 of 0 or 100. With the ``sign`` + a
    number above 0 has one. A ratio over zero events has only a lower end: ``> 2.1``.
    """
    if ours.value is None:
        return NONE if ours.low is None else f"> {scale * ours.low:.{2 if digits is None else digits}f}"
    if digits is None:
        digits = 1 if scale != 100 or 0.01 <= abs(ours.value) <= 0.99 else 2
    value = f"{scale * ours.value:{sign}.{digits}f}"
    if ours.low is None or ours.high is None:
        return value
    return f"{value} [{scale * ours.low:.{digits}f}, {scale * ours.high:.{digits}f}]"


UNJUDGED = "cannot be judged"
"""Shown for the p-value of too few training seeds."""


def p_value(p: float | None) -> str:
    """Return a p-value as in ``0.021``."""
    if p is None:
        return UNJUDGED
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def p_in_words(p: float) -> str:
    """Return a p-value as in ``p = 0.021``."""
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}"


def adjusted(p: Sequence[float | None]) -> list[float | None]:
    """Return p-values adjusted for all tests among them (Holm); None stays None."""
    known = iter(holm([one for one in p if one is not None]))
    return [None if one is None else next(known) for one in p]
