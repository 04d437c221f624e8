"""The leaderboard: entries side by side, a table for each world and population, the safest checked driver first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from jaxwalk.evaluation import Cell, Results
from jaxwalk.evaluation.document_parts import Number
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.report.table import MOVING, Table, shown

COLUMNS = ("entry", "checked", "goal %", "collision %", MOVING, "delay [s]", "driver", "scenarios")
CAPTION = (
    "Brackets: 95 % intervals over scenarios, of one training each: they say nothing about training again. Checked "
    "entries came out again elsewhere, and show what they did on fresh scenarios, whose seed follows from the driver's "
    "file; the others show what their authors say. The order is by contacts of the moving car, then by delay; whose "
    "intervals overlap can't be told apart by it."
)


@dataclass(frozen=True)
class BoardLine:
    """An entry's cell: one driver among one population in one world."""

    entry: str
    checked: bool
    results: Results
    cell: Cell

    @property
    def where(self) -> str:
        """World and population, in words."""
        street = self.results.street
        place = street.in_words() if street else "?"
        return f"{place}, {self.cell.pedestrians}, jaywalk multiplier {self.cell.jaywalk_multiplier:g}"

    @property
    def rank(self) -> tuple[bool, float, float]:
        """What entries are ordered by."""
        delay = self.cell.mean_delay.value
        return not self.checked, _moving(self.cell).value or 0.0, float("inf") if delay is None else delay

    def row(self) -> tuple[str, ...]:
        """Return the cells of the table."""
        cell, driver = self.cell, self.results.drivers[0]
        rates = (shown(rate) for rate in (cell.goal_rate, cell.collision_rate, _moving(cell)))
        delay = shown(cell.mean_delay, 1.0, 2)
        return (
            self.entry,
            "yes" if self.checked else "no",
            *rates,
            delay,
            driver.in_words(),
            self.results.scenarios.name,
        )


def _moving(cell: Cell) -> Number:
    """Return the share of episodes in which the moving car touched somebody."""
    return cell.summary[MEASURED_CONTACTS].footprint.moving


def standings(name: str, results: Results, *, checked: bool) -> list[BoardLine]:
    """Return the standings of one entry, one for each of its cells."""
    return [BoardLine(name, checked, results, cell) for cell in results.cells]


def leaderboard(entries: Sequence[BoardLine]) -> dict[str, Table]:
    """Return a table for each world and population, by what these are in words."""
    ordered = sorted(entries, key=lambda one: (one.where, *one.rank))
    tables = groupby(ordered, lambda one: one.where)
    return {where: Table(COLUMNS, tuple(one.row() for one in found)) for where, found in tables}


def page(entries: Sequence[BoardLine]) -> str:
    """Return the leaderboard as Markdown."""
    parts = [part for where, table in leaderboard(entries).items() for part in (f"## {where}", table.markdown())]
    return "\n\n".join(("# Leaderboard", CAPTION, *parts)) + "\n"
