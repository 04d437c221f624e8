"""Columns of other people's CSV files."""

from __future__ import annotations

import csv
from collections.abc import Collection
from pathlib import Path

import numpy as np

from jaxwalk.formats.tracks import TracksError


def read_columns(path: Path, numbers: Collection[str], words: Collection[str] = ()) -> dict[str, np.ndarray]:
    """The named columns of a file whose first line names them; others are passed over.

    Raises:
        TracksError: there is no such file or column, or a number is none.
    """
    if not path.is_file():
        raise TracksError(f"{path}: no such file; it must lie beside the others of its recording")
    with path.open(newline="", encoding="utf-8") as file:
        lines = list(csv.reader(file))
    head = [name.strip() for name in lines[0]] if lines else []
    if missing := [name for name in (*numbers, *words) if name not in head]:
        raise TracksError(f"{path}: has no column {', '.join(missing)}; is it of this layout?")
    rows = [line for line in lines[1:] if line]
    if any(len(line) != len(head) for line in rows):
        raise TracksError(f"{path}: a line has another number of values than the first; mend it")
    columns = {name: np.array([line[head.index(name)] for line in rows], str) for name in (*numbers, *words)}
    try:
        return {name: values.astype(float) if name in numbers else values for name, values in columns.items()}
    except ValueError as error:
        raise TracksError(f"{path}: {error}; mend it") from None
