"""What a table is, how a number is shown in it, and its file."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from jaxwalk.report.material import Number
from jaxwalk.writing import write_whole

NONE = "–"
"""Stands for what does not exist."""


@dataclass(frozen=True)
class Table:
    """One table."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    verdict: str = ""
    """How ours compares with the paper's, in a sentence."""


def write_csv(tables: dict[str, Table], folder: Path) -> None:
    """A CSV file for each table."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in tables.items():
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(table.columns)
        writer.writerows(table.rows)
        write_whole(folder / f"{name}.csv", text.getvalue())


def markdown_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as Markdown, without a line feed at its end."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def shown(ours: Number, scale: float = 100.0, digits: int | None = None) -> str:
    """As in ``14.0 [11.2, 17.3]``: one digit unless told otherwise, and two of a percentage within 1 of 0 or 100."""
    if ours["value"] is None:
        return NONE
    if digits is None:
        digits = 1 if scale != 100 or 0.01 <= abs(ours["value"]) <= 0.99 else 2
    value = f"{scale * ours['value']:.{digits}f}"
    if ours["low"] is None or ours["high"] is None:
        return value
    return f"{value} [{scale * ours['low']:.{digits}f}, {scale * ours['high']:.{digits}f}]"


def p_value(p: float) -> str:
    """As in ``0.021``."""
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
