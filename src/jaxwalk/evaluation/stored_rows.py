"""Read the rows that `jaxwalk.evaluation.row_files` keeps: no more of them are in memory than a formula asks for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from jaxwalk.evaluation.row_files import CELL, MAPS, no_rows, tables_of
from jaxwalk.metrics import Rows
from jaxwalk.metrics.metric import MetricTable
from jaxwalk.metrics.statistics import CHUNK

T = TypeVar("T")
ADVICE = "evaluate this part again, or copy it again"
"""What to do about a file that can't be used."""


class StoredRowsError(ValueError):
    """Files of rows can't be used. The message names the file, says what is wrong and what to do, in one line."""


@dataclass(frozen=True)
class StoredCell:
    """The rows of one cell in one folder."""

    folder: Path
    cell: int
    pieces: tuple[int, ...]
    """Number of episodes in each row group of the cell."""
    dt: float
    """Duration of a step [s]."""

    def rows(self) -> Iterator[Rows]:
        """Yield the rows of each piece. Raise StoredRowsError if a file can't be used."""
        blank = no_rows()
        names = list(tables_of(blank))
        for found in zip(*(self._pieces(name) for name in names), strict=True):
            tables = dict(zip(names, found, strict=True))
            maps = tables.pop(MAPS).map
            known = {name: tables.get(name, empty) for name, empty in blank.tables.items()}
            yield Rows(self.dt, len(maps), blank.metrics, known, maps)

    def column(self, table: str, name: str, number: int) -> np.ndarray:
        """Return a column of one piece. Raises as `rows` does."""
        like = getattr(tables_of(no_rows())[table], name)
        with self._opened(table) as file:
            return _values(file.read_row_group(self._groups[number], columns=[name], use_threads=False), name, like)

    @property
    def _groups(self) -> range:
        """The row groups of this cell in each file."""
        return range(self.cell * len(self.pieces), (self.cell + 1) * len(self.pieces))

    def _pieces(self, name: str) -> Iterator[Any]:
        """Yield a table of each piece."""
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


@dataclass(frozen=True)
class StoredPiece:
    """The rows of some consecutive episodes of a cell: a row group of each file of one folder."""

    cell: StoredCell
    number: int
    episodes: int


class StoredTables(Mapping[str, Any]):
    """The tables of consecutive pieces. A column is read when it is first asked for."""

    def __init__(self, pieces: Sequence[StoredPiece]) -> None:
        """Keep where the rows are, in their order."""
        self._pieces = pieces
        self._found: dict[tuple[str, str], np.ndarray] = {}

    def __getitem__(self, name: str) -> Any:
        """Return a table. Raise KeyError if there is none."""
        like = no_rows().tables[name]
        return StoredTable(like, partial(self._column, name)) if vars(like) else like

    def __iter__(self) -> Iterator[str]:
        return iter(no_rows().tables)

    def __len__(self) -> int:
        return len(no_rows().tables)

    def maps(self) -> np.ndarray:
        """Return the name of each episode's map."""
        return self._read(MAPS, "map")

    def _column(self, table: str, name: str) -> np.ndarray:
        """Return a column, which stays in memory as long as these tables."""
        if (table, name) not in self._found:
            self._found[table, name] = self._read(table, name)
        return self._found[table, name]

    def _read(self, table: str, name: str) -> np.ndarray:
        """Return a column; ``episode`` counts through all pieces."""
        columns, before = [], 0
        for piece in self._pieces:
            column = piece.cell.column(table, name, piece.number)
            columns.append((column + before).astype(column.dtype) if name == "episode" else column)
            before += piece.episodes
        return np.concatenate(columns)


@dataclass(frozen=True)
class StoredRows(Rows):
    """Rows that are read a chunk at a time, and within it column by column. As a whole they have no tables or maps."""

    pieces: tuple[StoredPiece, ...] = ()
    """In the order of their scenarios; none goes across a multiple of `CHUNK` episodes."""

    def __getitem__(self, table: MetricTable[T]) -> T:
        """Raise TypeError: a chunk has tables."""
        raise TypeError(f"{table.name} of parts is read a chunk at a time: use chunks, total or values")

    def chunks(self) -> Iterator[Rows]:
        """Yield the rows of `CHUNK` episodes at a time. Raise StoredRowsError if a file can't be used."""
        ends = np.cumsum([piece.episodes for piece in self.pieces])
        for _, found in groupby(zip(self.pieces, ends.tolist(), strict=True), key=lambda found: -(-found[1] // CHUNK)):
            pieces = [piece for piece, _ in found]
            tables = StoredTables(pieces)
            yield Rows(self.dt, sum(piece.episodes for piece in pieces), self.metrics, tables, tables.maps())


def stored_rows(cells: Sequence[StoredCell]) -> StoredRows:
    """Return the rows of one cell in the folders of all its parts, which are in the order of their scenarios."""
    pieces = [StoredPiece(cell, *found) for cell in cells for found in enumerate(cell.pieces)]
    episodes = sum(piece.episodes for piece in pieces)
    return StoredRows(cells[0].dt, episodes, no_rows().metrics, {}, pieces=tuple(pieces))
