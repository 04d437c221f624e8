"""Rows of evaluations as Parquet files: a file for each table, and in it a row group for each batch of each cell.

    outcomes.parquet, encounters.parquet, ...   the tables of `jaxwalk.metrics.Rows`, with a column ``cell``
    maps.parquet                                the name of each episode's map

A table with a row per episode is in the order of the scenarios; elsewhere ``episode`` counts within the batch. A column
with further axes is a list for each row, its axes one after the other.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import cache, lru_cache, partial
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Shaped

from jaxwalk.evaluation.encounter_file import check_parquet
from jaxwalk.metrics import Rows, measure
from jaxwalk.sim.trajectory import without_episodes
from jaxwalk.writing import whole

ADVICE = "evaluate this part again, or copy it again"
"""What to do about a file that can't be used."""
CELL = "cell"
"""Column with the number of the cell."""
MAPS = "maps"
"""Table with the name of each episode's map."""
AT_ONCE = 32
"""Number of batches of which a column is read at once."""
KEPT = 4
"""Number of columns of stored rows in memory: formulas ask for the same ones again and again."""


class StoredRowsError(ValueError):
    """Files of rows can't be used. The message names the file, says what is wrong and what to do, in one line."""


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
    """The SHA-256 of rows: every column's name, type, shape and bytes, batch after batch."""

    def __init__(self) -> None:
        """Begin without rows."""
        self._digest = hashlib.sha256()

    def update(self, rows: Rows) -> None:
        """Add a batch."""
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
    """Writes rows into a folder, batch after batch. Use it in a ``with``: the files appear at its end, or none.

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
        """Write a batch of a cell."""
        for name, table in tables_of(rows).items():
            arrow = _arrow_table(cell, table)
            if name not in self._files:
                self._files[name] = self._open(name, arrow.schema)
            self._files[name].write_table(arrow)

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


@dataclass(frozen=True)
class StoredCell:
    """The rows of one cell in one folder."""

    folder: Path
    cell: int
    batches: int
    """Number of batches of each cell in this folder."""
    dt: float
    """Duration of a step [s]."""

    def rows(self) -> Iterator[Rows]:
        """Yield the rows of each batch. Raise StoredRowsError if a file can't be used."""
        blank = no_rows()
        names = list(tables_of(blank))
        for found in zip(*(self._batches(name) for name in names), strict=True):
            tables = dict(zip(names, found, strict=True))
            maps = tables.pop(MAPS).map
            known = {name: tables.get(name, empty) for name, empty in blank.tables.items()}
            yield Rows(self.dt, len(maps), blank.metrics, known, maps)

    def column(self, table: str, name: str) -> tuple[np.ndarray, list[int]]:
        """Return a column of all batches, and the number of its rows in each. Raises as `rows` does."""
        from pyarrow import default_memory_pool

        like, groups = getattr(tables_of(no_rows())[table], name), [*self._groups]
        with self._opened(table) as file:
            sizes = [file.metadata.row_group(number).num_rows for number in groups]
            some = (groups[first : first + AT_ONCE] for first in range(0, len(groups), AT_ONCE))
            found = [_values(file.read_row_groups(x, columns=[name], use_threads=False), name, like) for x in some]
        column = np.concatenate(found)
        del found
        default_memory_pool().release_unused()  # else it keeps for later what was read
        return column, sizes

    @property
    def _groups(self) -> range:
        """The row groups of this cell in each file."""
        return range(self.cell * self.batches, (self.cell + 1) * self.batches)

    def _batches(self, name: str) -> Iterator[Any]:
        """Yield a table of each batch."""
        with self._opened(name) as file:
            for number in self._groups:
                yield _table(file.read_row_group(number, use_threads=False), tables_of(no_rows())[name], self.cell)

    @contextmanager
    def _opened(self, table: str) -> Iterator[Any]:
        """Yield the Parquet file of a table; an error inside names it."""
        from pyarrow import ArrowException
        from pyarrow.parquet import ParquetFile

        path = self.folder / f"{table}.parquet"
        try:
            with path.open("rb") as content:
                yield ParquetFile(content)
        except OSError as error:
            raise StoredRowsError(f"{path}: can't be read ({error.strerror or error}); {ADVICE}") from error
        except (ArrowException, ValueError, IndexError, TypeError) as error:
            said = " ".join(str(error).split())[:200]
            raise StoredRowsError(f"{path}: damaged ({said}); {ADVICE}") from error


def _table(read: Any, kind: Any, cell: int) -> Any:
    """Return a table of pyarrow as one like ``kind``. Raise ValueError if it isn't one of this cell."""
    if read.column_names != [CELL, *vars(kind)]:
        raise ValueError(f"its columns are {', '.join(read.column_names)}, not {', '.join([CELL, *vars(kind)])}")
    if (read.column(CELL).to_numpy() != cell).any():
        raise ValueError(f"rows of another cell than {cell}")
    return type(kind)(**{name: _values(read, name, like) for name, like in vars(kind).items()})


def _values(read: Any, name: str, like: np.ndarray) -> np.ndarray:
    """Return a column of a table of pyarrow; all axes but the first are those of ``like``."""
    array = read.unify_dictionaries().column(name).combine_chunks()
    if like.dtype.hasobject:
        return np.array(array.dictionary.to_pylist(), object)[array.indices.to_numpy()]
    flat = array if like.ndim == 1 else array.flatten()
    return flat.to_numpy(zero_copy_only=False).reshape(len(array), *like.shape[1:])


class StoredTable:
    """A table whose columns are read when they are asked for. For ``isinstance`` it has the type of a measured one."""

    def __init__(self, like: Any, column: Callable[[str], np.ndarray]) -> None:
        """Have the type and the names of the columns of ``like``; ``column`` reads the one of a name."""
        self._like = like
        self._column = column

    __class__: Any = property(lambda self: type(self._like))

    def __getattr__(self, name: str) -> np.ndarray:
        """Return a column. Raise AttributeError if there is none, and StoredRowsError if its file can't be used."""
        if name.startswith("_") or name not in vars(self._like):
            raise AttributeError(f"{type(self._like).__name__} has no column {name}")
        return self._column(name)


class StoredTables(Mapping[str, Any]):
    """The tables of stored rows. Only the last `KEPT` columns that were asked for are in memory."""

    def __init__(self, cells: Sequence[StoredCell], episodes: Sequence[int]) -> None:
        """Keep where the rows are, in their order, and the number of ``episodes`` of each batch."""
        self._cells = cells
        self._offsets = np.cumsum([0, *episodes[:-1]])
        self._column = lru_cache(KEPT)(self._read)

    def __getitem__(self, name: str) -> Any:
        """Return a table. Raise KeyError if there is none."""
        like = no_rows().tables[name]
        return StoredTable(like, partial(self._column, name)) if vars(like) else like

    def __iter__(self) -> Iterator[str]:
        return iter(no_rows().tables)

    def __len__(self) -> int:
        return len(no_rows().tables)

    def _read(self, table: str, name: str) -> np.ndarray:
        """Return a column of all cells; ``episode`` counts through all of them."""
        columns, sizes = zip(*(cell.column(table, name) for cell in self._cells), strict=True)
        column = np.concatenate(columns)
        if name == "episode":
            column += np.repeat(self._offsets.astype(column.dtype), [*chain.from_iterable(sizes)])
        return column


def stored_rows(cells: Sequence[StoredCell]) -> Rows:
    """Return the rows of one cell in the folders of all its parts, which are in the order of their scenarios.

    Columns are read when they are asked for. Raise StoredRowsError if a file can't be used.
    """
    maps, sizes = zip(*(cell.column(MAPS, "map") for cell in cells), strict=True)
    episodes = [*chain.from_iterable(sizes)]
    return Rows(cells[0].dt, sum(episodes), no_rows().metrics, StoredTables(cells, episodes), np.concatenate(maps))
