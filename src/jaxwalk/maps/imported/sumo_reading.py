"""Reading SUMO networks (.net.xml) with sumolib; places are the network's own metres."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple
from xml.sax import SAXException, handler, make_parser

import numpy as np

from jaxwalk.maps.imported.osm_reading import ATTRIBUTION
from jaxwalk.maps.imported.refusals import ImportRefusal, needed
from jaxwalk.maps.imported.region import Region
from jaxwalk.maps.imported.source_map import Box
from jaxwalk.maps.imported.xml_safety import CHUNK, opened, refuse_declarations

MOST_BYTES = 80_000_000
"""Largest network, unpacked [bytes]."""
HEAD = 1 << 16
"""What netconvert says of a network stands in its first bytes."""
CARS = "passenger"
"""The class of vehicles whose lanes are imported."""
PEOPLE = "pedestrian"
_SET = '{option}[^>]*value="(?!false|0")'
_DAMAGED = (
    SAXException, KeyError, IndexError, ValueError, AttributeError, TypeError, RuntimeError, OSError, EOFError,
    zlib.error,
)  # fmt: skip
"""What sumolib, the XML parser, gzip and pyproj raise for damaged files."""


class SumoNet(NamedTuple):
    """A network."""

    edges: list[Any]
    """Those of roads, sumolib's ``Edge``."""
    inner: dict[str, Any]
    """The lanes inside junctions by their ids, sumolib's ``Lane``."""
    crossings: list[Any]
    walking_areas: list[Any]
    left: bool
    """Whether traffic keeps left."""
    guessed: frozenset[str]
    """Which of "crossings" and "sidewalks" netconvert has guessed."""
    attribution: str
    region: Box | None
    """What was asked for, as `points` has it."""

    def points(self, shape: Iterable[tuple[float, ...]]) -> np.ndarray:
        """Return points (point, 2) [m], none twice in a row, with x to the west where traffic keeps left."""
        found = np.array([(-x if self.left else x, y) for x, y, *_ in shape], float).reshape(-1, 2)
        keep = np.concatenate([[True], np.hypot(*np.diff(found, axis=0).T) > 1e-6]) if len(found) else []
        return found[np.asarray(keep, bool)]


class _Handler(handler.ContentHandler):
    """Passes elements on to sumolib's reader, and keeps what that one doesn't."""

    def __init__(self, path: Path, reader: Any) -> None:
        super().__init__()
        self.path, self.reader = path, reader
        self.root = ""
        self.left = False
        self.original_names = self.types_of_osm = False

    def startElement(self, name: str, attrs: Any) -> None:
        if not self.root and name != "net":
            raise ImportRefusal(f"{self.path}: begins with <{name}>, not with <net>; name a SUMO network")
        if not self.root:
            self.root = name
            self.left = attrs.get("lefthand", "") in ("true", "1", "yes")
        self.original_names |= name == "param" and attrs.get("key") == "origId"
        self.types_of_osm |= name == "edge" and "highway." in attrs.get("type", "")
        self.reader.startElement(name, attrs)

    def endElement(self, name: str) -> None:
        self.reader.endElement(name)

    def endDocument(self) -> None:
        self.reader.endDocument()


def read_net(path: Path, region: Region | None) -> SumoNet:
    """Return a network. Raise ImportRefusal if it can't be read or is too large."""
    sumolib = needed("sumolib", path, "sumo")
    refuse_declarations(path)
    parts = _Handler(path, sumolib.net.NetReader(withPedestrianConnections=True, withFoes=False))
    try:
        _parse(path, parts)
        net = parts.reader.getNet()
        found = _sorted(path, net, parts, None if region is None else _box(path, net, region, parts.left))
    except _DAMAGED as error:
        if isinstance(error, ImportRefusal):
            raise
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise ImportRefusal(
            f"{path}: can't be read as a SUMO network ({reason}); make it again by netconvert"
        ) from None
    return found


def _parse(path: Path, parts: _Handler) -> None:
    parser = make_parser()
    parser.setContentHandler(parts)
    with opened(path) as file:
        for chunk in _chunks(path, file):
            parser.feed(chunk)  # pyright: ignore[reportAttributeAccessIssue]
    parser.close()  # pyright: ignore[reportAttributeAccessIssue]


def _chunks(path: Path, file: Any) -> Iterator[bytes]:
    """Yield a file piece by piece. Raise ImportRefusal if it is too large."""
    seen = 0
    while chunk := file.read(CHUNK):
        seen += len(chunk)
        if seen > MOST_BYTES:
            raise ImportRefusal(f"{path}: larger than {MOST_BYTES:,} bytes; cut a part out, as with "
                                "'netconvert --keep-edges.in-boundary'")  # fmt: skip
        yield chunk


def _sorted(path: Path, net: Any, parts: _Handler, region: Box | None) -> SumoNet:
    """Return the parts of a network that are needed. Raise ValueError if a place isn't finite."""
    with opened(path) as file:
        head = file.read(HEAD).split(b"<net ")[0].decode("utf-8", "replace")
    edges = net.getEdges()
    by_function = {kind: [x for x in edges if x.getFunction() == kind] for kind in ("", "crossing", "walkingarea")}
    inner = {lane.getID(): lane for x in edges if x.getFunction() == "internal" for lane in x.getLanes()}
    shapes = [lane.getShape() for edge in edges for lane in edge.getLanes()]
    if not np.isfinite([number for shape in shapes for point in shape for number in point]).all():
        raise ValueError("a place isn't finite")
    missing = [node.getID() for edge in by_function[""] for node in _ends(edge) if not node.getType()]
    if missing:
        raise ValueError(f"junction {missing[0]} isn't in it")
    from_osm = (parts.original_names and parts.types_of_osm) or _is_set(head, "osm-files")
    words = {"crossings": ("crossings.guess",), "sidewalks": ("sidewalks.guess", "sidewalks.guess.from-permissions")}
    guessed = [word for word, options in words.items() if any(_is_set(head, option) for option in options)]
    named = ATTRIBUTION if from_osm else f"SUMO network {path.name}, which names no author"
    crossings, walks = (
        [x for x in by_function[kind] if len(x.getLanes()) == 1] for kind in ("crossing", "walkingarea")
    )
    return SumoNet(by_function[""], inner, crossings, walks, parts.left, frozenset(guessed), named, region)


def _ends(edge: Any) -> tuple[Any, Any]:
    """Return the junctions of an edge."""
    return edge.getFromNode(), edge.getToNode()


def _is_set(head: str, option: str) -> bool:
    return re.search(_SET.format(option=f"<{re.escape(option)} "), head) is not None


def _box(path: Path, net: Any, region: Region, left: bool) -> Box:
    """Return a region in a network's metres, mirrored if traffic keeps left. Raise ImportRefusal if it has no place."""
    needed("pyproj", path, "osm")
    if not net.hasGeoProj():
        raise ImportRefusal(f"{path}: doesn't say where on earth it lies; leave --centre and --bbox out")
    corners = np.array([net.convertLonLat2XY(*corner) for corner in region.corners().tolist()])
    corners = corners * (-1.0 if left else 1.0, 1.0)
    (west, south), (east, north) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return west, south, east, north
