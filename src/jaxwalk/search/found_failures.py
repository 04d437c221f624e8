"""The document of a search: what was searched, and every failure that it kept. And the same as a table."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import asdict, dataclass, fields

from jaxwalk.evaluation.document_parts import PolicyOrigin, StreetOrigin
from jaxwalk.provenance import Provenance
from jaxwalk.search.grid import GRID, GridCell, in_words
from jaxwalk.search.hunt import Progressed

SEARCH_SCHEMA = 1
"""Version of the document."""
PLAUSIBLE = 1.0
"""A failure above this percentile is plausible [%]."""
AVOIDERS = ("human", "oracle")
"""Judgements of failures that somebody in the car's place would have avoided."""
TABLE_NAMES = {
    "speed": "speed_km_h", "time": "first_visible_s_before", "bearing": "bearing_deg", "words": "cell_in_words",
}  # fmt: skip
"""Columns of the table whose names aren't the document's: units are in them."""


@dataclass(frozen=True)
class FoundFailure:
    """One failure: the most plausible one of its cell."""

    scenario: int
    """Its number in the file of scenarios, from 0."""
    cell: int
    """Number of its cell in the grid; `words` says what it is."""
    contact: str
    """What the person was doing: crosswalk, jaywalk or sidewalk."""
    speed: float
    """The car's speed at the contact [km/h]."""
    time: float | None
    """Time to collision when the person was first visible [s]; None for a car that stood then."""
    bearing: float
    """Where the person is at the contact, from the car's centre, positive to the left [degrees]."""
    map: str
    ped: int
    """The person."""
    percentile: float
    """How ordinary the scenario is: the share of ordinary ones that are at least as unusual [%]."""
    judged: str
    """Who would have avoided it from when the person was first seen: ``human``, ``oracle`` (only one who knows the
    future, or brakes fully at once), or ``unavoidable``."""
    judged_from_start: str
    """The same with others at the wheel from the start."""
    people: int | None = None
    """How few people still fail; None if it was not minimised."""
    changed: int | None = None
    """How many draws of those people, choices among equals apart, can't be ordinary ones."""
    minimal_percentile: float | None = None
    """How ordinary the minimal scenario is, by the draws of those people [%]."""

    @property
    def words(self) -> GridCell:
        """Return its cell in words."""
        return in_words(self.cell)

    @property
    def avoidable(self) -> bool:
        """Return whether a careful human or the oracle would have avoided it."""
        return self.judged in AVOIDERS or self.judged_from_start in AVOIDERS

    @property
    def plausible(self) -> bool:
        """Return whether it is above the first percentile of ordinary scenarios."""
        return self.percentile > PLAUSIBLE


@dataclass(frozen=True)
class SearchResults:
    """Everything that a search found."""

    driver: PolicyOrigin
    pedestrians: PolicyOrigin
    method: str
    seed: int
    log: tuple[Progressed, ...]
    """What had been found after each generation."""
    failures: tuple[FoundFailure, ...]
    """One for each cell, the worst first."""
    hash: str | None
    """Hash of the scenarios; None if nothing failed."""
    street: StreetOrigin
    made: Provenance

    @property
    def simulations(self) -> int:
        """Return how many scenarios were played."""
        return self.log[-1].simulations if self.log else 0

    @property
    def good(self) -> int:
        """Return how many failures are plausible and avoidable."""
        return sum(one.plausible and one.avoidable for one in self.failures)

    def to_json(self) -> str:
        """Return the document as text; the same results give the same text."""
        parts = {field.name: getattr(self, field.name) for field in fields(self)}
        document = {"schema": SEARCH_SCHEMA, "grid": GRID, **{name: _plain(part) for name, part in parts.items()}}
        return json.dumps(document, indent=2, allow_nan=False) + "\n"

    def to_csv(self) -> str:
        """Return a table with a row for each failure: units in the columns' names, the cell also in words.

        What doesn't exist is empty.
        """
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        columns = [field.name for field in fields(FoundFailure)]
        columns.insert(columns.index("cell") + 1, "words")
        writer.writerow(TABLE_NAMES.get(name, name) for name in columns)
        writer.writerows([_cell(getattr(one, name)) for name in columns] for one in self.failures)
        return text.getvalue()


def _plain(part: object) -> object:
    """Return dataclasses as dicts."""
    if isinstance(part, tuple):
        return [_plain(one) for one in part]
    if isinstance(part, StreetOrigin):
        return part.as_dict()
    return asdict(part) if isinstance(part, (FoundFailure, PolicyOrigin, Progressed, Provenance)) else part


def _cell(value: object) -> object:
    return "" if value is None else f"{value:.3f}" if isinstance(value, float) else value
