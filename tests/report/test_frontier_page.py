"""The page of contacts against delay, and its plot."""

from __future__ import annotations

import pytest

from evaluation.test_frontier_scores import driver
from jaxwalk.evaluation.document_parts import PolicyOrigin
from jaxwalk.evaluation.frontier_scores import Contender, FrontierScores, FrontierSuite
from jaxwalk.provenance import Provenance
from jaxwalk.report.figures.frontier import SIGNS
from jaxwalk.report.figures.frontier_plot import draw_frontiers
from jaxwalk.report.frontier_page import frontier_page

LAZY = FrontierScores(Contender("lazy", "lazy"), (), (None,) * 400, goals=0, timeouts=400)
HARD = FrontierSuite(
    "town", "always-go", "0123456789abcdef",
    (driver("clearance 1 m", 80, 1.0), driver("clearance 2 m", 10, 4.0), driver("bad", 80, 6.0),
     driver("oracle", 0, 0.5, hidden=True)),
)  # fmt: skip
OPEN = FrontierSuite("paper", "always-go", "abcdef", (driver("a", 3, 2.0), driver("b", 1, 1.9), LAZY))
ORIGINS = [PolicyOrigin("clearance", "rule", None), PolicyOrigin("bad", "policy file", "0123")]


@pytest.fixture(scope="module")
def page():
    made = Provenance(commit="abc123", hardware="an abacus", versions={})
    return frontier_page([HARD, OPEN], seed=7, origins=ORIGINS, made=made)


def test_who_is_dominated_is_said_in_words(page):
    assert "**town.** Not dominated: clearance 1 m, clearance 2 m. Cannot be judged: nobody." in page
    by = "- bad is dominated by clearance 2 m (-17.50 [-21."
    assert by in page and "points of contacts, -2.00 [" in page
    assert "**paper.** Not dominated: nobody for certain. Cannot be judged: a, b, lazy." in page


def test_the_tables(page):
    assert "| clearance | predicted clearance that it keeps | 0.25, 0.5, 1, 2, 4 m | 1 |" in page
    assert "| bad | 20.0 [16.4, 24.2] | 6.00 [5.96, 6.04] | 80.0 [75.8, 83.6] |" in page
    assert "| dominated by clearance 2 m |" in page
    assert "| oracle | 0.00 [0.00, 0.92] | 0.50 [" in page and page.count("| – |") == 2
    assert "| cannot be judged against b and" not in page and "cannot be judged against a, b |" in page
    assert "400 scenarios of seed 7 in each suite, among always-go; commit abc123, an abacus." in page
    assert "nan" not in page and "![Contacts against delay in town](frontier-town.svg)" in page
    tables = [part.splitlines() for part in page.split("\n\n") if part.startswith("| ")]
    assert len(tables) == 3
    for lines in tables:
        assert len({line.count(" | ") for line in lines}) == 1, lines[0]


def test_a_knob_that_nobody_turned_is_not_explained():
    made = Provenance(commit="abc123", hardware="an abacus", versions={})
    unturned = FrontierSuite("town", "always-go", "0123456789abcdef", (driver("clearance", 8, 1.0),))
    assert "## The knobs" not in frontier_page([unturned], seed=7, origins=ORIGINS, made=made)


def test_the_plots_are_drawn_and_the_same_each_time(tmp_path):
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        draw_frontiers([HARD, OPEN], tmp_path / folder)
    files = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert files == [f"frontier-{suite}.{kind}" for suite in ("paper", "town") for kind in ("png", "svg")]
    svg = (tmp_path / "a" / "frontier-town.svg").read_text()
    assert svg == (tmp_path / "b" / "frontier-town.svg").read_text()
    for text in ("clearance", "oracle", "mean delay [s]", "town, among always-go"):
        assert text in svg


def test_no_two_of_24_drivers_have_the_same_sign():
    assert len(set(SIGNS)) == len(SIGNS) == 24
