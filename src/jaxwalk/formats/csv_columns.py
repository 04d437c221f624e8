"""Reader for columns of CSV files from public datasets."""

from __future__ import annotations

import csv
from collections.abc import Collection
from pathlib import Path

import numpy as np
from jaxtyping import Float

from jaxwalk.formats.tracks import LARGEST, LONGEST_WORD, TracksError


def read_columns(path: Path, numbers: Collection[str], words: Collection[str] = ()) -> dict[str, np.ndarray]:
    """Return the named columns of a file. Its first line names all columns; other columns are ignored.

    Args:
        path: the file.
        numbers: columns to return as float64.
        words: columns to return as text.

    Raises:
        TracksError: a file or column is missing, a value isn't a number, or a text is too long.
    """
    if not path.is_file():
        raise TracksError(f"{path}: no such file; it must lie beside the others of its recording")
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = list(csv.reader(file))
    except (csv.Error, UnicodeDecodeError) as error:
        raise TracksError(f"{path}: not a CSV file ({error}); restore it") from None
    head = [name.strip() for name in lines[0]] if lines else []
    if missing := [name for name in (*numbers, *words) if name not in head]:
        raise TracksError(f"{path}: has no column {', '.join(missing)}; is it a file of this dataset?")
    rows = [line for line in lines[1:] if line]
    if any(len(line) != len(head) for line in rows):
        raise TracksError(f"{path}: a line has another number of values than the first; correct it")
    columns = {name: [line[head.index(name)] for line in rows] for name in (*numbers, *words)}
    for name, column in columns.items():
        if (longest := max(map(len, column), default=0)) > LONGEST_WORD:
            raise TracksError(f"{path}: column {name} has a value of {longest:,} characters; correct it")
    # Words are objects, because every row of a text array takes the memory of the longest text.
    return {name: _numbers(path, name, x) if name in numbers else np.array(x, object) for name, x in columns.items()}


def seconds(path: Path, frames: Float[np.ndarray, "row"], rate: float) -> Float[np.ndarray, "row"]:
    """Return the times of frames [s], at a rate above 0 [1/s]. Raises TracksError if a time is beyond LARGEST."""
    with np.errstate(over="ignore"):
        t = frames / rate
    if not (np.abs(t) <= LARGEST).all():
        raise TracksError(
            f"{path}: at {rate:g} frames per second, a time is beyond {LARGEST:g} s; check the frame rate"
        )
    return t


def _numbers(path: Path, name: str, column: list[str]) -> np.ndarray:
    """Return a column as float64. Raises TracksError if a value isn't a number up to LARGEST."""
    try:
        found = np.array([float(value) for value in column], float)
    except ValueError as error:
        raise TracksError(f"{path}: column {name}: {error}; correct it") from None
    if not (np.abs(found) <= LARGEST).all():  # also false for NaN
        raise TracksError(f"{path}: column {name} has a value that is no number up to {LARGEST:g}; correct it")
    return found
