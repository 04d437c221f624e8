"""Small OpenStreetMap files, written in metres: roads, footways and houses about a place in Helsinki."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

LATITUDE, LONGITUDE = 60.17, 24.94
DEGREE = 111_412.9
"""Metres of a degree of latitude there, on WGS 84; one of longitude is 55,524 m."""
WEST_EAST = 55_524.0


@dataclass
class OsmFile:
    """A map that grows."""

    nodes: dict[tuple[float, float], int] = field(default_factory=dict)
    node_tags: dict[int, dict[str, str]] = field(default_factory=dict)
    ways: list[tuple[list[int], dict[str, str]]] = field(default_factory=list)

    def node(self, x: float, y: float, **tags: str) -> int:
        """The number of the node at a place, made if there is none; ``_`` in a key stands for ``:``."""
        number = self.nodes.setdefault((x, y), len(self.nodes) + 1)
        self.node_tags.setdefault(number, {}).update({key.replace("_", ":"): value for key, value in tags.items()})
        return number

    def way(self, *points: tuple[float, float], **tags: str) -> OsmFile:
        """Add a way; ``_`` in a key stands for ``:``."""
        own = {key.replace("_", ":"): value for key, value in tags.items()}
        self.ways.append(([self.node(*point) for point in points], own))
        return self

    def text(self) -> str:
        """The file."""
        lines = ['<?xml version="1.0" encoding="UTF-8"?>', '<osm version="0.6" generator="tests">']
        for (x, y), number in self.nodes.items():
            where = f'lat="{LATITUDE + y / DEGREE:.9f}" lon="{LONGITUDE + x / WEST_EAST:.9f}"'
            lines.append(f'<node id="{number}" version="1" {where}>{_tags(self.node_tags[number])}</node>')
        for number, (nodes, tags) in enumerate(self.ways, 1):
            refs = "".join(f'<nd ref="{node}"/>' for node in nodes)
            lines.append(f'<way id="{number}" version="1">{refs}{_tags(tags)}</way>')
        return "\n".join([*lines, "</osm>"])

    def write(self, path: Path) -> Path:
        """Write the file and return its path."""
        path.write_text(self.text(), encoding="utf-8")
        return path


def _tags(tags: dict[str, str]) -> str:
    return "".join(f"<tag k={quoteattr(key)} v={quoteattr(value)}/>" for key, value in tags.items())


ROAD = {"highway": "residential", "sidewalk": "both", "lanes": "2", "width": "6", "maxspeed": "30"}


def cross(arm: float = 110.0, at: float = 14.0, **road: str) -> OsmFile:
    """Two roads of 6 m that cross at (0, 0), with a zebra on each of the four arms."""
    made = OsmFile()
    tags = {**ROAD, **road}
    for ahead in (np.array([1, 0]), np.array([0, 1])):
        points = [tuple((sign * ahead).tolist()) for sign in (-arm, -at, 0, at, arm)]
        for point in (points[1], points[3]):
            made.node(*point, highway="crossing", crossing="zebra")
        made.way(*points, **tags)
    return made


def divided() -> OsmFile:
    """A road of two one-way roads, 12 m apart, with a footway over both."""
    made = OsmFile()
    tags = {"highway": "secondary", "oneway": "yes", "lanes": "2", "width": "6.5", "sidewalk": "right", "name": "Wide"}
    made.way((-110, -6), (0, -6), (110, -6), **tags)
    made.way((110, 6), (0, 6), (-110, 6), **tags)
    made.way((0, -14), (0, -6), (0, 6), (0, 14), highway="footway", footway="crossing", crossing="traffic_signals")
    return made
