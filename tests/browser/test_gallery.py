"""From a collision rate to watching the worst avoidable collision, as a reader of the report would."""

from __future__ import annotations

import dataclasses

import pytest

from browser.pages import gallery_document, watched
from jaxwalk.report import write_report
from jaxwalk.report.figures import FIGURES
from report.material import material

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """A report, without figures, whose gallery has two drivers of the report's own."""
    gallery = gallery_document()
    for episode in gallery["episodes"]:
        episode["driver"] = {"rash": "co-trained", "careful": "single-agent"}[episode["driver"]]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("jaxwalk.report.write.draw_all", lambda *_: dict.fromkeys(FIGURES, ""))
        contents = dataclasses.replace(material(1), gallery=watched(gallery))
        return write_report(tmp_path_factory.mktemp("report"), contents)


@pytest.fixture
def opened(file, open_file):
    page = open_file(file)
    page.wait_for_selector(".incidents button")
    return page


def cards(page):
    """What is said of each incident."""
    return page.locator(".incidents .how").all_text_contents()


def test_three_clicks_to_the_worst_avoidable_collision(opened):
    opened.click("a[data-cell='co-trained among always-go']")
    assert len(cards(opened)) == 2
    opened.click("text=avoidable by the driver (1)")
    assert cards(opened) == ["Hit at 5.0 m/s, 20 % risk of serious injury, avoidable by the driver"]
    opened.click(".incidents button")
    opened.wait_for_selector("dialog[open] .stage canvas")
    assert opened.text_content("dialog figcaption") == "co-trained among always-go, scenario 7: collision after 4.0 s"
    assert float(opened.text_content("dialog .clock").split(" s")[0]) == 1.0  # 3 s before it


def test_the_worst_come_first_and_near_misses_last(opened):
    said = cards(opened)
    assert [text.split(",")[0] for text in said] == ["Hit at 5.0 m/s"] * 3 + ["Near miss: 0.4 s to collision"]
    assert [text.split(" % risk")[0][-2:] for text in said[:3]] == ["30", "20", "10"]
    assert opened.text_content(".count") == "3 collisions and 1 near miss. A click plays one."


def test_filters_and_sorting(opened):
    opened.select_option("[name=kind]", "near miss")
    assert len(cards(opened)) == 1
    opened.select_option("[name=contact]", "jaywalk")
    assert cards(opened) == []
    opened.select_option("[name=kind]", "collision")
    assert len(cards(opened)) == 3
    opened.select_option("[name=sort]", "avoidability")
    assert [text.rsplit(", ")[-1] for text in cards(opened)] == [
        "avoidable by the driver", "avoidable by the driver", "avoidable by either",
    ]  # fmt: skip
    opened.select_option("[name=sort]", "scenario")
    assert "scenario 7" in opened.text_content(".incidents li:first-child")
    opened.select_option("[name=cell]", "single-agent among always-go")
    assert len(cards(opened)) == 1


def test_situations_are_counted_and_chosen(opened):
    chips = opened.locator(".situations button")
    assert chips.all_text_contents() == [
        "jaywalker from the right, car going straight (3)", "crosswalk user from the right, car going straight (1)",
    ]  # fmt: skip
    chips.last.click()
    assert len(cards(opened)) == 1
    assert opened.locator(".situations button[aria-pressed=true]").count() == 1
    opened.locator(".situations button[aria-pressed=true]").click()
    assert len(cards(opened)) == 4


def test_time_runs_as_fast_as_it_should_however_often_one_goes_on(browser, file):
    page = browser.new_page()
    page.goto(file.as_uri())
    page.click(".incidents button")
    for _ in range(3):
        page.wait_for_timeout(100)
        page.keyboard.press("n")
        page.wait_for_timeout(100)
        page.keyboard.press("b")
    page.wait_for_timeout(100)
    page.evaluate("() => { gallery.player.rate = 0.1; gallery.player.seek(0); window.began = performance.now(); }")
    page.wait_for_timeout(1500)
    ratio = page.evaluate("gallery.player.time / ((performance.now() - began) / 1000)")
    page.close()
    assert 0.03 < ratio < 0.13  # a tenth of real time: twice as much were two clocks


def test_a_drag_that_ends_outside_closes_nothing(opened):
    opened.click(".incidents button")
    opened.wait_for_selector("dialog[open] .stage canvas")
    box = opened.locator("dialog .strips").bounding_box()
    opened.mouse.move(box["x"] + 50, box["y"] + 50)
    opened.mouse.down()
    opened.mouse.move(2, 2, steps=4)
    opened.mouse.up()
    assert opened.is_visible("dialog")
    opened.mouse.click(2, 2)
    opened.wait_for_selector("dialog", state="hidden")


def test_an_address_of_nothing_is_said(file, open_file):
    page = open_file(file, "#episode=3")
    page.wait_for_selector("text=This page doesn't have the episode of the link.")
    assert not page.is_visible("dialog")


def test_pictures_are_drawn(opened):
    opened.locator(".incidents canvas").first.scroll_into_view_if_needed()
    opened.wait_for_timeout(400)
    blank = "c => !c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((v, i, d) => v !== d[i % 4])"
    assert not opened.eval_on_selector(".incidents canvas", blank)


def test_keys_go_from_incident_to_incident_and_close(opened):
    opened.click(".incidents button")
    opened.wait_for_selector("dialog[open] .stage canvas")
    first = opened.text_content("dialog figcaption")
    opened.select_option("[name=beside]", index=0)
    opened.focus("dialog [name=beside]")
    opened.keyboard.press("n")  # is the list's own key
    assert opened.text_content("dialog figcaption") == first
    opened.focus("dialog [data-do=toggle]")
    opened.keyboard.press("n")
    opened.wait_for_function("before => document.querySelector('dialog figcaption').textContent !== before", arg=first)
    opened.click("[data-go='-1']")
    opened.wait_for_function("before => document.querySelector('dialog figcaption').textContent === before", arg=first)
    opened.wait_for_function("location.hash.includes('episode=')")
    opened.keyboard.press("Escape")
    opened.wait_for_selector("dialog", state="hidden")
    assert opened.evaluate("location.hash") == ""


def test_an_address_opens_the_moment(file, open_file):
    page = open_file(file, "#episode=217&t=2.3&driver=single-agent")
    page.wait_for_selector("dialog[open] .stage canvas")
    assert page.text_content("dialog .clock").startswith("2.3 s")
    page.click("[data-go=close]")
    page.wait_for_selector("dialog", state="hidden")


def test_the_same_scenario_under_another_driver(opened):
    opened.click(".incidents button")
    opened.wait_for_selector("dialog[open] .stage canvas")
    opened.select_option("[name=beside]", index=1)
    opened.wait_for_function("document.querySelectorAll('dialog .stage').length === 2")
    scenarios = [text.split("scenario ")[1][:3] for text in opened.locator("dialog figcaption").all_text_contents()]
    assert scenarios == ["217", "217"]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nobody_is_shut_out(opened, check_access, scheme):
    opened.emulate_media(color_scheme=scheme)
    check_access(opened)
    opened.click(".incidents button")
    opened.wait_for_selector("dialog[open] .stage canvas")
    check_access(opened)
