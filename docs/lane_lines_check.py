"""The check of docs/real-streets.md: do the lanes of our import lie where a second reading of the same file has them?

    python docs/lane_lines_check.py town.osm other.osm road.xodr

OpenStreetMap we read ourselves, and SUMO's netconvert is the second reading, by the same projection. What a file says
of lanes and widths is replaced by one lane of 3.2 m in each direction, since each fills gaps by rules of its own.
OpenDRIVE is the other way round: netconvert reads the roads of an import, and the second reading is ours, that of the
roads of OpenSCENARIO files. Points of our lanes, one each metre, are compared with the nearest lane of the other
reading that leads the same way. Junctions and what is near them are left out: there each draws curves of its own.
Needs pip install "jaxwalk[osm,opendrive]".
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import xml.etree.ElementTree as ET
from collections import defaultdict
from pathlib import Path

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
        id, lane_points = road.attrib["id"], defaultdict(list)
        if road.get("junction", "-1") != "-1":
            continue
        for s in np.arange(0.0, roads.length(id), 0.5):
            for lane, (begin, end, kind) in roads.lanes(id, s).items():
                if kind in DRIVEN:
                    lane_points[lane].append(roads.at(id, s, (begin + end) / 2)[:2])
        lines += [points[:: roads.direction(id, lane)] for lane, points in lane_points.items() if len(points) > 1]
    return [shapely.LineString(points) for points in lines]


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


def compared(path: Path) -> np.ndarray:
    """Return for each compared point of our lanes how far the other reading's is [m]; NaN where it has none."""
    region = None if path.suffix == ".xodr" else bounds(path)
    source, (lines, outlines) = read_source(path, region), read_otherwise(path, region)
    tree = shapely.STRtree(lines)
    apart = shapely.union_all([*source.junctions, *outlines, *(
        shapely.LineString(lane.line) for lane, inside in zip(source.lanes, source.in_junction, strict=True) if inside
    )])  # fmt: skip
    shapely.prepare(apart)
    found = []
    for lane in (lane for lane, inside in zip(source.lanes, source.in_junction, strict=True) if not inside):
        line = shapely.LineString(lane.line)
        for metres in np.arange(0.5, line.length, 1.0):
            point = line.interpolate(metres)
            if not shapely.dwithin(apart, point, CLEAR) and _inside(source.extent, point):
                found.append(_nearest(line, metres, lines, tree))
    return np.array(found)


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


def main() -> None:
    """Compare each file, and print a row of a table for it."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    options.add_argument("files", nargs="+", type=Path)
    made = provenance()
    print(f"commit {made.commit}\n")
    print("| file | compared, m | the other has the lane, % | of these within 1 m, % | median, m |")
    print("| --- | --- | --- | --- | --- |")
    for file in options.parse_args().files:
        with tempfile.TemporaryDirectory() as folder:
            distances = compared(file if file.suffix == ".xodr" else of_equal_widths(file, Path(folder)))
        known = distances[np.isfinite(distances)]
        has, good = 100 * len(known) / len(distances), 100 * (known <= GOOD).mean()
        print(f"| {file.name} | {len(distances):,} | {has:.1f} | {good:.1f} | {np.median(known):.2f} |", flush=True)


if __name__ == "__main__":
    main()
