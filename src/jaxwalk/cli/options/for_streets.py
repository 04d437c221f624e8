"""Options of the commands about streets: imported ones, generated ones, and maps of your own."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from jaxwalk.cli.options.declare import Flag, option
from jaxwalk.maps.generated import SPLITS

if TYPE_CHECKING:
    SplitName = str
else:
    SplitName = Literal[tuple(SPLITS)]
"""The name of a split."""


@dataclass(frozen=True)
class Import:
    """Make streets of a map of the real world, with a report of what was mapped, inferred, invented and left out.

    OpenStreetMap (.osm, .osm.pbf; needs pip install "jaxwalk[osm]"), Lanelet2 maps (.osm; the same, unless they have
    metres), SUMO networks (.net.xml, .net.xml.gz; needs pip install "jaxwalk[sumo]") and OpenDRIVE (.xodr; needs pip
    install "jaxwalk[opendrive]") (docs: real-streets). For example:
    jaxwalk import town.osm.pbf --centre 60.1699 24.9384 --radius 300 --out town
    """

    file: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FILE")]
    """The map."""
    out: Annotated[Path, option("streets", "OUT")] = Path("streets")
    """NAME.json: all of it as one street of at most 400 m. A folder: tiles that overlap, TILE-001.json and so on, for
    --map of other commands. Reports beside them: NAME.report.html and .json, or report.html and .json. Older ones are
    replaced; a folder must be new, or one of an earlier import."""
    centre: Annotated[tuple[float, float] | None, option("all of the map", "LATITUDE LONGITUDE")] = None
    """Only the square about this place; degrees."""
    radius: Annotated[float, option("150", "METRES")] = 150.0
    """How far the square reaches to each side."""
    bbox: Annotated[tuple[float, float, float, float] | None, option("all of the map", "W S E N")] = None
    """Only this box: west, south, east, north; degrees."""
    tile: Annotated[float, option("200", "METRES")] = 200.0
    """Side of a tile, 150 to 300."""
    traffic: Annotated[Literal["right", "left"], option("right", "SIDE")] = "right"
    """The side to which traffic keeps. A map that says otherwise is refused; SUMO networks and Lanelet2 maps
    say it themselves."""
    strict: Flag = False
    """Invent no sidewalk and no crossing: only what is mapped, or follows from tags."""


@dataclass(frozen=True)
class Streets:
    """Draw, list and check streets: generated ones, each made from a number, or maps (docs: streets).

    For example: jaxwalk streets --split test --count 12 --out streets
    """

    split: Annotated[SplitName, option("training")] = "training"
    """Which numbers: training, validation and test never meet; unseen-ranges are streets whose parameters lie outside
    those of all three, arterial wide and fast ones, parked-training and parked-test narrow ones."""
    first: Annotated[int, option("0", "N")] = 0
    """Begin at this place among the split's numbers, from 0."""
    count: Annotated[int, option("12", "N")] = 12
    """Number of streets. Numbers that give none are left out, and counted."""
    map: Annotated[tuple[str, ...], option("none: generated streets", "MAP [MAP ...]")] = ()
    """Instead of generated streets: maps by name, map files, or folders of `jaxwalk import`."""
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
    """Map files, bundled maps or generated streets (docs: maps)."""


@dataclass(frozen=True)
class MapDraw:
    """Draw a map from above: lanes, walkways, crossings, jaywalk zones and what else it has.

    For example: jaxwalk map draw my-street.toml --out my-street.png
    """

    map: Annotated[str, tyro.conf.Positional, tyro.conf.arg(metavar="MAP")] = field()
    """A map file, a bundled map or a generated street (docs: maps)."""
    out: Annotated[Path | None, option("MAP.png", "FILE")] = None
    """FILE.png, .svg or .pdf; an existing one is replaced."""
