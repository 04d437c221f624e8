"""What raters are shown: pairs of clips of the same scenario under two drivers, and checks that they attend."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar, Literal

from jaxwalk.evaluation.document_parts import ScenarioSet
from jaxwalk.evaluation.reading import Origin, as_document
from jaxwalk.provenance import Provenance

SCHEMA = 1
"""Version of the plan and of the files of answers."""
QUESTION = "Which car drove more safely?"
LENGTH = 8.0
"""Length of a clip [s]."""
REPEATED = 3
"""Pairs that a rater sees once more, with the sides swapped."""
Side = Literal["a", "b"]


class RatingError(ValueError):
    """Raised if a page can't be made of these drivers, or a folder has no plan; the message says what to do."""


@dataclass(frozen=True)
class RatedPair:
    """Two clips of one scenario."""

    scenario: int
    a: int
    """Place of the first clip's driver among the plan's players."""
    b: int
    start: float
    """When both clips begin, from the scenario's start [s]."""
    safer: Side | None = None
    """The clip of a check in which nobody is hit; None for a pair that is rated."""


@dataclass(frozen=True)
class DriverMeasure:
    """A number of ours for every driver, which raters' opinions are compared with."""

    name: str
    high: bool
    """Whether a higher number should mean a safer driver."""
    values: tuple[float | None, ...]
    """In the order of the drivers."""


@dataclass(frozen=True)
class RatingPlan:
    """What raters are shown, and by which drivers it is; the page itself doesn't name them."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    drivers: tuple[str, ...]
    """The drivers that are rated."""
    players: tuple[str, ...]
    """These, and perhaps one more that only checks show."""
    pedestrians: str
    scenarios: ScenarioSet
    seed: int
    """Seed of the choice of pairs."""
    each: int
    """Pairs that each rater sees, besides the repeated ones and the checks."""
    pairs: tuple[RatedPair, ...]
    measures: tuple[DriverMeasure, ...]
    made: Provenance
    question: str = QUESTION
    schema: int = SCHEMA

    def __post_init__(self) -> None:
        """Raise ValueError unless everything belongs together."""
        if self.schema != SCHEMA:
            raise ValueError(f"is of another version: its schema is {self.schema}, not {SCHEMA}")
        if not 2 <= len(self.drivers) <= len(self.players):
            raise ValueError(f"has {len(self.drivers)} drivers and {len(self.players)} players")
        for pair in self.pairs:
            most = len(self.players if pair.safer else self.drivers)
            if not (0 <= pair.a < most and 0 <= pair.b < most and pair.a != pair.b):
                raise ValueError(f"has a pair of the drivers {pair.a} and {pair.b} of {most}")
        for measure in self.measures:
            if len(measure.values) != len(self.drivers):
                raise ValueError(f"has {len(measure.values)} values of {measure.name} for {len(self.drivers)} drivers")

    @property
    def id(self) -> str:
        """The first 16 digits of the SHA-256 of everything but ``made``; the files of answers name it."""
        content = {name: value for name, value in asdict(self).items() if name != "made"}
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]

    @property
    def rated(self) -> list[int]:
        """The places of the pairs that are no checks."""
        return [place for place, pair in enumerate(self.pairs) if pair.safer is None]

    def as_dict(self) -> dict[str, Any]:
        """Return the plan as its file has it, with its id."""
        return {"id": self.id, **asdict(self)}


def read_plan(path: Path) -> RatingPlan:
    """Read a plan.

    Raises:
        RatingError: there is none, it is no JSON, or it was changed.
        DocumentError: it is damaged.
    """
    if not path.is_file():
        raise RatingError(f"{path}: no such file; {ADVICE}")
    try:
        content = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise RatingError(f"{path}: is no JSON document ({error}); {ADVICE}") from error
    own = content.pop("id", None) if isinstance(content, dict) else None
    plan = as_document(RatingPlan, content, Origin(path, ADVICE))
    if plan.id != own:
        raise RatingError(f"{path}: was changed, since its id is not the hash of its content; {ADVICE}")
    return plan


ADVICE = "name the folder of `jaxwalk rate` that the page is from, with --out"
