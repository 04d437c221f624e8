"""The report's page in a browser: light and dark, wide, narrow and printed, for everybody."""

from __future__ import annotations

import pytest

from jaxwalk.report import write_report
from report.material import material

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    return write_report(tmp_path_factory.mktemp("report"), material(1))


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
