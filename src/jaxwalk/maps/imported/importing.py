"""Importing a file: its format is told by its name, and each format needs only its own packages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from jaxwalk.maps.imported.crossing_places import CrossingOutcome
from jaxwalk.maps.imported.lanelet_reading import is_lanelet_map
from jaxwalk.maps.imported.lanelet_source import lanelet_map
from jaxwalk.maps.imported.opendrive_source import opendrive_map
from jaxwalk.maps.imported.osm_source import osm_map
from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.region import Region
from jaxwalk.maps.imported.source_map import SourceMap
from jaxwalk.maps.imported.street_maker import ImportedStreet
from jaxwalk.maps.imported.street_report import ImportReport
from jaxwalk.maps.imported.sumo_source import sumo_map
from jaxwalk.maps.imported.tiles import inside, single_street, tiles

OSM = (".osm", ".pbf")
"""How the names of OpenStreetMap files end."""
LANELET2 = (".osm",)
"""How the names of Lanelet2 maps end: like those of OpenStreetMap files, which have no lanelets."""
SUMO = (".net.xml", ".net.xml.gz")
"""How the names of SUMO networks end."""
OPENDRIVE = (".xodr",)
"""How the names of OpenDRIVE files end."""
KNOWN = (
    "OpenStreetMap (.osm, .osm.pbf), Lanelet2 maps (.osm), SUMO networks (.net.xml, .net.xml.gz) and OpenDRIVE (.xodr)"
)
CUT_OFF = "where its road is cut off at the edge"
"""Why a crossing lies in no street."""


def read_source(path: Path, region: Region | None = None, *, left: bool = False) -> SourceMap:
    """Return what a file has, whole or in a region; ``left``: traffic keeps left.

    Raises ImportRefusal if it can't be used.
    """
    if not path.is_file():
        raise ImportRefusal(f"{path}: no such file; check the name")
    if path.name.lower().endswith(LANELET2) and is_lanelet_map(path):
        return lanelet_map(path, region, left=left)
    if path.name.lower().endswith(OSM):
        return osm_map(path, region, left=left)
    if path.name.lower().endswith(SUMO):
        return sumo_map(path, region, left=left)
    if path.name.lower().endswith(OPENDRIVE):
        return opendrive_map(path, region, left=left)
    raise ImportRefusal(f"{path}: not a format that is known by its name; known are {KNOWN}")


def import_street(source: SourceMap, name: str, *, strict: bool = False) -> ImportedStreet:
    """Return a whole source map as one street; ``strict``: no sidewalk and no crossing is invented.

    Raises ImportRefusal if it is too large for one street.
    """
    return single_street(source, name, strict=strict)


def import_tiles(
    source: SourceMap, size: float = 200.0, *, strict: bool = False, told: Callable[[int, int], None] = lambda *_: None
) -> list[ImportedStreet]:
    """Return the streets of all tiles that have a mapped crossing.

    Args:
        source: the map.
        size: side of a tile [m].
        strict: whether no sidewalk and no crossing may be invented.
        told: is called with the number of tiles made so far, and of all.

    Raises ImportRefusal if no crossing is mapped.
    """
    found = list(tiles(source, "tile", size, strict=strict, told=told))
    if not found:
        raise ImportRefusal(
            f"no crossing is mapped on {len(source.elements)} roads; name another part, or map crossings"
        )
    return found


def report_of(source: SourceMap, streets: Sequence[ImportedStreet], file: str, *, strict: bool) -> ImportReport:
    """Return the report on some streets of a source map, which were made of a file; ``file`` is its name."""
    reports = tuple(street.report for street in streets)
    named = {outcome.name for report in reports for outcome in report.crossings}
    nowhere = tuple(
        CrossingOutcome(x.name, x.kind, False, CUT_OFF, point=(float(x.point[0]), float(x.point[1])))
        for x in source.crossings if x.name not in named and inside(x.point, source.extent)
    )  # fmt: skip
    return ImportReport(
        file, source.format, source.attribution, strict, reports, source.elements, source.elsewhere, source.left_out,
        nowhere, source.notes,
    )  # fmt: skip
