"""From results to files: ``report.html``, ``figures/`` and ``tables/``."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from jaxwalk.evaluation.results import SCHEMA
from jaxwalk.metrics.statistics import FEWEST_SEEDS
from jaxwalk.report.figures import draw_all
from jaxwalk.report.latex import write_latex
from jaxwalk.report.material import Material, ReportError
from jaxwalk.report.sections import SECTIONS
from jaxwalk.report.style import as_picture
from jaxwalk.report.table import shown, write_csv
from jaxwalk.report.tables import make_all
from jaxwalk.viewer.replay import as_script, gallery_html, gallery_script, gallery_style
from jaxwalk.writing import write_whole


def write_report(folder: Path, documents: Mapping[str, Any]) -> Path:
    """Write everything into the folder; returns the path of the page.

    ``documents`` are the fields of `Material`.
    """
    try:
        _check_version(documents)
        material = Material(**documents)
        sections = [section for section in SECTIONS if section.applies(material)]
        tables = make_all([s.table for s in sections if s.table], material)
        facts, summary = _facts(material), _summary(material)
        gallery = material.gallery if material.gallery and material.gallery["incidents"] else None
        cells = _to_watch(gallery)
        figures = draw_all([s.figure for s in sections if s.figure], material, folder / "figures")
    except (KeyError, TypeError, IndexError) as error:
        raise ReportError(
            f"{folder}: the results are damaged or of another version (no {error}); evaluate again"
        ) from error
    captions = {s.table: f"{s.heading}. {s.said(material)}" for s in sections if s.table}
    write_csv(tables, folder / "tables")
    write_latex(tables, captions, folder / "tables")
    page = _page(
        sections=sections, material=material, first_seed=material.training_seeds[0] if material.several else None,
        tables=tables, figures=figures, facts=facts, summary=summary,
        drawing=as_picture(material.episode_svg) if material.episode_svg else None,
        gallery=_gallery(gallery) if gallery else None, cells=cells,
    )  # fmt: skip
    path = folder / "report.html"
    write_whole(path, page)
    return path


def _gallery(document: Mapping[str, Any]) -> dict[str, str]:
    """The parts of the gallery of failures."""
    return {"css": gallery_style(), "html": gallery_html(), "script": gallery_script(), "data": as_script(document)}


def _to_watch(gallery: Mapping[str, Any] | None) -> set[str]:
    """Whose collisions the gallery has, by the words that its script uses for them."""
    hits = [one for one in gallery["incidents"] if one["kind"] == "collision"] if gallery else []
    episodes = [gallery["episodes"][one["episode"]] for one in hits] if gallery else []
    return {f"{episode['driver']} among {episode['pedestrians']}" for episode in episodes}


def _check_version(documents: Mapping[str, Any]) -> None:
    """Raise KeyError for documents of another schema."""
    for name in ("results", "ablation"):
        if documents.get(name) is not None and documents[name].get("schema") != SCHEMA:
            raise KeyError(f"schema {SCHEMA} in {name}.json")


def _page(**content: Any) -> str:
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    template = resources.files("jaxwalk.report").joinpath("page.html").read_text(encoding="utf-8")
    try:
        return environment.from_string(template).render(**content)
    except jinja2.UndefinedError as error:
        raise ReportError(f"the results are damaged or of another version ({error}); evaluate again") from error


def _summary(material: Material) -> list[dict[str, str]]:
    """The numbers that people ask for first."""
    return [
        {
            "cell": f"{driver} among {people}",
            "goal": shown(found["goal_rate"]["mean"]),
            "collision": shown(found["collision_rate"]["mean"]),
        }
        for driver in material.headline
        for people in material.populations
        for found in [material.over_seeds(driver, people)]
    ]


def _seeds(material: Material) -> str:
    """How many there are, and what the intervals are over."""
    seeds = material.training_seeds
    if not material.several:
        return f"one training seed, {seeds[0]}: intervals are over scenarios, and say nothing about training again"
    said = f"{len(seeds)} training seeds, {seeds[0]} to {seeds[-1]}: rates are their means (IQM: interquartile means)"
    if len(seeds) < FEWEST_SEEDS:
        return f"{said}, without intervals: so few don't tell how much seeds differ"
    return f"{said}, intervals over training seeds and scenarios"


def _facts(material: Material) -> list[tuple[str, str]]:
    """Where the numbers come from."""
    scenarios, made = material.results["scenarios"], material.provenance
    facts = [] if material.plan is None else [("Recipe", material.plan["recipe"]), ("Training seeds", _seeds(material))]
    facts.append(
        ("Scenarios", f"{scenarios['count']:,} in each cell, seed {scenarios['seed']}, hash {scenarios['hash']}")
    )
    for name, curves in material.curves.items():
        last = [lines[-1] for lines in curves.values()]
        times = ", ".join(f"{line['seconds'] / 60:.1f}" for line in last)
        facts.append((f"Training, {name}", f"{last[0]['steps']:,} steps in {times} minutes"))
    whole = sum(material.minutes.values())
    facts += [
        ("Minutes in all", f"{whole:.1f}"),
        ("Hardware", str(made["hardware"])),
        ("Commit", str(made["commit"] or "not run from a checkout")),
        ("Versions", ", ".join(f"{name} {version}" for name, version in made["versions"].items())),
    ]
    return facts
