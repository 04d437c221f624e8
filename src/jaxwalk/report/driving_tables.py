"""The tables of what happens where nobody is hit: who waits, who goes first, and how the car drives."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

from jaxwalk.evaluation.results import Cell
from jaxwalk.metrics import APPROACHES, COMFORT, GAPS, PASSING
from jaxwalk.metrics.passing import CLEARANCES
from jaxwalk.report.table import Table, shown

Named = Iterable[tuple[str, Cell]]
"""Cells with the names that a table shows."""

KERB = (
    "Approaches to the kerb with a dangerous moment: shares of those in which the person waits through the first one, "
    "steps onto the road straight from one, and (at crosswalks, where somebody went first) goes first without being "
    "touched. Gaps: time until the car's front is abreast of the person, at its present speed: the median of those "
    "that people accept, one in twenty of which is shorter than the next column, and the median of the largest that "
    "each person lets pass."
)
DRIVING = (
    "Harsh: braking of 2.5 m/s² or more while the car rolls, as a share of steps, and how often it begins per km. "
    "Jerk: root mean square. Passing: mean speed where the car was nearest to somebody on a roadway, by the gap "
    "between its footprint and the body, without a contact."
)


def kerb(cells: Named) -> Table:
    """Return how approaches to the kerb end, and which gaps people accept."""
    columns = (
        "driver", "approaches", "wait %", "enter in danger %", "car yields %", "accepted gap [s]",
        "5 % shorter than [s]", "largest gap let pass [s]",
    )  # fmt: skip
    rows = []
    for name, cell in cells:
        found, gaps = cell.summary[APPROACHES], cell.summary[GAPS]
        shares = (shown(share) for share in (found.waited, found.entered_in_danger, found.yielded))
        times = (shown(gap, 1.0) for gap in (gaps.accepted, gaps.shortest, gaps.rejected))
        rows.append((name, f"{found.waited.count:,}", *shares, *times))
    return Table(columns, tuple(rows))


def driving(cells: Named) -> Table:
    """Return how harshly the car drives, and how fast it passes people."""
    bins = (f"at {near:g} to {far:g} m" for near, far in pairwise(CLEARANCES))
    columns = ("driver", "harsh %", "harsh per km", "jerk [m/s³]", *(f"passing {where} [m/s]" for where in bins))
    rows = []
    for name, cell in cells:
        found = cell.summary[COMFORT]
        numbers = shown(found.harsh), shown(found.harsh_per_km, 1.0), shown(found.jerk, 1.0)
        rows.append((name, *numbers, *(shown(one.speed, 1.0) for one in cell.summary[PASSING])))
    return Table(columns, tuple(rows))
