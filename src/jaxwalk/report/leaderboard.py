"""The leaderboard: entries side by side, a table for those that played by the same rules, the safest checked first."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from jaxwalk.evaluation import Cell, Results
from jaxwalk.evaluation.document_parts import Number, PolicyOrigin
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.report.table import MOVING, Table, markdown_table, shown
from jaxwalk.wording import counted, plain_markdown

COLUMNS = ("entry", "checked", "goal %", "collision %", MOVING, "delay [s]", "driver", "scenarios")
CAPTION = (
    "Brackets: 95 % intervals over scenarios, of one training each: they say nothing about training again. Checked "
    "entries came out again elsewhere, and show what they did on fresh scenarios, whose seed follows from all files of "
    "the entry; the others show what their authors say. The order is by contacts of the moving car, then by delay; "
    "whose intervals overlap can't be told apart by it."
)
RULES_DIGITS = 8
"""Number of hexadecimal digits of a hash of rules."""
LONGEST_NAME = 60
"""Longest name of an entry that is shown [characters]."""
OF_FILES = ("run folder", "policy file", "file")
"""Kinds of policies that their hash identifies, whatever they are called in an entry."""


@dataclass(frozen=True)
class BoardLine:
    """An entry's cell: one driver among one population in one world."""

    entry: str
    checked: bool
    results: Results
    cell: Cell

    @property
    def rules(self) -> str:
        """The hash of all that decides results besides the driver and the seed: equal rules, equal hashes."""
        street, cell = self.results.street, self.cell
        if street is None:
            raise ValueError(f"{self.entry}: its results don't say by which rules they were made")
        crowd = next(one for one in self.results.populations if one.name == cell.pedestrians)
        rules = {
            "maps": [text.hash for text in street.maps],
            "sim": {**asdict(street.sim), "jaywalk_multiplier": cell.jaywalk_multiplier},
            "people": [_identity(crowd), cell.pedestrian_mode],
            "scenarios": self.results.scenarios.count,
        }
        return hashlib.sha256(json.dumps(rules, sort_keys=True).encode()).hexdigest()[:RULES_DIGITS]

    @property
    def where(self) -> str:
        """World, population, number of scenarios and the hash of all rules, as Markdown."""
        street, cell = self.results.street, self.cell
        place, who = street.in_words() if street else "?", cell.pedestrians
        count = counted(self.results.scenarios.count, "scenario")
        strangers = f"{plain_markdown(place)}, {plain_markdown(who)}"
        return f"{strangers}, jaywalk multiplier {cell.jaywalk_multiplier:g}, {count}, rules {self.rules}"

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
            plain_markdown(self.entry, LONGEST_NAME),
            "yes" if self.checked else "no",
            *rates,
            delay,
            plain_markdown(driver.in_words()),
            self.results.scenarios.name,
        )


def _identity(origin: PolicyOrigin) -> tuple[str | None, ...]:
    """Return what a population is; equal ones may have files of different names."""
    return origin.kind, origin.sha256, None if origin.kind in OF_FILES else origin.name


def _moving(cell: Cell) -> Number:
    """Return the share of episodes in which the moving car touched somebody."""
    return cell.summary[MEASURED_CONTACTS].footprint.moving


def standings(name: str, results: Results, *, checked: bool) -> list[BoardLine]:
    """Return the standings of one entry, one for each of its cells."""
    return [BoardLine(name, checked, results, cell) for cell in results.cells]


def leaderboard(entries: Sequence[BoardLine]) -> dict[str, Table]:
    """Return a table for each set of rules, by what these are in words. The cells are Markdown."""
    tables: dict[str, list[BoardLine]] = {}
    for one in sorted(entries, key=lambda one: one.rank):
        tables.setdefault(one.rules, []).append(one)
    return {lines[0].where: Table(COLUMNS, tuple(one.row() for one in lines)) for lines in tables.values()}


def page(entries: Sequence[BoardLine], unusable: Mapping[str, str]) -> str:
    """Return the leaderboard as Markdown, at its end the ``unusable`` entries and why they are."""
    parts = [part for where, table in leaderboard(entries).items() for part in (f"## {where}", table.markdown())]
    if unusable:
        rows = [(plain_markdown(name, LONGEST_NAME), plain_markdown(why)) for name, why in unusable.items()]
        parts += ["## Not usable", markdown_table(("entry", "why"), rows)]
    return "\n\n".join(("# Leaderboard", CAPTION, *parts)) + "\n"
