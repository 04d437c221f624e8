"""A report of a few hand-made episodes: everything is in it, and it needs nothing else."""

from __future__ import annotations

import csv
import json
import re
from html.parser import HTMLParser

import pytest
from markupsafe import escape

from jaxwalk.evaluation import Cell, Results
from jaxwalk.metrics import measure, summarise
from jaxwalk.report import ReportError, write_report
from jaxwalk.report.figures import FIGURES
from jaxwalk.report.sections import SECTIONS
from jaxwalk.report.tables import TABLES
from jaxwalk.report.verdicts import Versus, verdict
from jaxwalk.sim.trajectory import CROSSWALK, JAYWALK
from metrics.scenes import Scene, Walk, trajectory

DRIVERS = (
    "random",
    "constant-speed",
    "rule-based",
    "rule-based-braking",
    "route-follower",
    "single-agent",
    "co-trained",
)


@pytest.fixture(scope="module")
def documents():
    people = [
        Walk(30.0, -4.0, vy=1.0, crossings=[(2, 40, CROSSWALK)], kerb=[0, 1], waits=[1], miss=1.0, arrivals=[45]),
        Walk(40.0, 4.0, vy=-1.0, crossings=[(5, 45, JAYWALK)]),
    ]
    reached = Scene(50, people, goal=True)
    hit = Scene(50, [Walk(25.0, 0.0, crossings=[(20, 50, JAYWALK)]), people[0]], touched=[0])
    summary = summarise(measure(trajectory(reached, hit, reached)), resamples=20)
    results = _results(summary, DRIVERS, (0.25,))
    lines = [
        {"update": n, "steps": 64 * n, "seconds": 1.0 * n, "episodes": float(n)}
        | {"goal_rate": 0.5, "collision_rate": 0.25, "timeout_rate": 0.25}
        for n in range(1, 9)
    ]
    return {
        "results": results,
        "ablation": _results(summary, ("co-trained",), (0.0, 0.1, 0.25, 0.6, 1.0)),
        "curves": {"co-trained": lines, "single-agent": lines},
        "provenance": {"commit": "abc123", "hardware": "an abacus", "versions": {"jax": "0.10.2"}},
        "plan": {"recipe": "fast", "seed": 5, "episodes": 3},
        "minutes": {"evaluate": 1.5},
        "episode": {"scenario": 2, "seed": 5},
        "episode_svg": '<?xml version="1.0"?><svg width="9pt" height="9pt"><path id="p" clip-path="url(#p)"/></svg>',
    }


def _results(summary, drivers, multipliers):
    cells = [
        Cell(driver, people, "mode", "sample", multiplier, summary, "route", "kerb")
        for driver in drivers
        for multiplier in multipliers
        for people in ("always-go", "learned")
    ]
    return json.loads(Results(5, 3, "0123456789abcdef", tuple(cells)).to_json())


@pytest.fixture(scope="module")
def folder(documents, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    write_report(folder, documents)
    return folder


@pytest.fixture(scope="module")
def page(folder):
    return (folder / "report.html").read_text(encoding="utf-8")


def test_every_section_table_and_figure_is_in_the_page(page):
    for section in SECTIONS:
        assert f"<h2>{escape(section.heading)}" in page
    shown = [section.table for section in SECTIONS if section.table]
    assert sorted(shown) == sorted(TABLES)
    assert page.count("<table>") == len(TABLES)
    assert page.count("<svg") == len(FIGURES) + 1


def test_files_of_every_table_and_figure(folder):
    assert {p.stem for p in (folder / "tables").iterdir()} == set(TABLES)
    assert {p.name for p in (folder / "figures").iterdir()} == {
        f"{n}.{kind}" for n in FIGURES for kind in ("svg", "png")
    }


def test_where_it_comes_from_is_said(page):
    for fact in ("fast, seed 5", "0123456789abcdef", "an abacus", "abc123", "512 steps in 0.1 minutes", "jax 0.10.2"):
        assert fact in page


def test_the_page_needs_no_network(page):
    assert not re.search(r"""(?:src|href)\s*=\s*["'](?!#)""", page)
    assert not re.search(r"url\((?!#)", page)
    assert "@import" not in page
    assert "<script" not in page


def test_identifiers_in_the_page_are_unique(page):
    found: list[str] = []

    class Reader(HTMLParser):
        def handle_starttag(self, tag, attrs):
            found.extend(value for name, value in attrs if name == "id" and tag != "defs")

    Reader().feed(page)
    assert len(found) == len(set(found))


def test_numbers_in_tables(folder):
    with (folder / "tables" / "co_training.csv").open() as file:
        rows = list(csv.reader(file))
    assert rows[1][:2] == ["single-agent", "always-go"]
    assert rows[1][2].startswith("66.7 [")
    assert [rows[1][3], rows[1][5]] == ["65", "20"]
    with (folder / "tables" / "ablation.csv").open() as file:
        assert len(list(csv.reader(file))) == 11
    with (folder / "tables" / "waiting.csv").open() as file:
        header, *rows = csv.reader(file)
    route_follower = dict(zip(header, rows[4], strict=True))
    assert route_follower["driver"] == "route-follower"
    assert route_follower["waits in danger %"].startswith("50.0 [")
    assert route_follower["goals per hour"].startswith("360.0 [")  # one each 5 s of two people
    assert route_follower["of always-go's %"] == "100"
    assert (route_follower["harmless %"], rows[4][-1]) == ("–", "0")


def test_the_same_results_make_the_same_report(documents, folder, tmp_path):
    write_report(tmp_path, documents)
    for name in ("report.html", "figures/baselines.svg", "tables/matrix.csv"):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


def test_results_of_another_version_are_refused(documents, tmp_path):
    broken = {**documents, "results": {"cells": [{"driver": "random"}]}}
    with pytest.raises(ReportError, match="damaged or of another version"):
        write_report(tmp_path, broken)
    assert list(tmp_path.iterdir()) == []


def _number(value, low, high):
    return {"value": value, "low": low, "high": high}


def test_verdicts():
    inside = Versus("goals", _number(0.7, 0.6, 0.8), 65.0)
    outside = Versus("collisions", _number(0.02, 0.01, 0.03), 14.0)
    unknown = Versus("time", _number(None, None, None), 3.38)
    assert verdict([inside], "Because.") == "The paper's value lies in our 95 % interval for goals."
    assert verdict([outside], "Because.") == "Differs from the paper: collisions: 2.00, below 14.0 %. Because."
    assert verdict([unknown], "Because.") == "Too few cases to say: time."
    assert "Because." in verdict([inside, outside, unknown], "Because.")
