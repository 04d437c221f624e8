"""Write all episodes of an evaluation to a CSV file."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from decimal import Decimal
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.metrics import OUTCOMES, Rows
from jaxwalk.sim.crossing_kind import CONTACTS
from jaxwalk.writing import whole

CONTACT_NAMES = ("", *(kind.word for kind in CONTACTS))
"""Names of the contact types of `jaxwalk.metrics.outcomes`, by number."""
NAMES = ("driver", "pedestrians")
"""Default columns that distinguish cells."""
ENDING = ("outcome", "contact", "impact_speed", "duration")
"""Columns that say how an episode ended; speeds in m/s, durations in s."""


def write_rows(path: str | Path, cells: Iterable[tuple[Any, ...]], *, names: tuple[str, ...] = NAMES) -> None:
    """Write a CSV file with one row per episode; it appears complete or not at all.

    The columns are ``scenario``, the names, `ENDING` and ``map``. Without a collision, contact and impact speed are
    empty.

    Args:
        path: the file.
        cells: for each cell, a value for every name (None: empty), and its `Rows` last.
        names: columns that distinguish cells.
    """
    with whole(path) as unfinished, unfinished.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("scenario", *names, *ENDING, "map"))
        for *values, rows in cells:
            writer.writerows(chain.from_iterable(_episode_rows(values, chunk) for chunk in rows.chunks()))


def _episode_rows(values: list[Any], rows: Rows) -> Iterable[tuple[Any, ...]]:
    table, step = rows[OUTCOMES], Decimal(f"{rows.dt:.6g}").normalize().as_tuple()
    digits = max(1, -int(step.exponent))  # as many as the duration of a step has
    outcome = np.where(table.goal, "goal", np.where(table.collision, "collision", "timeout"))
    maps = [""] * rows.episodes if rows.maps is None else rows.maps
    columns = (table.scenario, outcome, table.contact, table.collision, table.impact_speed, table.steps, maps)
    for scenario, ending, contact, collision, speed, steps, place in zip(*columns, strict=True):
        impact = f"{speed:.3f}" if collision else ""
        duration = f"{steps * rows.dt:.{digits}f}"
        yield int(scenario), *values, str(ending), CONTACT_NAMES[contact], impact, duration, place
