"""The check of docs/real-streets.md: do the lanes of our import lie where a second reading of the same file has them?

    python docs/lane_lines_check.py town.osm other.osm road.xodr
    python docs/lane_lines_check.py town.osm other.osm --as-tagged

OpenStreetMap we read ourselves, and SUMO's netconvert is the second reading, by the same projection. What a file says
of lanes and widths is replaced by one lane of 3.2 m in each direction, since each fills gaps by rules of its own; with
--as-tagged it stays. OpenDRIVE is the other way round: netconvert reads the roads of an import, and the second reading
is ours, that of the roads of OpenSCENARIO files. Points of our lanes, one each metre, are compared with the nearest
lane of the other reading that leads the same way. Junctions and what is near them are left out: there each draws curves
of its own. So it tests where roads lie, on which side of a road's middle each direction drives, and the lines of lanes
between junctions. It tests neither junctions nor, without --as-tagged, the numbers of lanes.
Needs pip install "jaxwalk[osm,opendrive]".
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.imported.importing import read_source
from jaxwalk.maps.imported.opendrive_source import netconvert
from jaxwalk.maps.imported.region import Region
from jaxwalk.provenance import provenance
from jaxwalk.scenarios.xosc.plain_roads import DRIVEN, PlainRoads

CLEAR = 15.0
"""Points nearer to a junction, ours or theirs, aren't compared [m]."""
NEAR = 10.0
"""Where the other reading has no lane this near that leads the same way, it doesn't have the road [m]."""
ALIKE = np.cos(np.radians(30.0))
"""Lanes lead the same way if the cosine of the angle between them is at least this."""
WIDTH = 3.2
"""Width of a lane, netconvert's usual one [m]."""
ONE_WAY = {"oneway": ("yes", "1", "true", "-1"), "junction": ("roundabout", "circular")}
"""Tags of ways with one direction."""
OF_WIDTH = ("lanes", "width", "est_width", "parking", "placement", "turn", "busway", "change")
"""Tags that begin so are left out."""
GOOD = 1.0
"""Lanes agree if they are this near [m]."""
STEP = 0.5
"""Distance between the points of a lane of OpenDRIVE [m]."""


class LanesCompared(NamedTuple):
    """What came of a file."""

    distances: np.ndarray
    """For each compared point of our lanes how far the other reading's is [m]; NaN where it has none."""
    points: int
    """Number of points of our lanes, those in and near junctions and beyond the file's edge included."""


def of_equal_widths(path: Path, folder: Path) -> Path:
    """Return a copy of a file in which each road has one lane in each direction that it has."""
    tree = ET.parse(path)
    for way in tree.getroot().findall("way"):
        tags = {tag.attrib["k"]: tag for tag in way.findall("tag")}
        if "highway" not in tags:
            continue
        for tag in (tag for name, tag in tags.items() if name.partition(":")[0] in OF_WIDTH):
            way.remove(tag)
        one_way = any(name in tags and tags[name].attrib["v"] in values for name, values in ONE_WAY.items())
        lanes = 1 if one_way else 2
        for name, value in {"lanes": f"{lanes}", "width": f"{lanes * WIDTH:g}"}.items():
            ET.SubElement(way, "tag", k=name, v=value)
    tree.write(folder / path.name)
    return folder / path.name


def bounds(path: Path) -> Region:
    """Return the region of all nodes of a file."""
    nodes = [one for _, one in ET.iterparse(path) if one.tag == "node"]
    lon, lat = (np.array([float(one.attrib[name]) for one in nodes]) for name in ("lon", "lat"))
    return Region(float(lon.min()), float(lat.min()), float(lon.max()), float(lat.max()))


def read_otherwise(path: Path, region: Region | None) -> tuple[list[shapely.LineString], list[BaseGeometry]]:
    """Return the lines of lanes for cars by the second reading, and the outlines of junctions, if it has any [m]."""
    return (_of_opendrive(path), []) if region is None else _of_netconvert(path, region)


def _of_opendrive(path: Path) -> list[shapely.LineString]:
    """Return the lanes of roads outside of junctions, by our own reading."""
    roads, lines = PlainRoads(path), []
    for road in ET.parse(path).getroot().findall("road"):
        if road.get("junction", "-1") == "-1":
            lines += [line for ends in _sections(road, roads) for line in _of_section(road.attrib["id"], roads, *ends)]
    return lines


def _sections(road: ET.Element, roads: PlainRoads) -> Iterator[tuple[float, float]]:
    """Yield where each section of a road's lanes begins and ends [m]: a number may mean another lane in the next."""
    begins = sorted(float(section.attrib["s"]) for section in road.findall("lanes/laneSection"))
    ends = [*begins[1:], roads.length(road.attrib["id"])]
    return ((begin, end) for begin, end in zip(begins, ends, strict=True) if end > begin)


def _of_section(id: str, roads: PlainRoads, begin: float, end: float) -> list[shapely.LineString]:
    lane_points: dict[int, list[tuple[float, float]]] = defaultdict(list)
    inside = end - 1e-4  # at its end the next section is in force
    for s in np.append(np.arange(begin, inside, STEP), inside).tolist():
        for lane, (inner, outer, kind) in roads.lanes(id, s).items():
            if kind in DRIVEN:
                lane_points[lane].append(roads.at(id, s, (inner + outer) / 2)[:2])
    return [shapely.LineString(points[:: roads.direction(id, lane)]) for lane, points in lane_points.items()]


def _of_netconvert(path: Path, region: Region) -> tuple[list[shapely.LineString], list[BaseGeometry]]:
    middle = f"+lat_0={(region.south + region.north) / 2:.7f} +lon_0={(region.west + region.east) / 2:.7f}"
    with tempfile.TemporaryDirectory() as folder:
        net = Path(folder) / "out.net.xml"
        subprocess.run(
            [netconvert(path), "--osm-files", str(path), "--output-file", str(net), "--no-warnings",
             "--offset.disable-normalization", "--proj", f"+proj=tmerc {middle} +ellps=WGS84 +units=m"],
            check=True, capture_output=True,
        )  # fmt: skip
        root = ET.parse(net).getroot()
    lanes = [
        lane for edge in root.findall("edge") if edge.get("function") is None for lane in edge.findall("lane")
        if _for_cars(lane)
    ]  # fmt: skip
    outlines = (_points(one.get("shape", "")) for one in root.findall("junction"))
    return (
        [shapely.LineString(_points(lane.get("shape", ""))) for lane in lanes],
        [shapely.make_valid(shapely.Polygon(points)) for points in outlines if len(points) > 2],
    )


def _for_cars(lane: ET.Element) -> bool:
    allowed, banned = lane.get("allow", "").split(), lane.get("disallow", "").split()
    return "passenger" in allowed if allowed else "passenger" not in banned and "all" not in banned


def _points(shape: str) -> np.ndarray:
    return np.array([[float(x) for x in point.split(",")[:2]] for point in shape.split()])


def compared(path: Path) -> LanesCompared:
    """Compare the lanes of a file's two readings."""
    region = None if path.suffix == ".xodr" else bounds(path)
    source, (lines, outlines) = read_source(path, region), read_otherwise(path, region)
    tree = shapely.STRtree(lines)
    lanes = [(shapely.LineString(x.line), inside) for x, inside in zip(source.lanes, source.in_junction, strict=True)]
    apart = shapely.union_all([*source.junctions, *outlines, *(line for line, inside in lanes if inside)])
    shapely.prepare(apart)
    found, points = [], 0
    for line, inside in lanes:
        for metres in np.arange(0.5, line.length, 1.0):
            point, points = line.interpolate(metres), points + 1
            if not inside and not shapely.dwithin(apart, point, CLEAR) and _inside(source.extent, point):
                found.append(_nearest(line, metres, lines, tree))
    return LanesCompared(np.array(found), points)


def _inside(box: tuple[float, float, float, float], point: shapely.Point) -> bool:
    return box[0] <= point.x <= box[2] and box[1] <= point.y <= box[3]


def _nearest(line: shapely.LineString, metres: float, lines: list[shapely.LineString], tree: shapely.STRtree) -> float:
    """Return how far from a place on our lane the nearest lane is that leads the same way."""
    point, ahead = line.interpolate(metres), _heading(line, metres)
    near = [lines[number] for number in tree.query(point, predicate="dwithin", distance=NEAR)]
    same = [x.distance(point) for x in near if _heading(x, x.project(point)) @ ahead >= ALIKE]
    return min(same, default=np.nan)


def _heading(line: shapely.LineString, metres: float) -> np.ndarray:
    """Return the direction of a line at a place, as a unit vector."""
    begin, end = (line.interpolate(float(np.clip(metres + by, 0, line.length))) for by in (-0.5, 0.5))
    along = np.array([end.x - begin.x, end.y - begin.y])
    return along / max(float(np.hypot(*along)), 1e-9)


def row(file: Path, *, as_tagged: bool) -> str:
    """Return a file's row of the table."""
    with tempfile.TemporaryDirectory() as folder:
        alike = as_tagged or file.suffix == ".xodr"
        distances, points = compared(file if alike else of_equal_widths(file, Path(folder)))
    if not len(distances):
        return f"| {file.name} | 0 | 0.0 | - | - | - |"
    known = distances[np.isfinite(distances)]
    of_ours, has = 100 * len(distances) / points, 100 * len(known) / len(distances)
    good, median = (f"{100 * (known <= GOOD).mean():.1f}", f"{np.median(known):.2f}") if len(known) else ("-", "-")
    return f"| {file.name} | {len(distances):,} | {of_ours:.1f} | {has:.1f} | {good} | {median} |"


def main() -> None:
    """Compare each file, and print a row of a table for it."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    options.add_argument("files", nargs="+", type=Path)
    words = "with the lanes and widths that each reading infers itself from an OpenStreetMap file"
    options.add_argument("--as-tagged", action="store_true", help=words)
    asked = options.parse_args()
    print(f"commit {provenance().commit}\n")
    print("| file | compared, m | of our lanes, % | the other has the lane, % | of these within 1 m, % | median, m |")
    print("| --- " * 6 + "|")
    for file in asked.files:
        print(row(file, as_tagged=asked.as_tagged), flush=True)


if __name__ == "__main__":
    main()
