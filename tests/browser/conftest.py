"""Pages opened from disk in a real Chromium, which must not complain, reach for a network, or shut anybody out."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
"""What Chromium is called on the PATH."""
FROM_DISK = ("file:", "data:", "blob:")
"""Addresses that need no network."""

NO_PRELOAD = {"preload": False}
"""Axe would read style sheets anew, which no page from disk may."""


def _executable(playwright) -> str:
    """Where Chromium is: what JAXWALK_CHROMIUM says, else the PATH, else the one that Playwright downloaded."""
    named = os.environ.get("JAXWALK_CHROMIUM")
    found = named or next(filter(None, map(shutil.which, NAMES)), playwright.chromium.executable_path)
    if not Path(found).is_file():
        if named:
            pytest.fail(f"JAXWALK_CHROMIUM names {named}, which is no file")
        pytest.skip(f"no Chromium: none of {', '.join(NAMES)} is on the PATH; name one in JAXWALK_CHROMIUM")
    return found


@pytest.fixture(scope="module")
def browser():
    """A headless Chromium. (Not for the whole session: while Playwright runs, nobody else can call `asyncio.run`.)"""
    sync_api = pytest.importorskip("playwright.sync_api", reason="no playwright: pip install jaxwalk[dev]")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=_executable(playwright), args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture
def page(browser):
    """An empty page; the test fails if, by its end, an error was met or anything but the disk was asked."""
    context = browser.new_context(viewport={"width": 1100, "height": 900}, reduced_motion="reduce")
    page = context.new_page()
    wrong: list[str] = []
    page.on("console", lambda message: wrong.append(f"console: {message.text}") if message.type == "error" else None)
    page.on("pageerror", lambda error: wrong.append(f"error: {error}"))
    page.on("request", lambda asked: None if asked.url.startswith(FROM_DISK) else wrong.append(f"asked {asked.url}"))
    yield page
    context.close()
    assert not wrong, "\n".join(wrong)


@pytest.fixture
def open_file(page):
    """Opens a file, and a place in it as in ``"#t=12"``, from disk; returns the page."""

    def opened(path, fragment=""):
        page.goto(Path(path).absolute().as_uri() + fragment)
        return page

    return opened


@pytest.fixture
def check_access():
    """Checks that axe finds nothing in a page that shuts somebody out."""
    sync = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe: pip install jaxwalk[dev]")

    def check(page):
        found = sync.Axe().run(page, options=NO_PRELOAD).response["violations"]
        said = [f"{v['id']}: {v['help']} {[node['html'][:160] for node in v['nodes'][:5]]}" for v in found]
        assert not said, "\n".join(said)

    return check


@pytest.fixture
def check_both_schemes(check_access):
    """Checks access in light and in dark colours."""

    def check(page):
        check_access(page)
        page.emulate_media(color_scheme="dark")
        check_access(page)

    return check
