"""Write all encounters of an evaluation to one Parquet file, which pandas, polars and DuckDB read."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.evaluation.episode_file import CONTACT_NAMES
from jaxwalk.metrics import ENCOUNTERS, SURROGATES, Rows
from jaxwalk.metrics.braking import NAMES
from jaxwalk.writing import whole

UNITS = {
    "enter": "s", "start": "s", "end": "s", "min_distance": "m", "min_gap": "m", "entry_speed": "m/s",
    "braking_time": "s", "ttc": "s", "exposed_time": "s", "pet": "s", "t2": "s", "drac": "m/s2", "impact_speed": "m/s",
    "relative_speed": "m/s",
}  # fmt: skip
"""Units of the columns; the file keeps them as metadata."""


class MissingLibraryError(ValueError):
    """Raised if a needed library is not installed; the message names the extra that installs it."""


def check_parquet() -> None:
    """Raise MissingLibraryError if Parquet files cannot be written."""
    if importlib.util.find_spec("pyarrow") is None:
        raise MissingLibraryError('Parquet files need pyarrow; install it with: pip install "jaxwalk[data]"')


def encounter_columns(rows: Rows) -> dict[str, Any]:
    """Return one row per encounter: times in s since the episode's start; NaN (null in files) for missing values."""
    table, surrogates = rows[ENCOUNTERS], rows[SURROGATES]
    seconds = {name: getattr(table, name) * rows.dt for name in ("enter", "start", "end")}
    return {
        "scenario": table.scenario,
        "pedestrian": table.ped,
        "crossing": table.number,
        "type": np.array(CONTACT_NAMES)[table.type],
        **seconds,
        "min_distance": table.min_distance,
        "min_gap": table.min_gap,
        "entry_speed": table.entry_speed,
        "collided": table.collided,
        "braking": np.array(NAMES)[table.braking],
        "braking_time": table.braking_time,
        **{name: getattr(surrogates, name) for name in UNITS if hasattr(surrogates, name)},
    }


def write_encounters(path: str | Path, cells: Iterable[tuple[str, str, float, Rows]]) -> None:
    """Write the encounters of at least one cell (driver, pedestrians, jaywalk multiplier, rows); all or nothing.

    Raise MissingLibraryError without pyarrow.
    """
    check_parquet()
    from pyarrow.parquet import ParquetWriter

    tables = (
        _table(driver, people, multiplier, chunk)
        for driver, people, multiplier, rows in cells
        for chunk in rows.chunks()
    )
    first = next(tables)
    with whole(path) as unfinished, ParquetWriter(unfinished, first.schema, compression="zstd") as writer:
        for table in chain([first], tables):
            writer.write_table(table)


def _table(driver: str, people: str, multiplier: float, rows: Rows) -> Any:
    """Return the encounters of a chunk of a cell as a pyarrow table."""
    import pyarrow

    columns = encounter_columns(rows)
    names = {"driver": driver, "pedestrians": people, "multiplier": multiplier}
    arrays = {name: pyarrow.repeat(value, len(columns["scenario"])) for name, value in names.items()}
    arrays |= {name: pyarrow.array(column, from_pandas=True) for name, column in columns.items()}
    units = {name: {"unit": UNITS[name]} if name in UNITS else None for name in arrays}
    schema = pyarrow.schema([pyarrow.field(name, x.type, metadata=units[name]) for name, x in arrays.items()])
    return pyarrow.table(list(arrays.values()), schema=schema)
