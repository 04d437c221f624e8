"""OpenDRIVE files (.xodr) as source maps: SUMO's netconvert makes a network of the roads; crosswalks are the file's."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable, Iterator
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree.ElementTree import parse
from xml.sax.saxutils import quoteattr

import numpy as np
import shapely

from jaxwalk.maps.imported.crossing_places import RoadLines
from jaxwalk.maps.imported.opendrive_file import DriveFile, opendrive_file
from jaxwalk.maps.imported.refusals import ImportRefusal, needed
from jaxwalk.maps.imported.region import Region
from jaxwalk.maps.imported.source_map import SourceCrossing, SourceMap
from jaxwalk.maps.imported.sumo_ground import junction_regions
from jaxwalk.maps.imported.sumo_reading import SumoNet, read_net
from jaxwalk.maps.imported.sumo_source import CROSSING_WIDTHS, imported_edges, net_map
from jaxwalk.wording import counted

LONGEST = 120.0
"""Time limit of netconvert [s]."""
NEAR_LIGHTS = 10.0
"""A crosswalk this close to a junction with traffic lights has some [m]."""
ALONE = "authority"
"""A class of vehicles that nobody drives here: lanes for it are roadway."""
LANES = {
    **dict.fromkeys(("driving", "entry", "exit", "onRamp", "offRamp", "connectingRamp", "slipLane"), "passenger"),
    **dict.fromkeys(("shoulder", "stop", "parking", "restricted", "bidirectional", "roadWorks", "HOV"), ALONE),
    **dict.fromkeys(("bus", "taxi"), "bus"), "biking": "bicycle", "tram": "tram", "rail": "rail",
    **dict.fromkeys(("sidewalk", "walking"), "pedestrian"),
}  # fmt: skip
"""Who may use the lanes of a type. Those of all others (border, curb, median, none) are no part of the roadway."""
OPTIONS = (
    "--xml-validation", "never", "--offset.disable-normalization", "--opendrive.import-all-lanes",
    "--opendrive.internal-shapes", "--opendrive.lane-shapes", "--output.street-names", "--no-warnings",
)  # fmt: skip


def opendrive_map(path: Path, region: Region | None, *, left: bool = False) -> SourceMap:
    """Return what an OpenDRIVE file has. Raise ImportRefusal if it can't be used."""
    if region is not None:
        raise ImportRefusal(f"{path}: OpenDRIVE files are read whole; leave --centre and --bbox out")
    program = netconvert(path)
    file = opendrive_file(path)
    with TemporaryDirectory(prefix="jaxwalk-") as folder:
        net, outlines = _converted(path, program, file, Path(folder))
    made = net_map(path, net, left=left)
    found = tuple(_crossings(net, made, file, outlines))
    lost = len(file.crosswalks) - len(found)
    more = (f"{counted(lost, 'crosswalk')} that netconvert doesn't place",) if lost else ()
    return replace(
        made,
        format="OpenDRIVE, roads by netconvert",
        attribution=f"OpenDRIVE file {path.name}, which names no author",
        crossings=found,
        left_out=made.left_out + more,
    )


def netconvert(path: Path) -> str:
    """Return the program netconvert. Raise ImportRefusal if there is none."""
    needed("sumolib", path, "opendrive")
    package = find_spec("sumo")
    folders = [] if package is None else package.submodule_search_locations or []
    own = (shutil.which("netconvert", path=str(Path(folder) / "bin")) for folder in folders)
    found = next((program for program in own if program), None) or shutil.which("netconvert")
    if found is None:
        raise ImportRefusal(
            f'{path}: reading it needs SUMO\'s program netconvert; install it by: pip install "jaxwalk[opendrive]"'
        )
    return found


def _converted(path: Path, program: str, file: DriveFile, folder: Path) -> tuple[SumoNet, dict[str, np.ndarray]]:
    """Return the network of a file, and the outlines (corner, 2) of objects by their ids [m]."""
    roads, types, made, shapes = (folder / name for name in ("roads.xodr", "types.xml", "made.net.xml", "shapes.xml"))
    roads.write_bytes(file.text)
    types.write_text(_lane_types(file.lane_types), encoding="utf-8")
    files = ("--opendrive-files", roads, "--type-files", types, "--output-file", made, "--polygon-output", shapes)
    command = [program, *OPTIONS, *map(str, files)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=LONGEST, check=False, cwd=folder)
    except subprocess.TimeoutExpired:
        raise ImportRefusal(f"{path}: netconvert took longer than {LONGEST:g} s; cut a part out") from None
    except OSError as error:
        raise ImportRefusal(f"{path}: netconvert can't be started ({error}); install eclipse-sumo again") from None
    if done.returncode or not made.is_file():
        said = done.stderr.decode("utf-8", "replace").replace(str(roads), path.name)
        errors = [line for line in said.splitlines() if line.startswith("Error")] or said.splitlines()[-1:]
        reason = " ".join(" ".join(errors[:1]).split())[:200] or f"exit code {done.returncode}"
        raise ImportRefusal(f"{path}: netconvert can't make a network of it ({reason}); export it again")
    try:
        net = read_net(made, None)
    except ImportRefusal as refusal:
        raise ImportRefusal(str(refusal).replace(str(made), str(path))) from None
    return net, dict(_outlines(shapes)) if shapes.is_file() else {}


def _lane_types(names: Iterable[str]) -> str:
    """Return the file that says who may use lanes of some types; without it, everybody may use unknown ones."""
    said = {name: f'allow="{LANES[name]}" priority="1"' if name in LANES else 'disallow="all"' for name in names}
    return f"<types>{''.join(f'<type id={quoteattr(name)} {who}/>' for name, who in said.items())}</types>"


def _outlines(path: Path) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the ids of objects and their outlines, from the file that netconvert has written."""
    for shape in parse(path).getroot().iter("poly"):
        corners = [corner.split(",")[:2] for corner in shape.attrib["shape"].split()]
        yield shape.attrib["id"], np.array(corners, float)


def _crossings(
    net: SumoNet, made: SourceMap, file: DriveFile, outlines: dict[str, np.ndarray]
) -> Iterator[SourceCrossing]:
    """Yield the crosswalks: with traffic lights if they lie at a junction that has some."""
    along, through = (
        [lane.line for lane, inside in zip(made.lanes, made.in_junction, strict=True) if inside == wanted]
        for wanted in (False, True)
    )
    roads = RoadLines(along, through)
    lights = shapely.union_all(junction_regions(net, imported_edges(net), "traffic_light"))
    for number, name in file.crosswalks.items():
        outline = outlines.get(number, np.zeros((0, 2)))
        if len(outline) > 2:
            point = outline.mean(axis=0)
            across, width = _across(outline, roads.direction(point))
            is_light = lights.distance(shapely.Point(point)) < NEAR_LIGHTS
            kind, origin = ("signals", "inferred") if is_light else ("zebra", "mapped")
            yield SourceCrossing(name, kind, point, across, origin, float(np.clip(width, *CROSSING_WIDTHS)))


def _across(outline: np.ndarray, road: np.ndarray | None) -> tuple[np.ndarray, float]:
    """Return the direction of the way over the road (2,), and the metres along the road, of a rectangle (corner, 2).

    The way is along the sides that are straight over the road; without a road, along the longer ones.
    """
    sides = outline[1:3] - outline[0:2]
    lengths = np.hypot(*sides.T)
    units = sides / lengths[:, None]
    way = int(np.argmin(np.abs(units @ road))) if road is not None else int(np.argmax(lengths))
    return units[way], float(lengths[1 - way])
