"""Reading Lanelet2 maps (.osm): lines with their tags, and the relations that make lanelets and areas of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple
from xml.parsers import expat

import numpy as np

from jaxwalk.maps.imported.osm_reading import flat_projection
from jaxwalk.maps.imported.osm_tags import Tags
from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.region import Region
from jaxwalk.maps.imported.source_map import Box
from jaxwalk.maps.imported.xml_safety import CHUNK, refuse_declarations

MOST_BYTES = 100_000_000
"""Largest map [bytes]."""
LANELET = re.compile(rb"""<tag\s+(?:k=["']type["']\s+v=["']lanelet["']|v=["']lanelet["']\s+k=["']type["'])""")
"""What no OpenStreetMap file has, and each Lanelet2 map."""
LONGEST_TAG = 200
"""The text of such a tag is shorter [bytes]."""
LOCAL = ("local_x", "local_y")
"""Tags of nodes that have metres of the map's own."""
MOST_DEGREES = (180.0, 85.0)
"""Largest longitude and latitude [degrees]."""


class LaneletMember(NamedTuple):
    """Something that a relation names."""

    kind: str
    """``node``, ``way`` or ``relation``."""
    ref: int
    role: str


class LaneletRelation(NamedTuple):
    """A lanelet, an area, or a rule for lanelets."""

    members: tuple[LaneletMember, ...]
    tags: Tags

    def refs(self, kind: str, *roles: str) -> list[int]:
        """Return the numbers of members of a kind that have one of some roles, or all of the kind."""
        return [x.ref for x in self.members if x.kind == kind and (not roles or x.role in roles)]


class LaneletLine(NamedTuple):
    """A line of the map, such as the edge of a lane or a kerb."""

    points: np.ndarray
    """(point, 2) [m], none twice in a row."""
    tags: Tags


class LaneletFile(NamedTuple):
    """What is needed of a file."""

    lines: dict[int, LaneletLine]
    relations: dict[int, LaneletRelation]
    missing: int
    """Number of nodes of ways that the file doesn't have, or not their places."""
    region: Box | None
    """What was asked for [m]."""


def is_lanelet_map(path: Path) -> bool:
    """Return whether a file has lanelets. It is read piece by piece, as bytes."""
    with path.open("rb") as file:
        chunks = iter(lambda: file.read(CHUNK), b"")
        return any(LANELET.search(piece) for piece in _overlapping(chunks))


def _overlapping(chunks: Iterable[bytes]) -> Iterator[bytes]:
    """Yield pieces of a file, each with the end of the one before: a tag may lie across."""
    before = b""
    for chunk in chunks:
        yield before + chunk
        before = chunk[-LONGEST_TAG:]


def read_lanelets(path: Path, region: Region | None) -> LaneletFile:
    """Return what a Lanelet2 map has. Raise ImportRefusal if it can't be read or is too large."""
    if path.stat().st_size > MOST_BYTES:
        raise ImportRefusal(f"{path}: larger than {MOST_BYTES:,} bytes; cut a part out")
    refuse_declarations(path)
    found = _Elements()
    try:
        found.read(path)
        return found.in_metres(path, region)
    except (expat.ExpatError, KeyError, ValueError, OverflowError, OSError) as error:
        if isinstance(error, ImportRefusal):
            raise
        reason = f"a {found.element} without {error}" if isinstance(error, KeyError) else " ".join(str(error).split())
        raise ImportRefusal(f"{path}: can't be read as a Lanelet2 map ({reason[:200]}); export it again") from None


class _Elements:
    """What has been read so far."""

    def __init__(self) -> None:
        self.element = "map"
        """The last element that began."""
        self.degrees: dict[int, tuple[float, float]] = {}
        """Longitude and latitude of nodes, where they have any."""
        self.local: dict[int, tuple[float, float]] = {}
        """Metres of nodes, where they have any."""
        self.ways: dict[int, tuple[list[int], Tags]] = {}
        self.relations: dict[int, LaneletRelation] = {}
        self._tags: Tags = {}
        self._nodes: list[int] = []
        self._members: list[LaneletMember] = []
        self._begun: dict[str, str] = {}

    def read(self, path: Path) -> None:
        """Read the file once."""
        parser = expat.ParserCreate()
        parser.StartElementHandler = self._begin
        parser.EndElementHandler = self._end
        with path.open("rb") as file:
            for chunk in iter(lambda: file.read(CHUNK), b""):
                parser.Parse(chunk)
            parser.Parse(b"", True)

    def _begin(self, name: str, attributes: dict[str, str]) -> None:
        self.element = name
        if name in ("node", "way", "relation"):
            self._tags, self._nodes, self._members, self._begun = {}, [], [], attributes
        elif name == "tag" and attributes["v"]:
            self._tags[attributes["k"]] = attributes["v"]
        elif name == "nd":
            self._nodes.append(int(attributes["ref"]))
        elif name == "member":
            role = attributes.get("role", "")
            self._members.append(LaneletMember(attributes["type"], int(attributes["ref"]), role))

    def _end(self, name: str) -> None:
        if name not in ("node", "way", "relation") or self._begun.get("action") == "delete":
            return
        self.element = name
        number = int(self._begun["id"])
        if name == "way":
            self.ways[number] = (self._nodes, self._tags)
        elif name == "relation":
            self.relations[number] = LaneletRelation(tuple(self._members), self._tags)
        else:
            self._add_node(number)

    def _add_node(self, number: int) -> None:
        """Keep where a node is: some programs leave degrees empty."""
        if self._begun.get("lat") and self._begun.get("lon"):
            place = (float(self._begun["lon"]), float(self._begun["lat"]))
            if not all(abs(x) <= most for x, most in zip(place, MOST_DEGREES, strict=True)):
                raise ValueError(f"node {number} lies nowhere on earth")
            self.degrees[number] = place
        if all(key in self._tags for key in LOCAL):
            x, y = (float(self._tags[key]) for key in LOCAL)
            if not np.isfinite([x, y]).all():
                raise ValueError(f"node {number} has no finite place")
            self.local[number] = (x, y)

    def in_metres(self, path: Path, region: Region | None) -> LaneletFile:
        """Return what was read: in the map's own metres if all nodes have some and no region is named."""
        used = list(dict.fromkeys(node for nodes, _ in self.ways.values() for node in nodes))
        known = [node for node in used if node in self.degrees or node in self.local]
        own = all(node in self.local for node in known)
        somewhere = all(node in self.degrees for node in known)
        if region is not None and not somewhere:
            raise ImportRefusal(f"{path}: doesn't say where on earth it lies; leave --centre and --bbox out")
        if not own and not somewhere:
            raise ImportRefusal(f"{path}: some nodes have only degrees and others only metres (local_x, local_y); "
                                "export it again")  # fmt: skip
        places, box = (self.local, None) if region is None and own else self._projected(path, known, region)
        lines = {number: _line(places, nodes, tags) for number, (nodes, tags) in self.ways.items()}
        missing = len(used) - len(known)
        return LaneletFile({n: x for n, x in lines.items() if x is not None}, self.relations, missing, box)

    def _projected(
        self, path: Path, nodes: list[int], region: Region | None
    ) -> tuple[dict[int, tuple[float, float]], Box | None]:
        """Return the places of nodes and the region in metres, by a projection about the middle."""
        numbers = np.array([self.degrees[node] for node in nodes]).reshape(-1, 2)
        corners = numbers if region is None else region.corners()
        lon, lat = ((corners.min(axis=0) + corners.max(axis=0)) / 2).tolist()
        project = flat_projection(path, lon, lat)
        x, y = project(numbers[:, 0], numbers[:, 1])
        places = dict(zip(nodes, zip(x.tolist(), y.tolist(), strict=True), strict=True))
        if region is None:
            return places, None
        (west, east), (south, north) = ((float(v.min()), float(v.max())) for v in project(*region.corners().T))
        return places, (west, south, east, north)


def _line(places: dict[int, tuple[float, float]], nodes: Sequence[int], tags: Tags) -> LaneletLine | None:
    """Return a line; None if it has no length, or lacks a node: nobody knows how it runs there."""
    if any(node not in places for node in nodes):
        return None
    points = np.array(list(_distinct(places[node] for node in nodes)))
    return LaneletLine(points, tags) if len(points) > 1 else None


def _distinct(points: Iterable[tuple[float, float]]) -> Iterator[tuple[float, float]]:
    """Yield points, none twice in a row."""
    last: tuple[float, float] | None = None
    for point in points:
        if point != last:
            yield point
        last = point
