"""The table of an evaluation in a terminal: several tables below each other where one is too wide for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rich.box import SIMPLE
from rich.console import Console
from rich.markup import escape
from rich.measure import Measurement
from rich.table import Table

from jaxwalk.evaluation import Cell
from jaxwalk.evaluation.map_rates import MapRates
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.report.table import shown
from jaxwalk.sim.observation import PRIVILEGED_SETS

WIDEST = 226
"""Width of tables in files and pipes, and the width at which tables are measured [characters].

All numbers at their widest, a column of multipliers and the heads of the names take 223. Longer names are folded."""
MOST_MAPS = 12
"""Most maps in the table of a cell; of more, it shows those with the most collisions."""
TITLE = "95 % intervals in brackets"
TOUCHED = (
    "moving car: scenarios in which it touches somebody, by disc (centres too close) / footprint (a body overlaps the "
    "car);\nthe world's rule, which ends scenarios, gives the hits of jaxwalk report"
)
"""What the column of contacts shows."""

OF_MAPS: dict[str, Callable[[Cell | MapRates], str]] = {
    "goal %": lambda found: shown(found.goal_rate),
    "collision %": lambda found: shown(found.collision_rate),
    "timeout %": lambda found: shown(found.timeout_rate),
    "time to goal [s]": lambda found: shown(found.mean_time_to_goal, 1.0),
    "delay [s]": lambda found: shown(found.mean_delay, 1.0, 2),
}
"""The numbers of cells and of their maps, by their columns."""


def touched(cell: Cell) -> str:
    """Return the shares of the episodes with a contact of the moving car, by either rule."""
    found = cell.summary[MEASURED_CONTACTS]
    return " / ".join(f"{100 * (rule.moving.value or 0):.2f}" for rule in (found.disc, found.footprint))


OF_CELLS: dict[str, Callable[[Cell], str]] = {
    "moving car: disc / footprint %": touched,
    "preventable %": lambda cell: shown(cell.preventable_share),
}
"""The numbers of cells alone. The last one is the share of the replayed collisions that a careful human would have
avoided."""


def tables(cells: Sequence[Cell], console: Console) -> list[Table]:
    """Return the cells as a table, or as several with some columns each, so that none is wider than the console.

    Names of drivers and people stand in each of them. One number beside them may still be too wide.
    """
    columns = _columns(cells)
    parts: list[list[str]] = [[]]
    for column in columns:
        wider = table(cells, [*parts[-1], column])
        if parts[-1] and Measurement.get(console, console.options.update(width=WIDEST), wider).maximum > console.width:
            parts.append([])
        parts[-1].append(column)
    made = [table(cells, part) for part in parts]
    for one in made[1:]:
        one.title = None
    for one in made[:-1]:
        one.caption = None
    return made


def table(cells: Sequence[Cell], columns: Sequence[str]) -> Table:
    """Return the cells as a table with 95 % intervals; ``columns`` are keys of `OF_MAPS` and `OF_CELLS`."""
    several, multipliers = any(cell.by_map for cell in cells), len({cell.jaywalk_multiplier for cell in cells}) > 1
    made = Table(title=TITLE, box=SIMPLE, padding=(0, 1))
    for name in ("driver", "pedestrians"):
        made.add_column(name, overflow="fold")
    if multipliers:
        made.add_column("multiplier", justify="right")
    captions = [TOUCHED]
    if any(len(cell.by_map) > MOST_MAPS for cell in cells):
        captions.append(f"the {MOST_MAPS} maps with the most collisions; --json and --out have all")
    made.caption = "\n".join(captions)
    if several:
        made.add_column("map", overflow="fold")
    for name in columns:
        made.add_column(escape(name), justify="right", no_wrap=True)
    for cell in cells:
        observes = cell.driver_observes
        names = cell.driver + (f" ({observes})" if observes in PRIVILEGED_SETS else ""), cell.pedestrians
        extra = [f"{cell.jaywalk_multiplier:g}"] * multipliers
        shown_here = [(OF_MAPS | OF_CELLS)[name](cell) for name in columns]
        made.add_row(*map(escape, names), *extra, *["all"] * several, *map(escape, shown_here))
        for found in _shown_maps(cell):
            rates = [OF_MAPS[name](found) for name in columns if name in OF_MAPS]
            made.add_row("", "", *[""] * len(extra), *map(escape, (found.map, *rates)))
    return made


def _columns(cells: Sequence[Cell]) -> list[str]:
    """Return the columns of numbers: all, but the last only where collisions were replayed."""
    columns = [*OF_MAPS, *OF_CELLS]
    return columns if any(cell.counterfactuals for cell in cells) else columns[:-1]


def _shown_maps(cell: Cell) -> list[MapRates]:
    """Return the maps in the table: all in their order, or those with the most collisions."""
    if len(cell.by_map) <= MOST_MAPS:
        return list(cell.by_map)
    return sorted(cell.by_map, key=lambda found: -(found.collision_rate.value or 0))[:MOST_MAPS]
