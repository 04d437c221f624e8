"""``jaxwalk measure``."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from rich.box import SIMPLE
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from jaxwalk.cli.errors import UsageError, bad_values
from jaxwalk.cli.options import Measure
from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.formats.areas import Areas, read_areas
from jaxwalk.formats.layouts import TrackSource, open_tracks
from jaxwalk.formats.measured import measure_all
from jaxwalk.formats.tracks import Tracks
from jaxwalk.report.table import shown
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.wording import counted


def run(options: Measure) -> int:
    """Measure and show the metrics."""
    if not options.files:
        raise UsageError("FILE is missing: a table of trajectories, as in jaxwalk measure tracks.parquet")
    areas = read_areas(options.areas) if options.areas else None
    sources = [
        open_tracks(path, frame_rate=options.frame_rate, number=number) for number, path in enumerate(options.files)
    ]
    if any(source.rules != sources[0].rules for source in sources):
        raise UsageError("the files were recorded in worlds of different rules; measure each by itself")
    with bad_values():
        config = SimConfig(**sources[0].rules)
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("measuring", total=None)
        found = measure_all(
            _recordings(sources, areas), config=config, progress=lambda number: bar.update(task, completed=number)
        ).as_dict()
    if options.json:
        print(json.dumps(found, indent=2, allow_nan=False))
    else:
        console = Console()
        console.width = max(console.width, 132)
        console.print(*_tables(found), *map(escape, _left_out(found)), sep="\n")
    return 0


def _recordings(sources: list[TrackSource], areas: Areas | None) -> Iterator[tuple[Tracks, Areas | None]]:
    for source in sources:
        for tracks in source.recordings:
            yield tracks, areas or source.areas


def _tables(found: dict[str, Any]) -> Iterator[Table]:
    """Return tables of the encounters and, if it is known, of the speed differential."""
    cars = f"{counted(found['episodes'], 'car')}, {found['hours']:.2f} h, {found['kilometres']:.1f} km; 95 % intervals"
    yield _table(
        f"Encounters of {cars}",
        ("encounter", "n", "TTC < 1.5 s %", "PET < 1.5 s %", "DRAC > 3.4 m/s² %", "5 % come nearer than [m]"),
        [
            (
                kind,
                f"{one['count']:,}",
                *(_shown(one[f"{name}_critical"]) for name in ("ttc", "pet", "drac")),
                _shown(found["encounters"][kind]["minimum_gap"], 1.0, 2),
            )
            for kind, one in found["surrogates"].items()
        ],
    )
    if "speed_differential" in found:
        yield _table(
            "Speed near jaywalkers minus near crosswalk users [m/s]",
            ("distance [m]", "frames", "encounters", "matched"),
            [
                (
                    f"{one['near']:g} to {one['far']:g}",
                    *(_shown(one[name]["difference"], 1.0, 2) for name in ("pooled", "by_encounter")),
                    _shown(one["matched"], 1.0, 2),
                )
                for one in found["speed_differential"]
            ],
        )


def _shown(number: dict[str, Any], scale: float = 100.0, digits: int | None = None) -> str:
    return shown(Interval(number["value"], number["low"], number["high"]), scale, digits)


def _table(title: str, columns: tuple[str, ...], rows: list[tuple[str, ...]]) -> Table:
    made = Table(title=title, box=SIMPLE, padding=(0, 1), title_justify="left")
    for number, name in enumerate(columns):
        made.add_column(escape(name), justify="right" if number else "left", no_wrap=True)
    for row in rows:
        made.add_row(*map(escape, row))
    return made


def _left_out(found: dict[str, Any]) -> list[str]:
    """Return a line for each metric that is left out, with the reason."""
    return [f"Left out: {what} ({why})" for what, why in found["left_out"].items()]
