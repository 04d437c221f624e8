"""What is kept of measured episodes: small tables of NumPy columns, which can be joined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np

from jaxwalk.metrics.attribution import Exposure
from jaxwalk.metrics.crossings import Crossings
from jaxwalk.metrics.decisions import Decisions
from jaxwalk.metrics.encounters import Encounters
from jaxwalk.metrics.meetings import Meetings
from jaxwalk.metrics.outcomes import Episodes
from jaxwalk.metrics.speed_differential import NearSpeeds, PlaceboSpeeds
from jaxwalk.metrics.surrogate import Surrogates
from jaxwalk.metrics.waiting import KerbMoments

Table = TypeVar("Table")


@dataclass(frozen=True)
class Rows:
    """Everything measured. In every table, ``episode`` is a row of ``episodes``."""

    dt: float
    """Duration of a step [s]."""
    episodes: Episodes
    exposure: Exposure
    """One row per episode."""
    near_speeds: NearSpeeds
    """One row per episode."""
    placebo: PlaceboSpeeds
    """One row per episode."""
    waiting: KerbMoments
    """One row per episode."""
    crossings: Crossings
    encounters: Encounters
    meetings: Meetings
    surrogates: Surrogates
    """One row per row of ``encounters``."""
    decisions: Decisions

    @staticmethod
    def join(parts: Sequence[Rows]) -> Rows:
        """The rows of all parts, as if their episodes had been measured together."""
        if not parts:
            raise ValueError("there are no rows to join")
        steps = {part.dt for part in parts}
        if len(steps) > 1:
            raise ValueError(f"rows of different step durations cannot be joined: {sorted(steps)} s")
        sizes = [len(part.episodes.scenario) for part in parts]
        offsets = np.cumsum([0, *sizes[:-1]])
        tables: dict[str, Any] = {
            field.name: _join_tables([getattr(part, field.name) for part in parts], offsets)
            for field in fields(Rows)
            if field.name != "dt"
        }
        return Rows(dt=parts[0].dt, **tables)


def _join_tables(tables: Sequence[Table], offsets: np.ndarray) -> Table:
    """One table below the other; ``episode`` columns count on."""
    columns = {}
    for name in vars(tables[0]):
        parts = [getattr(table, name) for table in tables]
        if name == "episode":
            parts = [(part + offset).astype(part.dtype) for part, offset in zip(parts, offsets, strict=True)]
        columns[name] = np.concatenate(parts)
    return type(tables[0])(**columns)
