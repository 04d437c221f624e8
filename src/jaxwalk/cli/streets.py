"""``jaxwalk streets``."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
from rich.box import SIMPLE
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from jaxwalk.cli.checks import check_count
from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.options import Streets
from jaxwalk.maps.generated import SPLITS, Split, TownStreet
from jaxwalk.runs.folder import check_writable
from jaxwalk.viewer.street_picture import contact_sheet, street_picture
from jaxwalk.wording import counted
from jaxwalk.writing import together

MOST_STREETS, MOST_CHECKED = 200, 1_000_000
"""Most streets that are listed and drawn, and most numbers that are checked, at once."""
SHEET = "streets.png"
"""The picture of all streets."""


def run(options: Streets) -> int:
    """Check the numbers; or list the streets, and draw them if a folder is named."""
    split = check(options)
    if options.check is not None:
        _check_numbers(split, options.check)
        return 0
    refused: Counter[str] = Counter()
    with Progress(console=Console(stderr=True), transient=True) as bar:
        made = islice(split.streets(refused), options.count)
        streets = list(bar.track(made, total=options.count, description="making"))
    if options.out is not None:
        _draw(streets, options.out)
    console = Console()
    console.width = max(console.width, 100)
    console.print(_table(streets, split))
    if refused:
        console.print(f"{counted(sum(refused.values()), 'number')} refused:", *_reasons(refused), sep="\n")
    if options.out is not None:
        print(f"{options.out}: {counted(len(streets), 'picture')}, and {SHEET} with all of them")
    return 0


def check(options: Streets) -> Split:
    """Return the split from the first number on. Raise an error for impossible options."""
    split = SPLITS[options.split]
    check_count("--first", options.first, 0, len(split.numbers) - 1)
    check_count("--count", options.count, 1, MOST_STREETS)
    left = len(split.numbers) - options.first
    if options.check is not None:
        check_count("--check", options.check, 1, min(MOST_CHECKED, left))
        if options.out is not None:
            raise UsageError("--out: --check draws nothing; leave one of them out")
    if options.out is not None:
        check_writable(options.out)
        if options.out.exists() and not options.out.is_dir():
            raise UsageError(f"--out {options.out}: is a file; name a folder")
    return replace(split, numbers=split.numbers[options.first :])


def _check_numbers(split: Split, count: int) -> None:
    """Make a street of each number, and print what came of it."""
    refused: Counter[str] = Counter()
    seconds = []
    with Progress(console=Console(stderr=True), transient=True) as bar:
        for number in bar.track(split.numbers[:count], description="making"):
            begun = time.perf_counter()
            split.street(number, refused)
            seconds.append(time.perf_counter() - begun)
    accepted = count - sum(refused.values())
    times = 1000 * np.array(seconds)
    print(f"{split.name}: {counted(count, 'number')} from {split.numbers[0]:,} on, family {split.family.hash}")
    print(f"{accepted:,} accepted ({accepted / count:.1%}), {count - accepted:,} refused")
    print(*_reasons(refused), sep="\n", end="\n" if refused else "")
    print(f"{np.median(times):.0f} ms for each (median; mean {times.mean():.0f} ms, longest {times.max():.0f} ms)")


def _reasons(refused: Counter[str]) -> list[str]:
    """Return a line for each reason, the most frequent first."""
    return [f"  {times:,} x {reason}" for reason, times in sorted(refused.items(), key=lambda x: (-x[1], x[0]))]


def _draw(streets: list[TownStreet], folder: Path) -> None:
    """Write the pictures: all of them, or none."""
    folder.mkdir(parents=True, exist_ok=True)
    titled = [(f"street {street.number}: {street.layout}", street.network) for street in streets]
    with Progress(console=Console(stderr=True), transient=True) as bar, together():
        for street, (title, network) in bar.track(list(zip(streets, titled, strict=True)), description="drawing"):
            street_picture(network, folder / f"{street.number}.png", title)
        contact_sheet(titled, folder / SHEET)


def _table(streets: list[TownStreet], split: Split) -> Table:
    """Return what the streets are like."""
    table = Table(title=f"{split.name}, family {split.family.hash}", box=SIMPLE, title_justify="left")
    for name in ("number", "layout", "size [m]", "lanes", "km/h", "crossings", "islands", "waypoints", "routes"):
        table.add_column(name, justify="left" if name == "layout" else "right", no_wrap=True)
    for number, layout, network in streets:
        width, height = network.size
        islands = sum(area.kind == "island" for area in network.areas)
        fastest = max(lane.speed_limit for lane in network.lanes)
        numbers = (len(network.crossings), islands, network.walk.waypoints, len(network.routes))
        table.add_row(str(number), layout, f"{width:.0f} x {height:.0f}", str(len(network.lanes)),
                      f"{3.6 * fastest:.0f}", *map(str, numbers))  # fmt: skip
    return table
