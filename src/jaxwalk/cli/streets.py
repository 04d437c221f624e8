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
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from jaxwalk.cli.checks import check_count
from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.options import Streets
from jaxwalk.maps import each_map, load_network, map_name
from jaxwalk.maps.generated import SPLITS, Split, TownStreet
from jaxwalk.maps.network import Network
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
    if options.map:
        check_maps(options)
        return _show_maps(options)
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
    console = _print(_table(streets, split))
    if refused:
        console.print(f"{counted(sum(refused.values()), 'number')} refused:", *_reasons(refused), sep="\n")
    if options.out is not None:
        print(f"{options.out}: {counted(len(streets), 'picture')}, and {SHEET} with all of them")
    return 0


def check_maps(options: Streets) -> None:
    """Raise an error for what goes only with generated streets, and for a folder that can't be written."""
    if options.check is not None:
        raise UsageError("--check: is for generated streets; leave it out, or leave out --map")
    _check_out(options)


def _show_maps(options: Streets) -> int:
    """List maps, and draw them if a folder is named."""
    names = each_map(options.map)[:MOST_STREETS]
    networks = [(map_name(name), load_network(name)) for name in names]
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
        _pictures([(Path(name).stem, name, network) for name, network in networks], options.out)
    table = _columns("maps", "map")
    for name, network in networks:
        table.add_row(escape(name), *_numbers(network))
    _print(table)
    if len(each_map(options.map)) > MOST_STREETS:
        print(f"only the first {MOST_STREETS} of them")
    if options.out is not None:
        print(f"{options.out}: {counted(len(networks), 'picture')}, and {SHEET} with all of them")
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
    _check_out(options)
    return replace(split, numbers=split.numbers[options.first :])


def _check_out(options: Streets) -> None:
    if options.out is not None:
        check_writable(options.out)
        if options.out.exists() and not options.out.is_dir():
            raise UsageError(f"--out {options.out}: is a file; name a folder")


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
    """Write the pictures of generated streets."""
    folder.mkdir(parents=True, exist_ok=True)
    _pictures([(str(x.number), f"street {x.number}: {x.layout}", x.network) for x in streets], folder)


def _pictures(named: list[tuple[str, str, Network]], folder: Path) -> None:
    """Write a picture for each file name, title and street, and one of all: all pictures, or none."""
    with Progress(console=Console(stderr=True), transient=True) as bar, together():
        for name, title, network in bar.track(named, description="drawing"):
            street_picture(network, folder / f"{name}.png", title)
        contact_sheet([(title, network) for _, title, network in named], folder / SHEET)


def _print(table: Table) -> Console:
    console = Console()
    console.width = max(console.width, 100)
    console.print(table)
    return console


def _columns(title: str, *names: str) -> Table:
    """Return a table for streets, whose first columns have some names."""
    table = Table(title=title, box=SIMPLE, title_justify="left")
    for name in (*names, "size [m]", "lanes", "km/h", "crossings", "islands", "waypoints", "routes"):
        table.add_column(name, justify="left" if name in ("layout", "map") else "right", no_wrap=True)
    return table


def _numbers(network: Network) -> tuple[str, ...]:
    """Return what a street is like, as cells of a table."""
    width, height = network.size
    islands = sum(area.kind == "island" for area in network.areas)
    fastest = max(lane.speed_limit for lane in network.lanes)
    counts = (len(network.crossings), islands, network.walk.waypoints, len(network.routes))
    return f"{width:.0f} x {height:.0f}", str(len(network.lanes)), f"{3.6 * fastest:.0f}", *map(str, counts)


def _table(streets: list[TownStreet], split: Split) -> Table:
    """Return what generated streets are like."""
    table = _columns(f"{split.name}, family {split.family.hash}", "number", "layout")
    for number, layout, network in streets:
        table.add_row(str(number), layout, *_numbers(network))
    return table
