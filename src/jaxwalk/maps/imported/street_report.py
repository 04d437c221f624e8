"""What an import found, kept, repaired and left out: of each street, and of all together."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from jaxwalk.maps.imported.crossing_places import CrossingOutcome

Verdict = Literal["usable", "usable with inferred parts", "not usable"]


@dataclass(frozen=True)
class Repair:
    """Something that was added so that people reach each other."""

    what: str
    metres: float
    at: tuple[float, float]
    """Where it is in the street [m]."""


@dataclass(frozen=True)
class Kerbside:
    """A stretch of pavement along a kerb."""

    origin: str
    """``mapped``, ``inferred``, ``joined`` (a gap that was closed) or ``invented``."""
    metres: float
    line: list[list[float]]
    """Its middle, x and y of points in the street [m]."""
    kept: bool
    """Whether people walk there."""


@dataclass(frozen=True)
class CrossingFacts:
    """A crossing of a street."""

    name: str
    kind: str
    kind_from: str
    origin: str
    """``mapped`` or ``invented``."""
    at: tuple[float, float]
    """Its middle in the street [m]."""
    roadway: float
    """Metres of roadway on the way."""
    islands: int
    zone: bool
    """Whether people may jaywalk beside it."""


@dataclass(frozen=True)
class PavementNumbers:
    """Metres along the lines of people."""

    mapped: float = 0.0
    inferred: float = 0.0
    joined: float = 0.0
    """Gaps of up to 15 m between those, which were closed."""
    invented: float = 0.0
    parts_before: int = 0
    """Connected parts of what is mapped or inferred, joined by mapped crossings alone."""
    largest_before: float = 0.0
    """Share of its metres that the largest part has, from 0 to 1."""
    parts_after: int = 0
    """Connected parts with all repairs; people walk on the largest one."""
    kept: float = 0.0
    """Metres of what is mapped or inferred that belong to the part on which people walk."""

    @property
    def known(self) -> float:
        """Metres that are mapped or inferred."""
        return self.mapped + self.inferred

    @property
    def without(self) -> float:
        """The share of all kerbs for which the source has no sidewalk, from 0 to 1."""
        whole = self.known + self.joined + self.invented
        return self.invented / whole if whole else 0.0


@dataclass(frozen=True)
class StreetReport:
    """What became of one street."""

    name: str
    verdict: Verdict
    reasons: tuple[str, ...]
    """Why it isn't simply usable."""
    advice: tuple[str, ...]
    """What to add to the map."""
    place: tuple[float, float, float, float]
    """West, south, east and north end in the source map [m]."""
    pavement: PavementNumbers = field(default_factory=PavementNumbers)
    crossings: tuple[CrossingOutcome, ...] = ()
    """Those that the source has in the street's region."""
    counts: dict[str, int] = field(default_factory=dict)
    """Crossings, islands, zones, lanes, routes, buildings and parking strips of the street."""
    facts: tuple[CrossingFacts, ...] = ()
    """The crossings of the street."""
    kerbsides: tuple[Kerbside, ...] = ()
    no_pavement: tuple[str, ...] = ()
    """Crossings one of whose landings the source has no sidewalk at."""
    repairs: tuple[Repair, ...] = ()
    signals: tuple[str, ...] = ()
    """Crossings with traffic lights, which are played without lights."""
    left_out: tuple[str, ...] = ()

    @property
    def usable(self) -> bool:
        """Whether it can be played."""
        return self.verdict != "not usable"


@dataclass(frozen=True)
class ImportReport:
    """What became of a file."""

    source: str
    """The file's name."""
    format: str
    attribution: str
    strict: bool
    streets: tuple[StreetReport, ...]
    elements: tuple[dict[str, Any], ...]
    """The roads with the facts about them."""
    elsewhere: dict[str, int]
    """Mapped crossings of what isn't imported."""
    left_out: tuple[str, ...]
    nowhere: tuple[CrossingOutcome, ...] = ()
    """Mapped crossings that lie in no street."""
    notes: tuple[str, ...] = ()
    """What else a reader should know of the source."""

    def crossings(self) -> dict[str, CrossingOutcome]:
        """Return what became of each mapped crossing in the street where it fared best."""
        best = {outcome.name: outcome for outcome in self.nowhere}
        for street, outcome in ((x, outcome) for x in self.streets for outcome in x.crossings):
            known = best.get(outcome.name)
            good = outcome.placed and street.usable
            own = outcome if good or not outcome.placed else _unusable(outcome, street)
            if known is None or (good and not known.placed) or (known.at_edge and not own.at_edge):
                best[outcome.name] = own
        return best


def _unusable(outcome: CrossingOutcome, street: StreetReport) -> CrossingOutcome:
    why = street.reasons[0] if street.reasons else "the street isn't usable"
    return CrossingOutcome(outcome.name, outcome.kind, False, f"its street isn't usable: {why}", point=outcome.point)
