"""The map file: its fields, and its parser. ``docs/maps.md`` describes it for authors of maps."""

from __future__ import annotations

import tomllib
from textwrap import shorten
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
"""A finite number. Text and booleans are errors; they are not converted."""
Index = Annotated[int, Field(strict=True)]
Name = Annotated[str, Field(strict=True, min_length=1)]
Point = tuple[Number, Number]
"""x, y [m]."""
Rectangle = tuple[Number, Number, Number, Number]
"""x0, y0, x1, y1 [m]."""

SHOWN = 200
"""Longest quotation of a wrong value in a message [characters]."""
_EXACT = ConfigDict(extra="forbid")


class MapError(ValueError):
    """A map can't be used. The message names the file and lists every fault in a line, with what to do."""

    def __init__(self, source: str, faults: list[str]) -> None:
        """Make the message from the ``faults`` of ``source``, the map's name or path."""
        self.source = source
        self.faults = list(faults)
        head = f"map {source} has {len(faults)} fault" + ("s" if len(faults) != 1 else "")
        super().__init__("\n".join([head + ":", *(f"  - {fault}" for fault in faults)]))


@dataclass(frozen=True, config=_EXACT)
class Side:
    """One end of a crosswalk."""

    landing: Name
    """The waypoint where people step onto the crosswalk."""
    outer: Name
    """The waypoint next to the landing along the kerb, away from the junction."""
    zone: Point
    """The jaywalk zone: nearest and farthest distance from the crosswalk's edge toward ``outer`` [m]."""


@dataclass(frozen=True, config=_EXACT)
class Crosswalk:
    """A crossing from kerb to kerb."""

    area: Rectangle
    sides: tuple[Side, Side]


@dataclass(frozen=True, config=_EXACT)
class Car:
    """Where the car may start and where its goals are, and how it turns."""

    places: list[Point]
    """Points on the centre lines of roads."""
    right_turn_radius: Number
    """Radius of right turns [m]."""
    left_turn_radius: Number
    """Radius of left turns [m]."""
    routes: Literal["all"] | list[tuple[Index, Index]] = "all"
    """Pairs (start, goal) of positions in ``places``, counted from 0; ``all`` is every ordered pair."""

    def pairs(self) -> list[tuple[int, int]]:
        """Return the routes as (start, goal) pairs."""
        if self.routes != "all":
            return list(self.routes)
        count = range(len(self.places))
        return [(start, goal) for start in count for goal in count if start != goal]


@dataclass(frozen=True, config=_EXACT)
class MapFile:
    """The content of a map file."""

    size: Point
    """Width (to the east) and height (to the north) [m]."""
    car: Car
    roads: dict[Name, Rectangle]
    sidewalks: dict[Name, Rectangle]
    waypoints: dict[Name, Point]
    walkways: dict[Name, list[Name]]
    """Chains of waypoints, each joined to the next one."""
    crosswalks: dict[Name, Crosswalk]


_ADAPTER = TypeAdapter(MapFile)


def parse(text: str, source: str) -> MapFile:
    """Parse a map file's text. Raises MapError if it isn't TOML, or a key is unknown, missing or of the wrong type."""
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        last = f"at line {len(text.splitlines())}, the end of the file"
        reason = str(error).replace("at end of document", last)
        raise MapError(source, [f"not valid TOML: {reason}; correct the file there"]) from None
    except (ValueError, RecursionError) as error:  # for example a number with thousands of digits
        raise MapError(source, [f"not TOML that can be read ({error}); correct the file"]) from None
    try:
        return _ADAPTER.validate_python(table)
    except ValidationError as error:
        raise MapError(source, [explain(dict(fault)) for fault in error.errors()]) from None


def explain(fault: dict[str, Any]) -> str:
    """Return one pydantic fault as a line: the field, what is wrong, what to write instead."""
    field = ".".join(str(part) for part in fault["loc"] if not _is_branch_of_union(part))
    if fault["type"] == "unexpected_keyword_argument":
        return f"{field}: unknown key; remove it or correct its spelling (docs: maps)"
    if fault["type"] == "missing":
        return f"{field}: missing; add it (docs: maps)"
    wrong = fault["msg"].replace("Input s", "s").removeprefix("Value error, ")
    return f"{field}: {wrong}, not {shorten(repr(fault['input']), SHOWN)}"


def _is_branch_of_union(part: str | int) -> bool:
    """Return whether a part of the field's path is an alternative that pydantic tried, such as ``list[...]``."""
    return isinstance(part, str) and ("[" in part or "literal" in part)
