"""The page of a failure search: the grid of encounters, coloured by who would have avoided a failure, and replays."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from jaxwalk.search.found_failures import FoundFailure, SearchResults
from jaxwalk.search.grid import GRID, SHAPE, SIDES, SPEEDS, TIMES, part_of_axis
from jaxwalk.sim.crossing_kind import CONTACTS
from jaxwalk.viewer.filled_page import filled_in
from jaxwalk.viewer.replay import as_script, gallery_style, player_html, player_script
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


def grid_rows(results: SearchResults) -> list[tuple[str, str, list[FoundFailure | None]]]:
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
        results=results, rows=grid_rows(results), said=said, judged=JUDGED, grid=GRID,
        times=[part_of_axis(TIMES, part) for part in range(SHAPE[2])],
        speeds=[part_of_axis(SPEEDS, part) for part in range(SHAPE[1])],
        watched=len(document["episodes"]), css=gallery_style(), player=player_html(), script=player_script(),
        data=as_script(document),
    )  # fmt: skip
    write_whole(path, page)
