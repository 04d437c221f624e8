"""The map file: what may stand in it, and how it is read. Described for authors in ``docs/maps.md``."""

from __future__ import annotations

import tomllib
from textwrap import shorten
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
"""A finite number; text and booleans are refused instead of converted."""
Index = Annotated[int, Field(strict=True)]
Name = Annotated[str, Field(strict=True, min_length=1)]
Point = tuple[Number, Number]
"""x, y [m]."""
Rectangle = tuple[Number, Number, Number, Number]
"""x0, y0, x1, y1 [m]."""

SHOWN = 200
"""Characters that a message shows of a wrong value."""
_EXACT = ConfigDict(extra="forbid")


class MapError(ValueError):
    """A map that cannot be used: its message names the file and, one per line, every fault with what to do."""

    def __init__(self, source: str, faults: list[str]) -> None:
        """Compose the message of the ``faults`` found in ``source``, the map's name or path."""
        self.source = source
        self.faults = list(faults)
        head = f"map {source} has {len(faults)} fault" + ("s" if len(faults) != 1 else "")
        super().__init__("\n".join([head + ":", *(f"  - {fault}" for fault in faults)]))


@dataclass(frozen=True, config=_EXACT)
class Side:
    """One end of a crosswalk."""

    landing: Name
    """The waypoint where people step on the crosswalk."""
    outer: Name
    """The waypoint next to the landing along the kerb, away from the junction."""
    zone: Point
    """The jaywalk zone: from and to, in metres from the crosswalk's edge toward ``outer``."""


@dataclass(frozen=True, config=_EXACT)
class Crosswalk:
    """A crossing from kerb to kerb."""

    area: Rectangle
    sides: tuple[Side, Side]


@dataclass(frozen=True, config=_EXACT)
class Car:
    """Where the car may start or be sent, and how it turns."""

    places: list[Point]
    """Points on the centre lines of roads."""
    right_turn_radius: Number
    """[m]"""
    left_turn_radius: Number
    """[m]"""
    routes: Literal["all"] | list[tuple[Index, Index]] = "all"
    """Pairs (start, goal) of positions in ``places``, counted from 0; ``all`` is every ordered pair."""

    def pairs(self) -> list[tuple[int, int]]:
        """The routes as (start, goal) pairs."""
        if self.routes != "all":
            return list(self.routes)
        count = range(len(self.places))
        return [(start, goal) for start in count for goal in count if start != goal]


@dataclass(frozen=True, config=_EXACT)
class MapFile:
    """A map as it is written down."""

    size: Point
    """Width (to the east) and height (to the north) [m]."""
    car: Car
    roads: dict[Name, Rectangle]
    sidewalks: dict[Name, Rectangle]
    waypoints: dict[Name, Point]
    walkways: dict[Name, list[Name]]
    """Waypoints joined one after the other."""
    crosswalks: dict[Name, Crosswalk]


_ADAPTER = TypeAdapter(MapFile)


def parse(text: str, source: str) -> MapFile:
    """The map file in ``text``. MapError if it isn't TOML, or a key is unknown, missing or of the wrong type."""
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        last = f"at line {len(text.splitlines())}, the end of the file"
        reason = str(error).replace("at end of document", last)
        raise MapError(source, [f"not valid TOML: {reason}; correct the file there"]) from None
    except (ValueError, RecursionError) as error:  # a number of thousands of digits, thousands of brackets
        raise MapError(source, [f"not TOML that can be read ({error}); correct the file"]) from None
    try:
        return _ADAPTER.validate_python(table)
    except ValidationError as error:
        raise MapError(source, [_explain(dict(fault)) for fault in error.errors()]) from None


def _explain(fault: dict[str, Any]) -> str:
    """One pydantic fault as a line: which field, what is wrong, what to write instead."""
    field = ".".join(str(part) for part in fault["loc"] if not _is_branch_of_union(part))
    if fault["type"] == "unexpected_keyword_argument":
        return f"{field}: unknown key; remove it or correct its spelling (docs/maps.md lists all keys)"
    if fault["type"] == "missing":
        return f"{field}: missing; add it (docs/maps.md lists all keys)"
    return f"{field}: {fault['msg'].replace('Input s', 's')}, not {shorten(repr(fault['input']), SHOWN)}"


def _is_branch_of_union(part: str | int) -> bool:
    """Whether pydantic put the alternative it tried, such as ``list[...]``, into the field's path."""
    return isinstance(part, str) and ("[" in part or "literal" in part)
