"""Trajectories as a Parquet file, written and read some episodes at a time."""

from __future__ import annotations

import importlib.util
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.formats.areas import Areas, parse_areas
from jaxwalk.formats.tracks import CAR, OF_CARS, OPTIONAL, PEDESTRIAN, REQUIRED, UNITS, Tracks, TracksError

SCHEMA = 1
"""Version of the table."""
KEY, AREAS = b"jaxwalk", b"jaxwalk_areas"
"""The file's metadata: what it is, and the ground, each as JSON."""
EPISODES = 32
"""Episodes in each group of rows of the file, which is read at once."""
FINITE = ("t", "x", "y", "vx", "vy", "heading")
"""Columns without which nothing can be measured."""


def check_parquet() -> None:
    """Raise TracksError if Parquet files can't be read or written."""
    if importlib.util.find_spec("pyarrow") is None:
        raise TracksError('Parquet files need pyarrow; install it with: pip install "jaxwalk[data]"')


def write_tracks(
    path: str | Path, recordings: Iterable[Tracks], *, about: Mapping[str, Any], areas: Mapping[str, Any] | None = None
) -> None:
    """Write recordings; the file appears whole or not at all.

    Args:
        path: the file.
        recordings: at least one, all with the same optional columns; they are taken some at a time.
        about: kept in the file's metadata with the version of the table: ``dt`` [s], and what else describes it.
        areas: GeoJSON of the ground, as `jaxwalk.formats.areas.areas_of` makes it.

    Raises:
        TracksError: pyarrow is missing, or there is nothing to write.
    """
    check_parquet()
    from pyarrow.parquet import ParquetWriter

    path = Path(path)
    unfinished, writer = path.with_name(f".{path.name}.{os.getpid()}.part"), None
    metadata = {KEY: json.dumps({"schema": SCHEMA, **about}, allow_nan=False)} | (
        {AREAS: json.dumps(areas)} if areas else {}
    )
    try:
        left = iter(recordings)
        while some := list(islice(left, EPISODES)):
            table = _table(some)
            schema = table.schema.with_metadata(metadata)
            writer = writer or ParquetWriter(unfinished, schema, compression="zstd")
            writer.write_table(table.cast(schema))
        if writer is None:
            raise TracksError(f"{path}: there are no trajectories to write")
        writer.close()
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)


def _table(recordings: list[Tracks]) -> Any:
    """Recordings as a table of pyarrow's; what a row's type has no value of is null."""
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
    """A Parquet file of trajectories, ours or anybody's."""

    def __init__(self, path: str | Path) -> None:
        """Open it. TracksError if it is no such file."""
        check_parquet()
        import pyarrow
        from pyarrow.parquet import ParquetFile

        self.path = Path(path)
        try:
            self._file = ParquetFile(self.path)
        except pyarrow.ArrowInvalid as error:
            raise TracksError(f"{path}: no Parquet file ({error}); write it anew") from None
        names = set(self._file.schema_arrow.names)
        missing = [name for name in REQUIRED if name not in names]
        if missing:
            raise TracksError(f"{path}: has no column {', '.join(missing)}; docs/trajectories.md lists all")
        metadata = self._file.schema_arrow.metadata or {}
        self.about: dict[str, Any] = json.loads(metadata.get(KEY, b"{}"))
        if self.about.get("schema", SCHEMA) != SCHEMA:
            raise TracksError(f"{path}: is of schema {self.about['schema']}, which this jaxwalk can't read; update it")
        self.areas: Areas | None = parse_areas(json.loads(metadata[AREAS]), f"{path}") if AREAS in metadata else None
        self.known = tuple(name for name in OPTIONAL if name in names)

    def recordings(self) -> Iterator[Tracks]:
        """Every recording, one after the other. TracksError for values that can't be, or rows in disorder."""
        ended, rest = set(), None
        for group in range(self._file.num_row_groups):
            table = self._columns(group)
            if rest is not None:
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
        """All columns of a group of rows."""
        names = (*REQUIRED, *self.known)
        table = self._file.read_row_group(group, columns=list(names))
        return {name: self._column(name, table[name]) for name in names}

    def _column(self, name: str, column: Any) -> np.ndarray:
        """A column of pyarrow's, of the type that it must have. Only the optional ones may have empty values."""
        import pyarrow
        from pyarrow.compute import fill_null

        if name in REQUIRED and column.null_count:
            raise TracksError(f"{self.path}: column {name} has empty values; fill them")
        kind = _kind(name, column.type)
        try:
            column = column.cast(kind)
        except pyarrow.ArrowException:
            raise TracksError(f"{self.path}: column {name} holds {column.type}; make it {kind}") from None
        return (fill_null(column, OPTIONAL[name]) if name in OPTIONAL else column).to_numpy()

    def _recording(self, part: Mapping[str, np.ndarray], ended: set[int]) -> Tracks:
        """The rows of one episode as a recording; ``ended`` has those that came before, and gets this one."""
        episode = int(part["episode"][0])
        if episode in ended:
            raise TracksError(f"{self.path}: the rows of episode {episode} are not together; sort the table by episode")
        ended.add(episode)
        known = {name: part[name] for name in self.known}
        tracks = Tracks(episode=episode, known=known, **{name: part[name] for name in REQUIRED[1:]})
        for name in FINITE:
            if not np.isfinite(part[name]).all():
                raise TracksError(f"{self.path}: column {name} of episode {episode} is not finite throughout; mend it")
        return tracks


def _kind(name: str, found: Any) -> Any:
    """The type that a column must have; numbers keep their precision."""
    import pyarrow

    if name in ("episode", "id"):
        return pyarrow.int64()
    if name in UNITS or isinstance(OPTIONAL.get(name), float):
        return found if pyarrow.types.is_floating(found) else pyarrow.float64()
    kinds = {bool: pyarrow.bool_(), int: pyarrow.int16(), str: pyarrow.string()}
    return kinds[type(OPTIONAL.get(name, ""))]
