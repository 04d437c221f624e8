"""The page for raters in a browser: a rater starts it, answers, and saves a file that the analysis reads."""

from __future__ import annotations

import dataclasses

import pytest

from browser.pages import replay_document
from jaxwalk.raters import RatedPair, analyse, read_answers, write_rating_page
from raters.simulated import a_plan

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def plan():
    """Two drivers, whose clips are those of `browser.pages`: three rated pairs, and a check that "rash" fails."""
    found = a_plan(2, each=2)
    pairs = (RatedPair(7, 0, 1, 0.5), RatedPair(9, 1, 0, 0.5), RatedPair(217, 0, 1, 0.5), RatedPair(7, 1, 0, 0.0, "a"))
    return dataclasses.replace(found, drivers=("rash", "careful"), players=("rash", "careful"), pairs=pairs)


@pytest.fixture
def opened(plan, tmp_path, open_file, monkeypatch):
    monkeypatch.setattr("jaxwalk.raters.rating_page.LENGTH", 0.3)
    monkeypatch.setattr("jaxwalk.raters.rating_page.REPEATED", 1)
    write_rating_page(tmp_path / "rate.html", plan, replay_document())
    return open_file(tmp_path / "rate.html", "#seed=3")


def begin(page):
    page.check("[name=adult]")
    page.check("[name=consent]")
    page.click("[data-do=start]")


def test_a_rater_answers_and_saves(plan, opened, tmp_path):
    assert opened.is_disabled("[data-do=start]")
    assert "4 pairs of short films" in " ".join(opened.text_content("#start").split())
    begin(opened)
    for number in range(1, 5):
        opened.wait_for_function(f"document.querySelector('.at').textContent === '{number} of 4'")
        opened.wait_for_selector("[data-answer=left]:not([disabled])")
        # the rater prefers "careful", and knows it by its clip alone
        answer = opened.evaluate("rating.current")
        pair = plan.pairs[answer["pair"]]
        preferred = "a" if plan.players[pair.a] == "careful" else "b"
        opened.click(f"[data-answer={'left' if answer['left'] == preferred else 'right'}]")
    opened.wait_for_selector("#end:not([hidden])")
    with opened.expect_download() as saved:
        opened.click("a.save")
    path = tmp_path / "answers.json"
    saved.value.save_as(path)
    (file,) = read_answers([path], plan)
    assert opened.text_content(".rater") == file.rater
    assert saved.value.suggested_filename == f"answers-{file.rater}.json"
    first, last = file.answers[0], file.answers[-1]
    assert plan.pairs[first.pair].safer is None  # never a check first
    assert (last.repeat, last.pair, last.left) == (True, first.pair, "b" if first.left == "a" else "a")
    found = analyse(plan, [file], resamples=20)
    assert (found.drivers[0].driver, found.raters, found.answers, found.repeated) == ("careful", 1, 2, (1, 1))


def test_it_names_no_driver(opened):
    text = opened.text_content("#data")
    assert "rash" not in text and "careful" not in text
    assert '"scenario"' not in text


def test_keys_answer_and_pause(opened):
    begin(opened)
    opened.keyboard.press("1")  # too early
    opened.wait_for_selector("[data-answer=left]:not([disabled])")
    assert opened.text_content(".at") == "1 of 4"
    opened.focus("body")
    opened.keyboard.press(" ")
    assert opened.text_content("[data-do=pause]") == "Play"
    opened.keyboard.press("2")
    opened.wait_for_function("document.querySelector('.at').textContent === '2 of 4'")
    assert opened.evaluate("rating.answers[0].answer") == "equal"


def test_the_same_seed_gives_the_same_order(opened):
    shown = opened.evaluate("rating.shown")
    opened.reload()
    assert opened.evaluate("rating.shown") == shown
    assert len({one["pair"] for one in shown}) == 3


@pytest.mark.parametrize("width", [1100, 390])
def test_it_shuts_nobody_out(opened, check_both_schemes, width):
    opened.set_viewport_size({"width": width, "height": 800})
    check_both_schemes(opened)
    begin(opened)
    opened.wait_for_selector("[data-answer=left]:not([disabled])")
    check_both_schemes(opened)
    assert opened.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert opened.evaluate("document.querySelector('[data-answer=right]').getBoundingClientRect().bottom < innerHeight")
