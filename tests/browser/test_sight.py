"""Who is in sight, in a real browser: pale people, rings where they were last seen, parked vehicles, switch and key."""

from __future__ import annotations

import pytest

from browser.pages import replay_document, sighted_document
from jaxwalk.viewer import replay_page

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def sighted(tmp_path_factory):
    path = tmp_path_factory.mktemp("sighted") / "replay.html"
    replay_page(sighted_document(), path, title="Replay")
    return path


def test_who_is_in_sight_has_a_switch_and_a_key_where_not_everybody_is(sighted, open_file):
    page = open_file(sighted, "#episode=7&t=2")
    page.wait_for_selector("text=where it was last seen")
    assert page.is_visible("text=parked vehicle")
    marked = pixels(page)
    page.keyboard.press("s")
    assert not page.is_checked("[name=sight]")
    assert pixels(page) != marked
    page.click("[name=sight]")
    assert pixels(page) == marked


def test_where_everybody_is_in_sight_nothing_is_offered(tmp_path, open_file):
    replay_page(replay_document(), tmp_path / "replay.html", title="Replay")
    page = open_file(tmp_path / "replay.html")
    page.wait_for_selector(".stage canvas")
    assert not page.is_visible("[name=sight]")
    assert not page.is_visible("text=parked vehicle")


def pixels(page):
    """The drawing, as text that changes with what is drawn."""
    return page.eval_on_selector(".stage canvas", "canvas => canvas.toDataURL()")


def test_nobody_is_shut_out_where_not_everybody_is_in_sight(sighted, open_file, check_both_schemes):
    page = open_file(sighted, "#episode=7&t=2")
    page.wait_for_selector("text=where it was last seen")
    check_both_schemes(page)


def test_who_is_not_perceived_is_said_in_words(sighted, open_file):
    page = open_file(sighted, "#episode=7&t=3.7")
    page.wait_for_selector(".stage canvas")
    assert "not perceived by the car" in page.get_attribute(".stage canvas", "aria-label")
    page.keyboard.press("ArrowRight")
    assert "not perceived" not in page.get_attribute(".stage canvas", "aria-label")


RINGS = """
window.rings = [];
const drawn = CanvasRenderingContext2D.prototype.arc;
CanvasRenderingContext2D.prototype.arc = function (...given) {
  rings.push([given[0], given[1], this.globalAlpha]);
  return drawn.apply(this, given);
};
"""
"""Writes down where circles are drawn, and how opaque."""


def watched(page, open_file, file, place):
    """A function that presses a key and returns the circles that are drawn then: x, y and opacity of each."""
    page.add_init_script(RINGS)
    open_file(file, place).wait_for_selector(".stage canvas")

    def circles(key):
        page.evaluate("rings = []")
        page.keyboard.press(key)
        return {tuple(circle) for circle in page.evaluate("rings")}

    return circles


def test_a_ring_stays_where_somebody_was_last_seen_and_fades(page, sighted, open_file):
    circles = watched(page, open_file, sighted, "#episode=7&t=1")

    def faint(key):
        return {circle for circle in circles(key) if circle[2] < 1}

    (soon,) = faint("ArrowRight")
    (late,) = faint("Shift+ArrowRight")
    assert soon[:2] == late[:2]
    assert soon[2] == pytest.approx(1 - 0.2 / 3)
    assert late[2] == pytest.approx(1 - 1.2 / 3)
    assert not faint("End")


def test_what_the_car_does_not_perceive_is_not_drawn_as_its_view(page, sighted, open_file):
    """With H, only what the car knows is left: nobody whom it doesn't perceive, but where it last saw them."""
    circles = watched(page, open_file, sighted, "#episode=7&t=2")
    assert len(circles("h")) == 2, "a ring, and the person who is in sight"
    page.keyboard.press("s")
    assert len(circles("l")) == 1, "that person"
