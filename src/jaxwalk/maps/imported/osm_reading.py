"""Reading OpenStreetMap files, XML or PBF, with osmium; places become metres by a projection about the middle."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from jaxwalk.maps.imported.osm_tags import CLASSES, Tags, is_road
from jaxwalk.maps.imported.refusals import ImportRefusal, needed
from jaxwalk.maps.imported.region import AROUND, Region, refuse_large
from jaxwalk.maps.imported.xml_safety import refuse_declarations

MOST_BYTES = {".osm": 400_000_000, ".pbf": 100_000_000}
"""Largest file by the end of its name [bytes]: some ten million nodes, of which 16 bytes each are kept meanwhile."""
ATTRIBUTION = "© OpenStreetMap contributors, ODbL 1.0"
LICENCE = "https://www.openstreetmap.org/copyright"


class OsmWay(NamedTuple):
    """A way."""

    id: int
    nodes: tuple[int, ...]
    """Those whose places the file has, and none twice in a row."""
    tags: Tags


class OsmData(NamedTuple):
    """What is needed of a file."""

    places: dict[int, tuple[float, float]]
    """x and y of nodes [m]."""
    ways: tuple[OsmWay, ...]
    node_tags: dict[int, Tags]
    """Tags of all nodes of the file, outside the region too, that have one of the keys that are read."""
    missing: int
    """Number of references to nodes that the file doesn't have."""
    middle: tuple[float, float]
    """Latitude and longitude of (0, 0) [degrees]."""
    extent: tuple[float, float, float, float]
    """West, south, east and north end of the region, or of all roads [m]."""


def read_osm(path: Path, region: Region | None) -> OsmData:
    """Return what a file says of roads, paths, buildings and crossings, whole or around a region.

    Raises ImportRefusal if it can't be read, is too large, or has no roads.
    """
    osmium = needed("osmium", path, "osm")
    needed("pyproj", path, "osm")
    most = MOST_BYTES[path.suffix.lower()]
    if path.stat().st_size > most:
        raise ImportRefusal(f"{path}: larger than {most:,} bytes; cut a part out, as with 'osmium extract'")
    if path.suffix.lower() == ".osm":
        refuse_declarations(path)
    found = _Found()
    try:
        found.read(osmium, path, region)
    except (RuntimeError, ValueError, OSError, UnicodeError, osmium.InvalidLocationError) as error:
        reason = " ".join(str(error).split())[:200]
        raise ImportRefusal(f"{path}: can't be read as OpenStreetMap data ({reason}); download it again") from None
    if not any(is_road(way.tags) for way in found.ways):
        where = "" if region is None else " in this region"
        raise ImportRefusal(f"{path}: has no roads{where} (ways with highway={', '.join(list(CLASSES)[2:8:2])} ...); "
                            "name another file or part")  # fmt: skip
    return found.in_metres(path, region)


class _Found:
    """What has been read so far, in degrees."""

    def __init__(self) -> None:
        self.degrees: dict[int, tuple[float, float]] = {}
        """Longitude and latitude."""
        self.ways: list[OsmWay] = []
        self.node_tags: dict[int, Tags] = {}
        self.missing = 0

    def read(self, osmium: ModuleType, path: Path, region: Region | None) -> None:
        """Read the file once: nodes stand before ways."""
        around = None if region is None else region.widened(AROUND)
        keys = osmium.filter.KeyFilter("highway", "building", "railway", "crossing", "traffic_calming")
        kinds = osmium.osm.NODE | osmium.osm.WAY
        for element in osmium.FileProcessor(str(path), kinds).with_locations().with_filter(keys):
            tags = {tag.k: tag.v for tag in element.tags}
            if element.is_node():
                self.node_tags[element.id] = tags
            else:
                self._add_way(element, tags, around)

    def _add_way(self, element: Any, tags: Tags, around: Region | None) -> None:
        """Keep a way whose nodes are known, if it comes into the region."""
        known = [(node.ref, node.lon, node.lat) for node in element.nodes if node.location.valid()]
        missing = len(element.nodes) - len(known)
        if missing and is_road(tags) and not known:
            self.missing += missing
            return
        line = [(lon, lat) for _, lon, lat in known]
        if around is not None and not (len(line) > 1 and around.meets(line)):
            return
        self.missing += missing
        nodes = [known[n][0] for n in range(len(known)) if not n or known[n][0] != known[n - 1][0]]
        if len(nodes) > 1:
            self.degrees.update({ref: (lon, lat) for ref, lon, lat in known})
            self.ways.append(OsmWay(element.id, tuple(nodes), tags))

    def in_metres(self, path: Path, region: Region | None) -> OsmData:
        """Return what was read, by a transverse Mercator projection about its middle."""
        on_roads = {node for way in self.ways if is_road(way.tags) for node in way.nodes}
        roads = np.array([self.degrees[node] for node in on_roads]) if region is None else region.corners()
        lon, lat = (roads.min(axis=0) + roads.max(axis=0)) / 2
        project = flat_projection(path, lon, lat)
        numbers = np.array(list(self.degrees.values()))
        x, y = project(numbers[:, 0], numbers[:, 1])
        places = dict(
            zip(self.degrees, zip(np.round(x, 4).tolist(), np.round(y, 4).tolist(), strict=True), strict=True)
        )
        covered = np.stack(project(roads[:, 0], roads[:, 1]), axis=1)
        (west, south), (east, north) = covered.min(axis=0).tolist(), covered.max(axis=0).tolist()
        extent = (west, south, east, north)
        refuse_large(path, extent)
        return OsmData(places, tuple(self.ways), self.node_tags, self.missing, (float(lat), float(lon)), extent)


def flat_projection(path: Path, longitude: float, latitude: float) -> Callable[..., Any]:
    """Return what makes metres of longitudes and latitudes: a transverse Mercator projection about a place."""
    pyproj = needed("pyproj", path, "osm")
    flat = f"+proj=tmerc +lat_0={latitude:.7f} +lon_0={longitude:.7f} +ellps=WGS84 +units=m"
    return pyproj.Transformer.from_crs("EPSG:4326", flat, always_xy=True).transform


def lines_of(data: OsmData, *, kinds: tuple[str, ...], key: str = "highway") -> Iterator[tuple[OsmWay, np.ndarray]]:
    """Yield the ways of some kinds, with their lines (point, 2) [m]."""
    for way in data.ways:
        if way.tags.get(key) in kinds:
            yield way, line_of(data, way)


def line_of(data: OsmData, way: OsmWay) -> np.ndarray:
    """Return the line of a way (point, 2) [m]."""
    return np.array([data.places[node] for node in way.nodes])
