"""``jaxwalk import``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from jaxwalk.cli.errors import DIFFERS, UsageError
from jaxwalk.cli.options import Import
from jaxwalk.maps.imported.importing import import_street, import_tiles, read_source, report_of
from jaxwalk.maps.imported.region import Region
from jaxwalk.maps.imported.source_map import SourceMap
from jaxwalk.maps.imported.street_maker import ImportedStreet
from jaxwalk.maps.imported.street_report import ImportReport
from jaxwalk.maps.imported.tiles import SIZES
from jaxwalk.maps.map_reading import IMPORT_REPORT
from jaxwalk.maps.network_file import network_text
from jaxwalk.report.import_page import report_json, write_import_page
from jaxwalk.runs.folder import check_writable
from jaxwalk.runs.lock import LOCK, held
from jaxwalk.wording import counted, first_of
from jaxwalk.writing import together, write_whole

STREET = ".json"
"""How the name of a street's file ends."""
SHOWN = 5
"""Pieces of advice that are printed of a single street."""


def run(options: Import) -> int:
    """Import the streets and write them with the report; return `DIFFERS` if none can be used."""
    region = check(options)
    source = read_source(options.file, region, left=options.traffic == "left")
    single = options.out.suffix == STREET
    named = (source, options.out.stem)
    streets = [import_street(*named, strict=options.strict)] if single else _tiles(source, options)
    report = report_of(source, streets, options.file.name, strict=options.strict)
    page = options.out.with_suffix(".report.html") if single else options.out / "report.html"
    page.parent.mkdir(parents=True, exist_ok=True)
    with nullcontext() if single else held(options.out):
        with together():
            _write(options, report, streets, page)
        _remove_older(options, streets)
    print(*_lines(report, page), sep="\n")
    return 0 if any(street.network is not None for street in streets) else DIFFERS


def check(options: Import) -> Region | None:
    """Raise an error for impossible options; return the region."""
    if options.centre is not None and options.bbox is not None:
        raise UsageError("--centre and --bbox: both name a part of the map; leave one of them out")
    if options.out.suffix not in ("", STREET):
        raise UsageError(
            f"--out {options.out}: name a file that ends in {STREET} for one street, or a folder for tiles"
        )
    if not SIZES[0] <= options.tile <= SIZES[1]:
        raise UsageError(f"--tile must lie in [{SIZES[0]:g}, {SIZES[1]:g}] m, not {options.tile:g}")
    if options.out.suffix == STREET and options.out.is_dir():
        raise UsageError(f"--out {options.out}: is a folder; name a file")
    check_writable(options.out.parent if options.out.suffix == STREET else options.out)
    if not options.out.suffix and options.out.exists():
        _check_folder(options.out)
    if options.centre is not None:
        return Region.around(*options.centre, options.radius)
    return None if options.bbox is None else Region.of_box(options.bbox)


def _check_folder(folder: Path) -> None:
    """Raise UsageError for a folder with files that aren't of an import, some of which would be taken for streets."""
    names = {path.name for path in folder.iterdir()} - {LOCK}
    if names and IMPORT_REPORT not in names:
        raise UsageError(f"--out {folder}: has other files ({first_of(sorted(names), 'file')}); name a new folder")


def _tiles(source: SourceMap, options: Import) -> list[ImportedStreet]:
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("cutting")
        return import_tiles(
            source, options.tile, strict=options.strict,
            told=lambda done, whole: bar.update(task, completed=done, total=whole),
        )  # fmt: skip


def _write(options: Import, report: ImportReport, streets: Sequence[ImportedStreet], page: Path) -> None:
    """Write the streets that can be used, and the report."""
    for street in streets:
        if street.network is not None:
            write_whole(_path(options, street), network_text(street.network))
    write_import_page(page, report, {street.report.name: street.network for street in streets})
    write_whole(page.with_suffix(STREET), report_json(report))


def _path(options: Import, street: ImportedStreet) -> Path:
    single = options.out.suffix == STREET
    return options.out if single else options.out / f"{street.report.name}{STREET}"


def _remove_older(options: Import, streets: Sequence[ImportedStreet]) -> None:
    """Remove the streets of an earlier import, which the report isn't about."""
    written = {_path(options, street) for street in streets if street.network is not None}
    single = options.out.suffix == STREET
    for old in [options.out] if single else options.out.glob(f"tile-*{STREET}"):
        if old not in written:
            old.unlink(missing_ok=True)


def _lines(report: ImportReport, page: Path) -> Iterator[str]:
    """Yield what to say of an import."""
    crossings = report.crossings()
    placed = sum(outcome.placed for outcome in crossings.values())
    yield f"{report.source}: {counted(len(report.streets), 'street')} ({report.attribution})"
    for verdict, count in Counter(street.verdict for street in report.streets).items():
        yield f"  {count:,} {verdict}"
    yield f"  {placed:,} of {counted(len(crossings), 'mapped crossing')} of roads can be used"
    if len(report.streets) == 1:
        street = report.streets[0]
        yield from (f"  {reason}" for reason in street.reasons)
        yield from (f"  to add to the map: {advice}" for advice in street.advice[:SHOWN])
    yield f"Open {page}"
