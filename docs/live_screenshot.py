"""The picture of `docs/live.md` (`make pictures`): python docs/live_screenshot.py FOLDER."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread

from playwright.sync_api import sync_playwright

from jaxwalk.live.live_offer import offer_of
from jaxwalk.live.live_server import live_server
from jaxwalk.live.live_session import LiveSession
from jaxwalk.runs.contestants import contestant
from jaxwalk.sim.suites import Where

COMPILED = 300_000
"""Longest time to wait for a simulation to be compiled [ms]."""


def main(folder: Path) -> None:
    """The trained car among learned people, six seconds after its start."""
    offer = offer_of([], [], Where())
    named = os.environ.get("JAXWALK_CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    with TemporaryDirectory() as saved:
        server, address = live_server(0, lambda: LiveSession(offer, Path(saved), contestant))
        with server, sync_playwright() as playwright:
            Thread(target=server.serve_forever).start()
            browser = playwright.chromium.launch(executable_path=named, args=["--no-sandbox"])
            page = browser.new_page(viewport={"width": 1180, "height": 900}, reduced_motion="reduce")
            page.goto(address)
            page.wait_for_selector("[data-do=step]:not([disabled])", timeout=COMPILED)
            for _ in range(60):
                page.click("[data-do=step]")
            page.locator(".clock").filter(has_text="6.0 s").wait_for()
            page.screenshot(path=folder / "live.png")
            browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
