"""The built site (`make docs`), opened from disk: it searches, reads in dark and on a phone, and asks no other host."""

from __future__ import annotations

import pytest

from website.built_site import faults, home_size
from website.repository import ROOT

pytestmark = pytest.mark.long
SITE = ROOT / "build" / "site"
MAIN = (
    "index.html", "getting-started.html", "tutorials/my-driver.html", "tutorials/reading-the-evidence.html",
    "concepts.html", "glossary.html", "command-line.html", "metrics.html", "results.html", "reference/index.html",
    "reference/jaxwalk.html", "reference/commands.html",
)  # fmt: skip
"""Pages that are read most, and one of each kind."""
LIGHTEST = 300_000
"""What the home page may weigh, compressed and without its moving picture [bytes]."""
PHONE = {"width": 360, "height": 740}


@pytest.fixture(scope="module")
def site():
    if not (SITE / "index.html").is_file():
        pytest.skip("no site: make docs")
    return SITE


def test_links_and_hosts(site):
    assert faults(site) == []


def test_the_home_page_is_light(site):
    assert home_size(site) < LIGHTEST


@pytest.mark.parametrize("name", MAIN)
def test_nobody_is_shut_out(name, site, open_file, check_both_schemes):
    check_both_schemes(open_file(site / name))


@pytest.mark.parametrize("name", MAIN)
def test_a_phone_shows_the_whole_width(name, site, page, open_file):
    page.set_viewport_size(PHONE)
    open_file(site / name)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]


def test_the_search_finds_from_disk(site, open_file):
    page = open_file(site / "index.html")
    page.get_by_role("button", name="Search").first.click()
    page.locator("input[placeholder=Search]:visible").fill("predictive shield")
    page.wait_for_timeout(2000)  # the index is read, then searched
    page.keyboard.press("Enter")
    page.wait_for_url("**/*shield*.html*")
    assert "shield" in page.locator("h1").first.inner_text().lower()


def test_dark_mode_is_the_readers_choice_and_stays(site, open_file):
    page = open_file(site / "index.html")
    page.emulate_media(color_scheme="dark")
    page.reload()
    assert page.get_attribute("body", "data-md-color-scheme") == "slate"
    page.emulate_media(color_scheme="light")
    page.reload()
    assert page.get_attribute("body", "data-md-color-scheme") == "default"


def test_three_doors_lead_on(site, open_file):
    page = open_file(site / "index.html")
    for number, first in enumerate(("my-driver", "train-and-compare", "reading-the-evidence")):
        page.locator(".doors li").nth(number).locator("a").first.click()
        page.wait_for_url(f"**/tutorials/{first}.html")
        assert page.locator("h1").count() == 1
        page.go_back()


def test_the_picture_stands_still_for_who_wants_that(site, open_file):
    page = open_file(site / "index.html")  # the fixture asks for reduced motion
    assert page.evaluate("document.querySelector('img.moving').currentSrc").endswith("/images/episode.png")
