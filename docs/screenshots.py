"""Screenshots of a report for the documentation (`make pictures`): python docs/screenshots.py REPORT.html FOLDER."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

WORST = "avoidable by"
"""How the chips begin that choose avoidable collisions."""


def main(report: Path, folder: Path) -> None:
    """The top of the report, its gallery, and the worst avoidable collision of the route-follower, as a reader gets
    there."""
    named = os.environ.get("JAXWALK_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=named, args=["--no-sandbox"])
        for scheme in ("light", "dark"):
            page = browser.new_page(
                viewport={"width": 1180, "height": 900}, color_scheme=scheme, reduced_motion="reduce"
            )
            page.goto(report.absolute().as_uri())
            _tour(page, folder, scheme)
        browser.close()


def _tour(page: Page, folder: Path, scheme: str) -> None:
    page.screenshot(path=folder / f"report-{scheme}.png")
    page.click("a[data-cell='route-follower among always-go']")
    page.click(f"text={WORST} the driver")
    page.locator("#gallery").scroll_into_view_if_needed()
    page.wait_for_timeout(1000)
    page.screenshot(path=folder / f"gallery-{scheme}.png")
    page.click(".incidents button")
    page.select_option("dialog [name=beside]", label="co-trained among always-go")
    page.wait_for_function("document.querySelectorAll('dialog .stage').length === 2")
    page.check("dialog [name=rings]")
    page.keyboard.press("Shift+ArrowRight")
    page.wait_for_timeout(300)
    page.screenshot(path=folder / f"replay-{scheme}.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
