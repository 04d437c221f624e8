"""The page of a failure search: the grid of encounters, coloured by who would have avoided a failure, and replays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from jaxwalk.search.found_failures import FoundFailure, SearchResults
from jaxwalk.search.grid import GRID, SHAPE, SIDES, SPEEDS, TIMES, part_of_axis
from jaxwalk.sim.crossing_kind import CONTACTS
from jaxwalk.viewer.filled_page import filled_in
from jaxwalk.viewer.replay import as_script, gallery_style, player_html, player_script
from jaxwalk.wording import counted
from jaxwalk.writing import write_whole

JUDGED = {
    "human": "a careful human would have avoided it",
    "oracle": "only one who knows the future, or brakes fully at once, would have avoided it",
    "unavoidable": "nobody would have avoided it",
}
"""Judgements in words."""


def said(failure: FoundFailure) -> str:
    """Return a failure in a sentence."""
    seen = "while the car stood" if failure.time is None else f"{failure.time:.1f} s before"
    how = f"at {failure.speed:.0f} km/h, {failure.contact}, {failure.words.side}; first visible {seen}"
    few = "" if failure.people is None else f"; {failure.people} of the people suffice"
    return f"{failure.map}: hit {how}; {JUDGED[failure.judged]}; percentile {failure.percentile:.1f}{few}"


@dataclass(frozen=True)
class ShownGrid:
    """The part of the grid in which something failed."""

    times: tuple[str, ...]
    """Groups of columns: the times with a failure [s]."""
    rows: tuple[tuple[str, str, tuple[FoundFailure | None, ...]], ...]
    """Contact and side with a failure, and a failure or None for each of these times and each speed."""
    empty_times: tuple[str, ...]
    """The times without any failure."""
    empty_rows: int
    """Number of contacts and sides without any."""

    @property
    def left_out(self) -> str:
        """Return in a sentence what isn't shown; empty if everything is."""
        times = f"first visible {_either(self.empty_times)} seconds before" if self.empty_times else ""
        rows = f"{counted(self.empty_rows, 'row')} of contact and side" if self.empty_rows else ""
        parts = [part for part in (times, rows) if part]
        return f"Left out, because nothing failed there: {'; '.join(parts)}." if parts else ""


def _either(names: Sequence[str]) -> str:
    """Return names in words, as in ``a``, ``a or b``, and ``a, b, or c``."""
    *others, last = names
    return last if not others else f"{', '.join(others)}{',' * (len(others) > 1)} or {last}"


def shown_grid(results: SearchResults) -> ShownGrid:
    """Return the grid without times and without rows in which nothing failed."""
    rows = _grid_rows(results)
    speeds = SHAPE[1]
    groups = [[one for _, _, cells in rows for one in cells[first : first + speeds]] for first in _firsts()]
    full = [time for time, group in enumerate(groups) if any(group)]
    names = [part_of_axis(TIMES, time) for time in range(SHAPE[2])]
    kept = [
        (contact, side, tuple(cells[speeds * time + speed] for time in full for speed in range(speeds)))
        for contact, side, cells in rows
        if any(cells)
    ]
    empty = tuple(name for time, name in enumerate(names) if time not in full)
    return ShownGrid(tuple(names[time] for time in full), tuple(kept), empty, len(rows) - len(kept))


def _firsts() -> range:
    """Return the first column of each time."""
    return range(0, SHAPE[1] * SHAPE[2], SHAPE[1])


def _grid_rows(results: SearchResults) -> list[tuple[str, str, list[FoundFailure | None]]]:
    """Return a row for each contact and side: their names, and a failure or None for each time and speed."""
    by_cell: Mapping[int, FoundFailure] = {one.cell: one for one in results.failures}
    rows = []
    for kind in CONTACTS:
        for side, name in enumerate(SIDES):
            places = [
                ((int(kind) * SHAPE[1] + speed) * SHAPE[2] + time) * SHAPE[3] + side
                for time in range(SHAPE[2])
                for speed in range(SHAPE[1])
            ]
            rows.append((kind.word, name, [by_cell.get(place) for place in places]))
    return rows


def write_search_page(path: Path, results: SearchResults, document: dict[str, Any]) -> None:
    """Write the page. ``document`` has the episodes of the first failures, in their order."""
    template = resources.files("jaxwalk.report").joinpath("search_page.html").read_text(encoding="utf-8")
    page = filled_in(
        template,
        results=results, shown=shown_grid(results), said=said, judged=JUDGED, grid=GRID,
        times=[part_of_axis(TIMES, part) for part in range(SHAPE[2])],
        speeds=[part_of_axis(SPEEDS, part) for part in range(SHAPE[1])],
        watched=len(document["episodes"]), css=gallery_style(), player=player_html(), script=player_script(),
        data=as_script(document),
    )  # fmt: skip
    write_whole(path, page)
