"""Trajectories as a Parquet file, written and read in groups of episodes."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.formats.areas import Areas, parse_areas
from jaxwalk.formats.tracks import (
    CAR,
    LARGEST,
    LONGEST_WORD,
    OF_CARS,
    OPTIONAL,
    PEDESTRIAN,
    REQUIRED,
    UNITS,
    Tracks,
    TracksError,
)
from jaxwalk.writing import whole

SCHEMA = 1
"""Version of the table."""
KEY, AREAS = b"jaxwalk", b"jaxwalk_areas"
"""Keys of the file's metadata: a description of the file, and the areas, each as JSON."""
EPISODES = 32
"""Episodes in each row group of the file. A row group is read at once."""
MOST_ROWS = 4_000_000
"""Largest number of rows of a row group, and of the part of an episode in earlier row groups."""
WORDS = ("type", *(name for name, empty in OPTIONAL.items() if isinstance(empty, str)))
"""Columns that hold text."""
FINITE = ("t", "x", "y", "vx", "vy", "heading")
"""Columns that must be finite, because the metrics need them."""


def check_parquet() -> None:
    """Raise TracksError if pyarrow, which reads and writes Parquet files, is missing."""
    if importlib.util.find_spec("pyarrow") is None:
        raise TracksError('Parquet files need pyarrow; install it with: pip install "jaxwalk[data]"')


def write_tracks(
    path: str | Path, recordings: Iterable[Tracks], *, about: Mapping[str, Any], areas: Mapping[str, Any] | None = None
) -> None:
    """Write recordings; the file appears whole or not at all.

    Args:
        path: the file.
        recordings: at least one, all with the same optional columns; they are read in groups.
        about: a description for the file's metadata: ``dt`` [s] and any other JSON values.
        areas: GeoJSON of the areas, as `jaxwalk.formats.areas.areas_of` returns it.

    Raises:
        TracksError: pyarrow is missing, or there is nothing to write.
    """
    check_parquet()
    from pyarrow.parquet import ParquetWriter

    metadata = {KEY: json.dumps({"schema": SCHEMA, **about}, allow_nan=False)}
    metadata |= {AREAS: json.dumps(areas)} if areas else {}
    left = iter(recordings)
    tables = map(_table, iter(lambda: list(islice(left, EPISODES)), []))
    first = next(tables, None)
    if first is None:
        raise TracksError(f"{path}: there are no trajectories to write")
    schema = first.schema.with_metadata(metadata)
    with whole(path) as unfinished, ParquetWriter(unfinished, schema, compression="zstd") as writer:
        for table in chain([first], tables):
            writer.write_table(table.cast(schema))


def _table(recordings: list[Tracks]) -> Any:
    """Return recordings as a pyarrow table. A column is null in rows of a type that doesn't have it."""
    import pyarrow

    columns = {name: np.concatenate([getattr(one, name) for one in recordings]) for name in REQUIRED[1:]}
    rows = [len(one.t) for one in recordings]
    columns = {"episode": np.repeat(np.array([one.episode for one in recordings], np.int64), rows), **columns}
    of_car, of_person = (columns["type"] == kind for kind in (CAR, PEDESTRIAN))
    arrays = {name: pyarrow.array(values) for name, values in columns.items()}
    for name in recordings[0].known:
        values = np.concatenate([one.known[name] for one in recordings])
        arrays[name] = pyarrow.array(values, mask=~(of_car if name in OF_CARS else of_person))
    units = {name: {"unit": UNITS[name]} if name in UNITS else None for name in arrays}
    schema = pyarrow.schema([pyarrow.field(name, x.type, metadata=units[name]) for name, x in arrays.items()])
    return pyarrow.table(list(arrays.values()), schema=schema)


class TrackFile:
    """A Parquet file of trajectories, written by jaxwalk or by another program."""

    def __init__(self, path: str | Path) -> None:
        """Open the file. Raises TracksError if it isn't a table of trajectories."""
        check_parquet()
        import pyarrow
        from pyarrow.parquet import ParquetFile

        self.path = Path(path)
        try:
            schema = ParquetFile(self.path).schema_arrow
            words = [x.name for x in schema if x.name in WORDS and x.type in (pyarrow.string(), pyarrow.large_string())]
            self._file = ParquetFile(self.path, read_dictionary=words)
        except (pyarrow.ArrowException, UnicodeDecodeError, OSError) as error:
            raise TracksError(f"{path}: not a Parquet file ({error}); write it again") from None
        names = set(schema.names)
        if twice := [name for name in names if schema.names.count(name) > 1]:
            raise TracksError(f"{path}: has several columns {', '.join(sorted(twice))}; keep one of each")
        missing = [name for name in REQUIRED if name not in names]
        if missing:
            raise TracksError(f"{path}: has no column {', '.join(missing)}; add what is missing (docs: trajectories)")
        for field in schema:
            self._check_type(field)
        metadata = schema.metadata or {}
        self.about: dict[str, Any] = self._json(metadata, KEY)
        if self.about.get("schema", SCHEMA) != SCHEMA:
            raise TracksError(f"{path}: is of schema {self.about['schema']}, which this jaxwalk can't read; update it")
        self.areas: Areas | None = parse_areas(self._json(metadata, AREAS), f"{path}") if AREAS in metadata else None
        self.known = tuple(name for name in OPTIONAL if name in names)

    def _check_type(self, field: Any) -> None:
        """Raise TracksError if reading a column could fill memory: text must be dictionary-encoded."""
        from pyarrow import types

        kind = field.type.value_type if types.is_dictionary(field.type) else field.type
        if field.name in WORDS:
            small = types.is_string(kind) or types.is_large_string(kind) or types.is_null(kind)
        elif field.name in REQUIRED or field.name in OPTIONAL:
            small = types.is_primitive(field.type) or types.is_decimal(field.type) or types.is_null(field.type)
        else:  # other columns aren't read
            small = True
        if not small:
            wanted = _kind(field.name, field.type)
            raise TracksError(f"{self.path}: column {field.name} holds {field.type}; make it {wanted}")

    def _json(self, metadata: Mapping[bytes, bytes], key: bytes) -> dict[str, Any]:
        """Return an object of the file's metadata, or {} if it is missing. Raises TracksError if it isn't an object."""
        try:
            found = json.loads(metadata.get(key, b"{}"))
        except (ValueError, RecursionError) as error:
            raise TracksError(f"{self.path}: metadata {key.decode()} isn't JSON ({error}); write it again") from None
        if not isinstance(found, dict):
            raise TracksError(f"{self.path}: metadata {key.decode()} isn't an object; write it again")
        return found

    def recordings(self) -> Iterator[Tracks]:
        """Yield every recording. Raises TracksError if a value is invalid or the rows aren't sorted by episode."""
        ended, rest = set(), None
        for group in range(self._file.num_row_groups):
            table = self._columns(group)
            if rest is not None:
                self._check_rows(len(rest["t"]), f"in episode {rest['episode'][0]}")
                table = {name: np.concatenate([rest[name], table[name]]) for name in table}
            bounds = np.flatnonzero(np.diff(table["episode"])) + 1
            parts = [
                {name: values[begin:end] for name, values in table.items()}
                for begin, end in zip([0, *bounds], [*bounds, len(table["t"])], strict=True)
            ]
            yield from (self._recording(part, ended) for part in parts[:-1])
            rest = parts[-1]
        if rest is not None and len(rest["t"]):
            yield self._recording(rest, ended)

    def _columns(self, group: int) -> dict[str, np.ndarray]:
        """Return all columns of a row group. Raises TracksError if it is too large or damaged."""
        from pyarrow import ArrowException

        names = (*REQUIRED, *self.known)
        rows = self._file.metadata.row_group(group).num_rows
        self._check_rows(rows, "in a group")
        try:
            table = self._file.read_row_group(group, columns=list(names))
        except (ArrowException, UnicodeDecodeError, OSError) as error:
            raise TracksError(f"{self.path}: damaged ({error}); write it again") from None
        return {name: self._column(name, table[name]) for name in names}

    def _check_rows(self, rows: int, where: str) -> None:
        """Raise TracksError if there are more than MOST_ROWS rows."""
        if rows > MOST_ROWS:
            raise TracksError(f"{self.path}: has {rows:,} rows {where}; write it with at most {MOST_ROWS:,}")

    def _column(self, name: str, column: Any) -> np.ndarray:
        """Return a pyarrow column as an array of the right type. Raises TracksError if that is impossible.

        Only optional columns may have empty values.
        """
        import pyarrow
        from pyarrow.compute import fill_null

        if name in WORDS:
            column = self._words(name, column)
        if name in REQUIRED and column.null_count:
            raise TracksError(f"{self.path}: column {name} has empty values; fill them")
        kind = _kind(name, column.type)
        try:
            column = column.cast(kind)
        except pyarrow.ArrowException:
            raise TracksError(f"{self.path}: column {name} holds {column.type}; make it {kind}") from None
        try:
            return (fill_null(column, OPTIONAL[name]) if name in OPTIONAL else column).to_numpy()
        except (pyarrow.ArrowException, UnicodeDecodeError):
            raise TracksError(f"{self.path}: column {name} has text that isn't UTF-8; write it again") from None

    def _words(self, name: str, column: Any) -> Any:
        """Return a column of text. Decodes its dictionary only after checking that no text is too long."""
        import pyarrow
        from pyarrow.compute import call_function

        if not pyarrow.types.is_dictionary(column.type):
            return column
        lengths = [call_function("binary_length", [chunk.dictionary]) for chunk in column.chunks]
        longest = [call_function("max", [x]).as_py() or 0 for x in lengths]
        if max(longest, default=0) > LONGEST_WORD:
            raise TracksError(f"{self.path}: column {name} has words of {max(longest):,} characters; correct it")
        return column.cast(column.type.value_type)

    def _recording(self, part: Mapping[str, np.ndarray], ended: set[int]) -> Tracks:
        """Return the rows of one episode as a recording, and add its number to ``ended``.

        Raises TracksError if the episode is already in ``ended``, or if a column isn't finite.
        """
        episode = int(part["episode"][0])
        if episode in ended:
            raise TracksError(f"{self.path}: the rows of episode {episode} are not together; sort the table by episode")
        ended.add(episode)
        known = {name: part[name] for name in self.known}
        tracks = Tracks(episode=episode, known=known, **{name: part[name] for name in REQUIRED[1:]})
        for name in FINITE:
            if not (np.abs(part[name]) <= LARGEST).all():  # also false for NaN
                raise TracksError(f"{self.path}: column {name} of episode {episode} is not finite; correct it")
        return tracks


def _kind(name: str, found: Any) -> Any:
    """Return the pyarrow type that a column must have. Numbers keep their precision."""
    import pyarrow

    if name in ("episode", "id"):
        return pyarrow.int64()
    if name in UNITS or isinstance(OPTIONAL.get(name), float):
        return found if pyarrow.types.is_floating(found) else pyarrow.float64()
    kinds = {bool: pyarrow.bool_(), int: pyarrow.int16(), str: pyarrow.string()}
    return kinds[type(OPTIONAL.get(name, ""))]
