"""Rows of evaluations as Parquet files: a file for each table, and in it a row group for each piece of each cell.

    outcomes.parquet, encounters.parquet, ...   the tables of `jaxwalk.metrics.Rows`, with a column ``cell``
    maps.parquet                                the name of each episode's map

A table with a row per episode is in the order of the scenarios; elsewhere ``episode`` counts within the piece. A column
with further axes is a list for each row, its axes one after the other.
"""

from __future__ import annotations

import hashlib
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Shaped

from jaxwalk.evaluation.encounter_file import check_parquet
from jaxwalk.metrics import Rows, measure
from jaxwalk.sim.trajectory import without_episodes
from jaxwalk.writing import whole

CELL = "cell"
"""Column with the number of the cell."""
MAPS = "maps"
"""Table with the name of each episode's map."""


@dataclass(frozen=True)
class EpisodeMaps:
    """One row per episode."""

    map: Shaped[np.ndarray, "episode"]
    """The name of its map."""


@cache
def no_rows() -> Rows:
    """Return the rows of no episodes: all tables, empty."""
    return replace(measure(without_episodes()), maps=np.zeros(0, object))


def tables_of(rows: Rows) -> dict[str, Any]:
    """Return the tables that have columns, and that of the maps. Raise ValueError if the maps aren't known."""
    if rows.maps is None:
        raise ValueError("only rows whose maps are known are stored")
    return {**{name: table for name, table in rows.tables.items() if vars(table)}, MAPS: EpisodeMaps(rows.maps)}


class RowDigest:
    """The SHA-256 of rows: every column's name, type, shape and bytes, piece after piece."""

    def __init__(self) -> None:
        """Begin without rows."""
        self._digest = hashlib.sha256()

    def update(self, rows: Rows) -> None:
        """Add a piece."""
        for table, found in tables_of(rows).items():
            for name, column in vars(found).items():
                text = column.dtype.hasobject
                content = "\n".join(column).encode() if text else np.ascontiguousarray(column).tobytes()
                kind = "text" if text else column.dtype.newbyteorder("<").str
                self._digest.update(f"{table} {name} {kind} {column.shape} {len(content)}\n".encode())
                self._digest.update(content)

    @property
    def digits(self) -> str:
        """All hexadecimal digits."""
        return self._digest.hexdigest()


class RowWriter:
    """Writes rows into a folder, piece after piece. Use it in a ``with``: the files appear at its end, or none.

    Raises MissingLibraryError without pyarrow.
    """

    def __init__(self, folder: Path) -> None:
        """Write into ``folder``, which exists."""
        check_parquet()
        self._folder = folder
        self._files: dict[str, Any] = {}
        self._stack = ExitStack()

    def __enter__(self) -> RowWriter:
        return self

    def __exit__(self, *error: Any) -> None:
        self._stack.__exit__(*error)

    def write(self, cell: int, rows: Rows) -> None:
        """Write a piece of a cell: a row group, however many rows it has."""
        for name, table in tables_of(rows).items():
            arrow = _arrow_table(cell, table)
            if name not in self._files:
                self._files[name] = self._open(name, arrow.schema)
            self._files[name].write_table(arrow, row_group_size=max(arrow.num_rows, 1))

    def _open(self, name: str, schema: Any) -> Any:
        from pyarrow.parquet import ParquetWriter

        unfinished = self._stack.enter_context(whole(self._folder / f"{name}.parquet"))
        return self._stack.enter_context(ParquetWriter(unfinished, schema, compression="zstd", write_statistics=False))


def _arrow_table(cell: int, table: Any) -> Any:
    """Return a table as one of pyarrow."""
    import pyarrow

    columns = vars(table)
    arrays = [pyarrow.array(np.full(len(next(iter(columns.values()))), cell, np.int32))]
    for column in columns.values():
        flat = pyarrow.array(column.reshape(-1))
        size = int(np.prod(column.shape[1:]))
        array = flat if column.ndim == 1 else pyarrow.FixedSizeListArray.from_arrays(flat, size)
        arrays.append(array.dictionary_encode() if column.dtype.hasobject else array)
    return pyarrow.table(arrays, names=[CELL, *columns])
