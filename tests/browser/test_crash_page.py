"""The page of crash tests in a real browser: cells tell what happened, and play it."""

from __future__ import annotations

import pytest

from browser.pages import replay_document
from jaxwalk.evaluation.crash_outcomes import CrashOutcome
from jaxwalk.evaluation.crash_results import CarUnderTest, CrashResults, DriverUnderTest
from jaxwalk.evaluation.document_parts import PolicyOrigin
from jaxwalk.provenance import Provenance
from jaxwalk.report.crash_page import write_crash_page

pytestmark = pytest.mark.long
CAR = CarUnderTest(4.5, 1.8, 3.0, 7.6, 1.0, 0.25, 0.1, 0.01)


def outcome(number, test, speed, result, **more):
    known = {"impact": None, "hit_point": None, "slowest": 0.0, "hardest": 7.6, "aside": 0.0, "ends": 4.0}
    known |= {"passed": None, "touched_later": False, "no_brake": False, "variant": None, "layer": "standard"}
    return CrashOutcome(scenario=number, test=test, speed=speed, result=result, **(known | more))


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Two drivers in three runs: the episodes are those of the pages of replays."""
    rash = (
        outcome(7, "crossing", 20.0, "slowed", impact=17.4, hit_point=40.0, passed=False),
        outcome(9, "crossing", 40.0, "unslowed", impact=40.0),
        outcome(217, "nobody", 20.0, "braked", no_brake=True, passed=False),
    )
    careful = (
        outcome(7, "crossing", 20.0, "avoided", passed=True, aside=1.25),
        outcome(9, "crossing", 40.0, "not met"),
        outcome(217, "nobody", 20.0, "kept", no_brake=True, passed=True),
    )
    drivers = (
        DriverUnderTest("rash", PolicyOrigin("rash", "rule", None), False, 30.0, rash),
        DriverUnderTest("careful", PolicyOrigin("careful", "rule", None), True, None, careful),
    )
    made = Provenance(None, "a machine", {"python": "3"})
    results = CrashResults("mine", "My tests", "me", ("ours <i>",), ("standard",), "0" * 16, CAR, drivers, made)
    path = tmp_path_factory.mktemp("crash") / "crashtest.html"
    write_crash_page(path, results, replay_document())
    return path


def test_cells_say_what_happened(file, open_file):
    page = open_file(file)
    words = [button.inner_text() for button in page.query_selector_all("td button")]
    assert words == ["17 ✗", "40", "brakes ✗", "avoids ↔ ✓", "not met", "keeps ✓"]
    assert page.get_attribute("td button", "aria-label") == (
        "rash, crossing at 20 km/h: hit, at 17.4 km/h, 40 % of the front; fails"
    )
    assert "beyond" in page.query_selector_all("td button")[1].get_attribute("class")
    assert "beyond" not in page.query_selector_all("td button")[0].get_attribute("class")
    assert page.is_visible("text=no official test, no score")


def test_a_cell_plays_its_run_and_closes(file, open_file):
    page = open_file(file)
    page.click("td button >> nth=3")
    page.wait_for_selector("dialog .stage canvas")
    assert (
        page.text_content("#watched")
        == "careful, crossing at 20 km/h: avoids the contact; 1.2 m beside its route; passes"
    )
    assert page.text_content("figcaption").startswith("careful among always-go, scenario 7")
    page.click("text=Close")
    assert not page.is_visible("dialog")


def test_a_moment_of_a_run_has_an_address(file, open_file):
    page = open_file(file, "#episode=217&t=2.3&driver=careful")
    page.wait_for_selector("dialog .stage canvas")
    assert page.text_content("#watched").startswith("careful, nobody at 20 km/h: keeps its speed")


def test_nobody_is_shut_out_of_the_tests(file, open_file, check_both_schemes):
    check_both_schemes(open_file(file))
