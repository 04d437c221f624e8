"""The report's page in a browser: light and dark, wide, narrow and printed, for everybody."""

from __future__ import annotations

import dataclasses
import re

import pytest

from browser.pages import gallery_document, watched
from jaxwalk.report import write_report
from jaxwalk.report.figures import FIGURES
from report.material import material

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    return write_report(tmp_path_factory.mktemp("report"), material(1))


PAGES = 12
"""A printed report has at most as many pages."""


def renamed(found, names, people=("always-go", "learned", "gap-acceptance")):
    """Each of these drivers among each population, all with the numbers of the first."""
    return tuple(dataclasses.replace(found[0], driver=name, pedestrians=who) for name in names for who in people)


def many_drivers(count):
    """The material of a report on so many drivers, with 200 incidents."""
    one, names = material(1), [f"driver-{number}" for number in range(count)]
    gallery = gallery_document()
    for episode in gallery["episodes"]:
        episode["driver"] = {"rash": names[0], "careful": names[-1]}[episode["driver"]]
    found = watched(gallery)
    results = dataclasses.replace(
        one.results, cells=renamed(one.results.cells, names), over_seeds=renamed(one.results.over_seeds, names),
        paired=one.results.paired * 2 * count,
    )  # fmt: skip
    return dataclasses.replace(
        one, results=results, trainings=None, ablation=None, curves={}, subject=names[0], headline=tuple(names[:4]),
        gallery=dataclasses.replace(found, incidents=found.incidents * 50),
    )  # fmt: skip


@pytest.fixture(scope="module")
def of_many(tmp_path_factory):
    """A report, without figures, on two drivers with 200 incidents."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("jaxwalk.report.write.draw_all", lambda *_: dict.fromkeys(FIGURES, ""))
        return write_report(tmp_path_factory.mktemp("many"), many_drivers(2))


def test_the_first_screen_has_the_verdict_and_what_to_watch(of_many, page, open_file):
    page.set_viewport_size({"width": 1280, "height": 900})
    open_file(of_many)
    for text in (
        "cannot be judged",
        "How sure?",
        "It rests on",
        "Look at next",
        "Hit at 5.0 m/s",
        "What the model leaves",
    ):
        assert page.get_by_text(text).first.bounding_box()["y"] < 900, text
    page.click("[data-incident='0']")
    page.wait_for_selector("dialog[open] .stage canvas")
    assert page.text_content("dialog figcaption") == "driver-0 among always-go, scenario 7: collision after 4.0 s"


def test_the_contents_stay_in_view_and_say_where_one_is(of_many, page, open_file):
    for width in (1280, 390):
        page.set_viewport_size({"width": width, "height": 800})
        open_file(of_many)
        page.get_by_role("link", name="How the car drives").click()
        page.wait_for_function("scrollY > 1000")
        assert page.locator("nav.contents").bounding_box()["y"] >= 0
        page.wait_for_selector("nav a[aria-current]:has-text('How the car drives')")


def test_sections_fold_and_an_entry_unfolds_its_own(of_many, page, open_file):
    page.set_viewport_size({"width": 1280, "height": 900})
    open_file(of_many)
    page.click("text=Fold all sections")
    assert page.locator("details.section[open]").count() == 0
    page.get_by_role("link", name="How the car drives").click()
    page.wait_for_selector("#section-driving[open]")
    page.click("[data-fold]")  # folds the one that is open
    assert page.locator("details.section[open]").count() == 0


def test_two_hundred_incidents_stay_fluid(of_many, page, open_file):
    """No card's picture is drawn before it comes near the window, and none takes a noticeable while."""
    open_file(of_many)
    page.wait_for_selector(".incidents button")
    drawn = "document.querySelectorAll('.incidents canvas[width]').length"
    while page.locator(".more:visible").count():
        page.click(".more")
    assert page.locator(".incidents button").count() == 200
    assert page.evaluate(drawn) < 60
    took = page.evaluate(
        "(() => { const began = performance.now(); gallery.update(); return performance.now() - began; })()"
    )
    assert took < 250  # [ms], for all 200 cards
    page.locator(".incidents button").last.scroll_into_view_if_needed()
    page.wait_for_function("document.querySelector('.incidents li:last-child canvas').hasAttribute('width')")


@pytest.mark.parametrize("drivers", [1, 2, 20])
def test_it_prints_on_twelve_pages(drivers, tmp_path, page, open_file):
    open_file(write_report(tmp_path, many_drivers(drivers)))
    printed = page.pdf(prefer_css_page_size=True)
    assert 1 <= len(re.findall(rb"/Type\s*/Page[^s]", printed)) <= PAGES


def test_the_papers_experiment_prints_on_twelve_pages(tmp_path, page, open_file):
    open_file(write_report(tmp_path, material(3)))
    assert len(re.findall(rb"/Type\s*/Page[^s]", page.pdf(prefer_css_page_size=True))) <= PAGES


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1100, 390])
def test_it_shuts_nobody_out(report, page, open_file, check_access, scheme, width):
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size({"width": width, "height": 800})
    open_file(report)
    check_access(page)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_text_in_figures_follows_the_page(report, page, open_file):
    open_file(report)
    colours = []
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        label = page.get_by_text("collisions [%]").first
        colours.append(label.evaluate("text => getComputedStyle(text).fill"))
    assert colours == ["rgb(28, 28, 28)", "rgb(232, 232, 230)"]


@pytest.mark.parametrize("width", [1100, 390])
def test_the_smallest_print_is_large_enough_to_read(report, page, open_file, width):
    page.set_viewport_size({"width": width, "height": 800})
    open_file(report)
    heights = page.locator("figure .chart text").evaluate_all(
        "all => all.map(text => text.getBoundingClientRect().height)"
    )
    assert min(heights) > 9


def test_what_is_too_wide_is_scrolled_with_the_keyboard(report, page, open_file):
    page.set_viewport_size({"width": 390, "height": 800})
    open_file(report)
    region = page.get_by_role("region", name="Table: Every driver among every population")
    region.focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_function("region => region.scrollLeft > 0", arg=region.element_handle())
    assert region.evaluate("region => region === document.activeElement")


def test_printed_it_is_dark_on_white_and_nothing_is_cut_off(report, page, open_file):
    page.emulate_media(media="print", color_scheme="dark")
    page.set_viewport_size({"width": 680, "height": 960})  # A4 less its margins
    open_file(report)
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert page.evaluate("getComputedStyle(document.body).color") == "rgb(0, 0, 0)"
    cut = page.locator(".scroll").evaluate_all(
        "all => all.filter(box => box.scrollWidth > box.clientWidth + 1).map(box => box.ariaLabel)"
    )
    assert cut == []
