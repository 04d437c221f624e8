"""Options of the commands about streets: generated ones, and maps of your own."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from jaxwalk.cli.options.declare import option
from jaxwalk.maps.generated import SPLITS

if TYPE_CHECKING:
    SplitName = str
else:
    SplitName = Literal[tuple(SPLITS)]
"""The name of a split."""


@dataclass(frozen=True)
class Streets:
    """Draw, list and check generated streets: each is made from a number. See docs/streets.md.

    For example: jaxwalk streets --split test --count 12 --out streets
    """

    split: Annotated[SplitName, option("training")] = "training"
    """Which numbers: training, validation and test never meet; unseen-ranges are streets whose parameters lie outside
    those of all three, arterial wide and fast ones, parked-training and parked-test narrow ones."""
    first: Annotated[int, option("0", "N")] = 0
    """Begin at this place among the split's numbers, from 0."""
    count: Annotated[int, option("12", "N")] = 12
    """Number of streets. Numbers that give none are left out, and counted."""
    out: Annotated[Path | None, option("none: only list them", "DIR")] = None
    """Folder for a picture of each street, NUMBER.png, and streets.png with all of them; older ones are replaced."""
    check: Annotated[int | None, option("none", "N")] = None
    """Instead, make this many numbers: how many give a street, why the others don't, and the time of each."""


@dataclass(frozen=True)
class MapNew:
    """Write a map to begin with: a straight street with crosswalks, or a copy of a map that is there.

    For example: jaxwalk map new my-street.toml --length 150 --crosswalks 40 110
    """

    file: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FILE")] = field()
    """FILE.toml, which must not exist; .json for a copy of a generated street."""
    length: Annotated[float | None, option("100", "M")] = None
    """Length of the street [m]."""
    width: Annotated[float | None, option("8", "M")] = None
    """Width of its roadway, two lanes together [m]."""
    crosswalks: Annotated[tuple[float, ...], option("one in the middle", "M [M ...]")] = ()
    """How far the middle of each crosswalk is from the western end of the street [m]."""
    like: Annotated[str | None, option("none", "MAP")] = None
    """Instead, a copy of this map: a bundled one such as paper, or a generated street such as test-2000000003."""


@dataclass(frozen=True)
class MapCheck:
    """Check maps: say what is wrong in each line of its own, or what a map without faults is like.

    For example: jaxwalk map check my-street.toml
    """

    map: Annotated[tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="MAP [MAP ...]")] = ()
    """Map files, bundled maps or generated streets (docs/maps.md)."""


@dataclass(frozen=True)
class MapDraw:
    """Draw a map from above: lanes, walkways, crossings, jaywalk zones and what else it has.

    For example: jaxwalk map draw my-street.toml --out my-street.png
    """

    map: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="MAP")] = field()
    """A map file, a bundled map or a generated street (docs/maps.md)."""
    out: Annotated[Path | None, option("MAP.png", "FILE")] = None
    """FILE.png, .svg or .pdf; an existing one is replaced."""
