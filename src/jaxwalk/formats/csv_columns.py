"""Columns of other people's CSV files."""

from __future__ import annotations

import csv
from collections.abc import Collection
from pathlib import Path

import numpy as np

from jaxwalk.formats.tracks import LARGEST, TracksError


def read_columns(path: Path, numbers: Collection[str], words: Collection[str] = ()) -> dict[str, np.ndarray]:
    """The named columns of a file whose first line names them; others are passed over.

    Raises:
        TracksError: there is no such file or column, or a number is none.
    """
    if not path.is_file():
        raise TracksError(f"{path}: no such file; it must lie beside the others of its recording")
    try:
        with path.open(newline="", encoding="utf-8") as file:
            lines = list(csv.reader(file))
    except (csv.Error, UnicodeDecodeError) as error:
        raise TracksError(f"{path}: no CSV file ({error}); restore it") from None
    head = [name.strip() for name in lines[0]] if lines else []
    if missing := [name for name in (*numbers, *words) if name not in head]:
        raise TracksError(f"{path}: has no column {', '.join(missing)}; is it of this layout?")
    rows = [line for line in lines[1:] if line]
    if any(len(line) != len(head) for line in rows):
        raise TracksError(f"{path}: a line has another number of values than the first; mend it")
    columns = {name: np.array([line[head.index(name)] for line in rows], str) for name in (*numbers, *words)}
    return {name: _numbers(path, name, x) if name in numbers else x for name, x in columns.items()}


def _numbers(path: Path, name: str, column: np.ndarray) -> np.ndarray:
    """A column as numbers that something can be measured with."""
    try:
        found = column.astype(float)
    except ValueError as error:
        raise TracksError(f"{path}: column {name}: {error}; mend it") from None
    if not (np.abs(found) <= LARGEST).all():  # (not so for NaN)
        raise TracksError(f"{path}: column {name} has a value that is no number up to {LARGEST:g}; mend it")
    return found
