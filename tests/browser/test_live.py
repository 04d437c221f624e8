"""The page of `jaxwalk live` in a browser: it plays, is driven by hand, saves, and shuts nobody out."""

from __future__ import annotations

import pytest

from jaxwalk.live.live_offer import offer_of
from jaxwalk.live.live_session import LiveSession
from jaxwalk.runs.contestants import contestant
from jaxwalk.scenarios.archive_file import read_archive
from jaxwalk.sim.suites import Where
from live.live_fakes import serving

COMPILED = 120_000
"""Longest time to wait for a simulation to be compiled [ms]."""


@pytest.fixture
def opened(browser, tmp_path):
    """The page on a phone; the test fails if an error was met, or anybody but the server was asked."""
    offer = offer_of(["route-follower"], ["always-go"], Where())
    with serving(lambda: LiveSession(offer, tmp_path / "saved", contestant)) as (_, address):
        context = browser.new_context(viewport={"width": 390, "height": 844}, reduced_motion="reduce")
        page, wrong = context.new_page(), []
        page.on("console", lambda said: wrong.append(said.text) if said.type == "error" else None)
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("request", lambda asked: None if asked.url.startswith(address) else wrong.append(asked.url))
        page.on("websocket", lambda one: None if one.url == f"ws{address[4:]}socket" else wrong.append(one.url))
        page.goto(address)
        page.wait_for_selector("[data-do=toggle]:not([disabled])", timeout=COMPILED)
        yield page
        context.close()
    assert not wrong, "\n".join(wrong)


def shows(page, where, text):
    """Wait until a part of the page has this text. (The page's own rules forbid to evaluate strings in it.)"""
    page.locator(where).filter(has_text=text).wait_for()


def test_a_scenario_is_played_driven_and_saved(opened, tmp_path, check_both_schemes):
    page = opened
    shows(page, ".said", "Ready")
    check_both_schemes(page)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")

    page.keyboard.press(".")  # a step
    shows(page, ".clock", "0.1 s")
    page.select_option("[name=rate]", "8")
    page.focus("canvas")
    page.keyboard.press(" ")
    shows(page, ".said", "Playing")
    page.keyboard.down("ArrowDown")  # takes over, and brakes
    shows(page, "figcaption", "You drive")
    shows(page, ".clock", ", 0 km/h")
    page.keyboard.up("ArrowDown")
    page.keyboard.press("t")
    shows(page, "figcaption", "route-follower drives")
    page.keyboard.press(" ")
    shows(page, ".said", "Paused")

    page.fill("[name=number]", "3")
    page.keyboard.press("Enter")
    shows(page, ".said", "Ready")
    page.focus("[name=people]")
    page.keyboard.press("ArrowLeft")
    shows(page, "[name=people-said]", "11 of 12")
    page.click("[data-do=save]")
    shows(page, ".saved", "--scenarios")
    (path,) = (tmp_path / "saved").glob("*.safetensors")
    kept = read_archive(path)
    assert (kept.seed, kept.keys.tolist(), int(kept.present.sum())) == (0, [3], 11)


def test_arrow_keys_drive_and_turn_no_dial_that_was_pointed_at(opened):
    page = opened
    shows(page, ".said", "Ready")
    page.locator("[name=max_speed]").click()  # in its middle
    turned = page.locator("[name=max_speed-said]").text_content()
    shows(page, ".said", "Ready")
    for key in ("ArrowUp", "ArrowLeft"):
        page.keyboard.press(key)
    shows(page, "figcaption", "You drive")
    assert page.locator("[name=max_speed-said]").text_content() == turned != "30 km/h"

    page.keyboard.press("t")
    page.locator("[name=driver]").click()
    page.select_option("[name=driver]", "clearance")
    shows(page, "figcaption", "clearance drives")
    page.keyboard.press("ArrowDown")
    shows(page, "figcaption", "You drive")
    assert page.locator("[name=driver]").input_value() == "clearance"
