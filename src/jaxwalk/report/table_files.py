"""The files of a report's tables: CSV and JSON for programs, Markdown for people."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jaxwalk.report.table import NONE, Table
from jaxwalk.writing import write_whole

NUMBER = r"-?\d[\d,]*(?:\.\d+)?"
WITH_INTERVAL = re.compile(rf"({NUMBER}) \[({NUMBER}), ({NUMBER})\]")
"""A number with its interval, as `jaxwalk.report.table.shown` writes it."""
ALONE = re.compile(NUMBER)


def write_tables(tables: Mapping[str, Table], captions: Mapping[str, str], folder: Path) -> None:
    """Write a CSV, a JSON and a Markdown file for each table; ``captions`` are by the tables' names."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in tables.items():
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(table.columns)
        writer.writerows(table.rows)
        write_whole(folder / f"{name}.csv", text.getvalue())
        content = json.dumps(as_data(table, captions[name]), indent=1, ensure_ascii=False, allow_nan=False)
        write_whole(folder / f"{name}.json", content + "\n")
        write_whole(folder / f"{name}.md", table.markdown() + "\n")


def as_data(table: Table, caption: str) -> dict[str, Any]:
    """Return a table for programs, in the digits that it shows.

    Of a column that has nothing but numbers, a cell is a number, an object of ``value``, ``low`` and ``high``, or null
    where there is none; of all other columns it is the text.
    """
    numeric = [place for place in range(len(table.columns)) if all(_is_number(row[place]) for row in table.rows)]
    rows = [[_value(cell) if place in numeric else cell for place, cell in enumerate(row)] for row in table.rows]
    return {"caption": caption, "columns": list(table.columns), "rows": rows, "verdict": table.verdict}


def _is_number(cell: str) -> bool:
    return cell == NONE or bool(WITH_INTERVAL.fullmatch(cell) or ALONE.fullmatch(cell))


def _value(cell: str) -> Any:
    if cell == NONE:
        return None
    found = WITH_INTERVAL.fullmatch(cell)
    if found is None:
        return _number(cell)
    return dict(zip(("value", "low", "high"), map(_number, found.groups()), strict=True))


def _number(text: str) -> float:
    """Return a number as it is written, with commas between thousands."""
    return float(text.replace(",", ""))
