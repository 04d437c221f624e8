"""Names come from others: run folders, drivers, what a folder of results says. On a page they are words, never code."""

from __future__ import annotations

import json
import re
from dataclasses import asdict
from pathlib import Path

import pytest

from browser.pages import gallery_document, replay_document, watched
from jaxwalk.evaluation.reading import Origin, as_document, as_results
from jaxwalk.provenance import Provenance
from jaxwalk.report import Material, write_report
from jaxwalk.viewer import replay_page
from report.material import material

pytestmark = pytest.mark.long

CODE = (
    "</script><script>document.title = 'owned'</script><img src=x onerror=\"document.title = 'owned'\">{{ 7 * 7 }}'$x^{"
)
"""Ends a script, begins another, is a broken picture, a template and broken mathematics."""
SCRIPT = "document.title = 'owned'"
SVG = f'<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9" onload="{SCRIPT}"><script>{SCRIPT}</script></svg>'


def _renamed(document):
    """The same with the driver and the trained population called by that name, and other words made of it."""
    text = json.dumps(document)
    for word in ('"co-trained"', '"learned"', '"an abacus"', '"abc123"', '"fast"', '"0.10.2"', '"0123456789abcdef"'):
        text = text.replace(word, json.dumps(CODE))
    return json.loads(text)


def _check_harmless(page):
    """Nothing ran, and the name is there to read."""
    assert page.title() != "owned"
    assert page.locator("img[src=x]").count() == 0
    assert CODE in page.text_content("main")


def test_a_report_of_hostile_names(tmp_path, open_file):
    several = material(1)
    origin = Origin(Path("results.json"), "evaluate again")
    gallery = gallery_document()
    for episode in gallery["episodes"]:
        episode |= {"driver": CODE, "pedestrians": CODE}
    hostile = Material(
        results=as_results(_renamed(several.results.as_dict()), origin),
        provenance=as_document(Provenance, _renamed(asdict(several.provenance)), origin),
        minutes={"all": 1.0}, gallery=watched(gallery), curves={CODE: several.curves["single-agent"]},
        subject=CODE, headline=(CODE, "single-agent"), episode=several.episode, episode_svg=SVG,
    )  # fmt: skip
    file = write_report(tmp_path, hostile)
    assert not re.search(r"<script>document|<img src=x|onload=", file.read_text(encoding="utf-8"))
    page = open_file(file)
    page.wait_for_selector(".incidents button")
    page.click(".incidents button")
    page.wait_for_selector("dialog[open] .stage canvas")
    _check_harmless(page)


def test_a_replay_of_hostile_names(tmp_path, open_file):
    document = replay_document()
    for episode in document["episodes"]:
        episode |= {"driver": CODE, "pedestrians": CODE}
    replay_page(document, tmp_path / "replay.html", title=CODE)
    page = open_file(tmp_path / "replay.html")
    page.wait_for_selector(".stage canvas")
    _check_harmless(page)


def test_the_page_to_watch_a_run_of_a_hostile_name(tmp_path, open_file):
    from jaxwalk.recipes import RECIPES
    from jaxwalk.runs.folder import Run
    from jaxwalk.runs.progress import Pace
    from jaxwalk.runs.watch import WatchPage

    run = Run.create(tmp_path / "a <script>document.title = 'owned'<" / "[red]", RECIPES["fast"])
    lines = [{"update": 1, "seconds": 1.0, "steps": 64, "episodes": 2, "goal_rate": 0.5}]
    with WatchPage(run, CODE, Pace(1, 2, 64), lines) as watched:
        page = open_file(watched.path)
        page.wait_for_function("document.body.textContent.includes('7 * 7')")
        assert page.title() != "owned"
        assert page.locator("img[src=x]").count() == 0
