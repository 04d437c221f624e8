"""The page and the table of a failure search: what is left out where nothing failed, and names with units."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest

from browser.pages import replay_document
from jaxwalk.evaluation.document_parts import PolicyOrigin, StreetOrigin
from jaxwalk.maps import MapText
from jaxwalk.provenance import Provenance
from jaxwalk.report.search_page import shown_grid, write_search_page
from jaxwalk.search.found_failures import FoundFailure, SearchResults
from jaxwalk.search.grid import CELLS, SHAPE
from jaxwalk.search.hunt import Progressed
from jaxwalk.sim.sim_config import WORLDS


def results(*cells):
    """What a search found: a failure in each of these cells, given as contact, speed, time and side."""
    numbers = [int(np.ravel_multi_index(cell, SHAPE)) for cell in cells]
    failures = tuple(
        FoundFailure(scenario, cell, "jaywalk", 25.0, 0.5, -3.0, "paper", 2, 40.0, "human", "oracle")
        for scenario, cell in enumerate(numbers)
    )
    who = PolicyOrigin("mine", "rule", None), PolicyOrigin("always-go", "rule", None)
    street = StreetOrigin((MapText("paper", "0" * 16),), WORLDS["paper"])
    log = (Progressed(100, 5, len(failures)),)
    return SearchResults(
        *who, "map-elites", 0, log, failures, "0" * 16, street, Provenance(None, "a machine", {"python": "3"})
    )


def test_times_and_rows_without_a_failure_are_left_out_and_named():
    found = shown_grid(results((2, 2, 0, 3), (2, 4, 2, 3)))
    assert found.times == ("0 to 1", "2 to 3")
    ((contact, side, cells),) = found.rows
    assert (contact, side) == ("jaywalk", "front, middle")
    assert [place for place, one in enumerate(cells) if one] == [2, 9]  # five speeds for each time
    assert found.left_out == (
        "Left out, because nothing failed there: first visible 1 to 2, 3 to 4, or 4 and more seconds before; 20 "
        "rows of contact and side."
    )


@pytest.mark.parametrize(
    ("times", "said"),
    [((0, 1, 2, 3), "4 and more"), ((0, 1, 2), "3 to 4 or 4 and more"), ((4,), "0 to 1, 1 to 2, 2 to 3, or 3 to 4")],
)
def test_times_without_a_failure_are_a_sentence(times, said):
    found = shown_grid(results(*((2, 2, time, 3) for time in times))).left_out
    assert found.startswith(f"Left out, because nothing failed there: first visible {said} seconds before; ")


def test_the_page_says_what_first_visible_is(tmp_path):
    write_search_page(tmp_path / "search.html", results((2, 2, 0, 3)), replay_document())
    text = (tmp_path / "search.html").read_text(encoding="utf-8")
    assert "If the car stood then, this counts as 4 and more seconds. Left out, because nothing failed there: " in text


def test_a_full_grid_leaves_nothing_out():
    every = [tuple(map(int, np.unravel_index(n, SHAPE))) for n in range(CELLS // SHAPE[0], CELLS)]
    found = shown_grid(results(*every))
    assert (len(found.times), len(found.rows), found.left_out) == (SHAPE[2], 21, "")


def test_the_tables_columns_have_units_and_its_cells_are_words():
    (row,) = csv.DictReader(io.StringIO(results((2, 2, 0, 3)).to_csv()))
    assert row["cell"] == str(np.ravel_multi_index((2, 2, 0, 3), SHAPE))
    assert row["cell_in_words"].startswith("contact with somebody on a jaywalk at 20 to 30 km/h, at the middle")
    assert (row["speed_km_h"], row["first_visible_s_before"], row["bearing_deg"]) == ("25.000", "0.500", "-3.000")
    assert row["people"] == "" and "speed" not in row


@pytest.mark.long
def test_the_grid_stays_inside_its_box(tmp_path, open_file):
    every = [tuple(map(int, np.unravel_index(n, SHAPE))) for n in range(CELLS // SHAPE[0], CELLS)]
    write_search_page(tmp_path / "search.html", results(*every), replay_document())
    page = open_file(tmp_path / "search.html")
    page.set_viewport_size({"width": 1000, "height": 800})
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate("(box => box.scrollWidth > box.clientWidth)(document.querySelector('.scroll'))")
