"""The leaderboard: entries side by side, a table for those that played by the same rules, the safest checked first."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from jaxwalk.evaluation import Cell, Results
from jaxwalk.evaluation.document_parts import Number, PolicyOrigin, StreetOrigin
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.report.table import MOVING, Table, markdown_table, shown
from jaxwalk.wording import counted, plain_markdown

COLUMNS = ("entry", "checked", "goal %", "collision %", MOVING, "delay [s]", "driver", "scenarios")
CAPTION = (
    "Brackets: 95 % intervals over scenarios, of one training each: they say nothing about training again. Checked "
    "entries came out again when somebody checked them, and show what they did on fresh scenarios; the others show "
    "what their authors say. {seed} The order is by contacts of the moving car, then by delay; whose intervals overlap "
    "can't be told apart by it."
)
FROM_FILES = (
    "The seed of fresh scenarios follows from the files of the entry. It isn't secret: an author can change a file "
    "until the seed suits."
)
FROM_SALT = (
    "The seed of fresh scenarios follows from the files of the entry and from a text of whoever checked them (--salt)."
)
RULES_DIGITS = 8
"""Number of hexadecimal digits of a hash of rules."""
LONGEST_NAME = 60
"""Longest name of an entry that is shown [characters]."""
OF_FILES = ("run folder", "policy file", "file")
"""Kinds of policies that their hash identifies, whatever they are called in an entry."""


ADVICE = "evaluate it again, with --out"


class StandingsError(ValueError):
    """Results can't stand in a leaderboard. The message names the entry and says what to do, in one line."""


@dataclass(frozen=True)
class BoardLine:
    """An entry's cell: one driver among one population in one world. `standings` makes them."""

    entry: str
    checked: bool
    results: Results
    street: StreetOrigin
    """The street of the results."""
    crowd: PolicyOrigin
    """The population of the cell."""
    cell: Cell
    contacts: float
    """Share of the scenarios in which the moving car touches somebody."""

    @property
    def rules(self) -> str:
        """The hash of all that decides results besides the driver and the seed: equal rules, equal hashes."""
        cell = self.cell
        rules = {
            "maps": [text.hash for text in self.street.maps],
            "sim": {**asdict(self.street.sim), "jaywalk_multiplier": cell.jaywalk_multiplier},
            "people": [_identity(self.crowd), cell.pedestrian_mode],
            "scenarios": self.results.scenarios.count,
        }
        return hashlib.sha256(json.dumps(rules, sort_keys=True).encode()).hexdigest()[:RULES_DIGITS]

    @property
    def where(self) -> str:
        """World, population, number of scenarios and the hash of all rules, as Markdown."""
        count = counted(self.results.scenarios.count, "scenario")
        strangers = f"{plain_markdown(self.street.in_words())}, {plain_markdown(self.crowd.name)}"
        return f"{strangers}, jaywalk multiplier {self.cell.jaywalk_multiplier:g}, {count}, rules {self.rules}"

    @property
    def rank(self) -> tuple[bool, float, float]:
        """What entries are ordered by."""
        delay = self.cell.mean_delay.value
        return not self.checked, self.contacts, float("inf") if delay is None else delay  # None: it never arrives

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
    """Return the standings of one entry, one for each of its cells.

    Args:
        name: the entry's.
        results: of one driver in one world, among one population or several.
        checked: whether somebody else than its author found them.

    Raises:
        StandingsError: the results have no cell or don't say how they were made, or a cell is of another driver or
            population than the results, or has no episodes.
    """
    if results.street is None or not results.cells:
        lacks = "cells" if results.street else "rules"
        raise StandingsError(f"{name}: its results have no {lacks}; {ADVICE}")
    crowds = {origin.name: origin for origin in results.populations}
    drivers = [origin.name for origin in results.drivers]
    lines = []
    for cell in results.cells:
        contacts = _moving(cell).value
        if [cell.driver] != drivers or cell.pedestrians not in crowds:
            raise StandingsError(f"{name}: a cell of its results is not of their driver and populations; {ADVICE}")
        if contacts is None:
            raise StandingsError(f"{name}: its results don't say how often the moving car touched somebody; {ADVICE}")
        lines.append(BoardLine(name, checked, results, results.street, crowds[cell.pedestrians], cell, contacts))
    return lines


def leaderboard(entries: Sequence[BoardLine]) -> dict[str, Table]:
    """Return a table for each set of rules, by what these are in words. The cells are Markdown."""
    tables: dict[str, list[BoardLine]] = {}
    for one in sorted(entries, key=lambda one: one.rank):
        tables.setdefault(one.rules, []).append(one)
    return {lines[0].where: Table(COLUMNS, tuple(one.row() for one in lines)) for lines in tables.values()}


def page(entries: Sequence[BoardLine], unusable: Mapping[str, str], *, salted: bool) -> str:
    """Return the leaderboard as Markdown.

    Args:
        entries: the lines of all tables.
        unusable: the entries that can't be shown, and why.
        salted: whether the seeds of the checks follow from a salt too.
    """
    parts = [part for where, table in leaderboard(entries).items() for part in (f"## {where}", table.markdown())]
    if unusable:
        rows = [(plain_markdown(name, LONGEST_NAME), plain_markdown(why)) for name, why in unusable.items()]
        parts += ["## Not usable", markdown_table(("entry", "why"), rows)]
    caption = CAPTION.format(seed=FROM_SALT if salted else FROM_FILES)
    return "\n\n".join(("# Leaderboard", caption, *parts)) + "\n"
