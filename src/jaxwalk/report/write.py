"""Write a report's files: ``report.html``, ``figures/`` and ``tables/``."""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import Any

from jaxwalk.metrics import FEWEST_SEEDS
from jaxwalk.report.figures import draw_all
from jaxwalk.report.first_screen import first_screen
from jaxwalk.report.latex import write_latex
from jaxwalk.report.material import Material
from jaxwalk.report.paper_tables import make_all
from jaxwalk.report.sections import SECTIONS
from jaxwalk.report.style import as_picture
from jaxwalk.report.table_files import write_tables
from jaxwalk.report.watched import Gallery
from jaxwalk.viewer.filled_page import filled_in
from jaxwalk.viewer.replay import as_script, gallery_html, gallery_script, gallery_style
from jaxwalk.wording import counted
from jaxwalk.writing import write_whole

PRINTED = 16
"""Rows of a table that are printed; the page and the table's files have all."""


def write_report(folder: Path, material: Material, say: Callable[[str], None] = lambda line: None) -> Path:
    """Write tables, figures and the page into the folder; return the path of the page.

    ``say`` is called with a line of progress.
    """
    sections = [section for section in SECTIONS if section.applies(material)]
    tables = make_all([s.table for s in sections if s.table], material)
    gallery = material.gallery if material.gallery and material.gallery.incidents else None
    figures = draw_all([s.figure for s in sections if s.figure], material, folder / "figures", say)
    say("    writing tables and the page")
    captions = {s.table: f"{s.heading}. {s.said(material)}" for s in sections if s.table}
    write_tables(tables, captions, folder / "tables")
    write_latex(tables, captions, folder / "tables")
    first = first_screen(material)
    more = counted(len(first.folded), "more driver") if first.folded else ""
    page = filled_in(
        _part("page.html"),
        sections=sections, material=material, first_seed=material.training_seeds[0] if material.several else None,
        tables=tables, figures=figures, facts=_facts(material), first=first, more=more,
        printed=PRINTED, drawings=_drawings(material), style=_part("report.css"), script=_part("report.js"),
        gallery=_gallery(gallery) if gallery else None, cells=gallery.collisions if gallery else (),
    )  # fmt: skip
    path = folder / "report.html"
    write_whole(path, page)
    return path


def _drawings(material: Material) -> list[dict[str, Any]]:
    """Return the drawn episodes with their headings, in the order of the paper's figure 1."""
    drawn = (
        ("Collision with a jaywalker", material.collision, material.collision_svg),
        ("Successful avoidance", material.episode, material.episode_svg),
    )
    return [{"what": what, "about": about, "picture": as_picture(svg)} for what, about, svg in drawn if about and svg]


def _gallery(gallery: Gallery) -> dict[str, str]:
    """Return the gallery's parts of the page."""
    data = as_script(gallery.as_dict())
    return {"css": gallery_style(), "html": gallery_html(), "script": gallery_script(), "data": data}


def _part(name: str) -> str:
    """Return the text of one of the page's files."""
    return resources.files("jaxwalk.report").joinpath(name).read_text(encoding="utf-8")


def _seeds(material: Material) -> str:
    """Say how many seeds there are, and what the intervals cover."""
    seeds = material.training_seeds
    if not material.several:
        return f"one training seed, {seeds[0]}: intervals are over scenarios, and say nothing about training again"
    said = f"{len(seeds)} training seeds, {seeds[0]} to {seeds[-1]}: rates are their means (IQM: interquartile means)"
    if len(seeds) < FEWEST_SEEDS:
        return (
            f"{said}, without intervals: differences cannot be judged by so few, which don't tell how much seeds differ"
        )
    return f"{said}, intervals for other training seeds and scenarios"


def _facts(material: Material) -> list[tuple[str, str]]:
    """Return where the numbers come from."""
    scenarios, made = material.results.scenarios, material.provenance
    facts: list[tuple[str, str]] = []
    if material.trainings is not None:
        facts += [("Recipe", material.trainings.recipe), ("Training seeds", _seeds(material))]
    seed = "" if scenarios.seed is None else f", seed {scenarios.seed}"
    facts.append(("Scenarios", f"{scenarios.count:,} in each cell{seed}, hash {scenarios.hash}"))
    if material.results.street is not None:
        facts.append(("Maps", material.results.street.in_words()))
    played = (*material.results.drivers, *material.results.populations)
    if played:
        facts.append(("Policies", "; ".join(origin.in_words() for origin in played)))
    for name, curves in material.curves.items():
        trainings = list(curves.values())
        times = ", ".join(f"{curve.seconds / 60:.1f}" for curve in trainings)
        facts.append((f"Training, {name}", f"{counted(round(trainings[0].steps[-1]), 'step')} in {times} minutes"))
    whole = sum(material.minutes.values())
    facts += [
        ("Minutes in all", f"{whole:.1f}"),
        ("Hardware", made.hardware),
        ("Commit", made.commit or "not run from a checkout"),
        ("Versions", ", ".join(f"{name} {version}" for name, version in made.versions.items())),
    ]
    return facts
