"""A report of a few hand-made episodes: everything is in it, and it needs nothing else."""

from __future__ import annotations

import csv
import dataclasses
import re
from html.parser import HTMLParser

import pytest
from markupsafe import escape
from PIL import Image

from browser.pages import gallery_document, watched
from jaxwalk.evaluation import Results
from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.report import Material, ReportError, write_report
from jaxwalk.report.figures import FIGURES
from jaxwalk.report.paper_tables import TABLES
from jaxwalk.report.sections import SECTIONS
from jaxwalk.report.table import NONE
from jaxwalk.report.verdicts import Versus, brief, verdict
from report.material import material

OF_SEVERAL = ("training_seeds",)
"""Tables that compare training seeds."""


@pytest.fixture(scope="module")
def documents():
    return material(1)


@pytest.fixture(scope="module")
def folder(documents, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    write_report(folder, documents)
    return folder


@pytest.fixture(scope="module")
def page(folder):
    return (folder / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def several(tmp_path_factory):
    """The folder of a report on three training seeds."""
    folder = tmp_path_factory.mktemp("several")
    write_report(folder, material(3))
    return folder


def _table(folder, name):
    with (folder / "tables" / f"{name}.csv").open() as file:
        return list(csv.DictReader(file))


def test_the_first_tables_caption_says_which_numbers_have_intervals(page, several):
    """The mean of several trainings has none (`_mean` of first_screen)."""
    without = "with its 95 % interval, or of several trainings their mean without one; "
    assert without in " ".join((several / "report.html").read_text(encoding="utf-8").split())
    assert without not in " ".join(page.split()) and "with its 95 % interval; " in " ".join(page.split())
    assert "the car's mean speed at the moment of a hit" in " ".join(page.split())


def test_every_section_table_and_figure_is_in_the_page(page, several):
    for section in SECTIONS:
        expected = section.table not in OF_SEVERAL
        assert (f"<h2>{escape(section.heading)}" in page) == expected
        assert f"<h2>{escape(section.heading)}" in (several / "report.html").read_text(encoding="utf-8")
    shown = [section.table for section in SECTIONS if section.table]
    assert sorted(shown) == sorted(TABLES)
    assert page.count("<table>") == len(TABLES) - len(OF_SEVERAL) + 2  # and how the drivers stand, the last one folded
    assert page.count("<svg") == len(FIGURES)
    assert page.count('<img class="drawing" src="data:image/svg+xml;base64,') == 2
    assert page.index("Collision with a jaywalker. Scenario 1 of seed 5: the route-follower car") < page.index(
        "Successful avoidance. Scenario 2 of seed 5: the co-trained car"
    )


def test_files_of_every_table_and_figure(folder):
    made = {f"{name}.{kind}" for name in set(TABLES) - set(OF_SEVERAL) for kind in ("csv", "json", "md", "tex")}
    assert {p.name for p in (folder / "tables").iterdir()} == made
    assert {p.name for p in (folder / "figures").iterdir()} == {
        f"{n}.{kind}" for n in FIGURES for kind in ("svg", "png")
    }


def test_figures_are_as_journals_want_them(folder):
    for file in (folder / "figures").glob("*.svg"):
        svg = file.read_text(encoding="utf-8")
        inches = float(re.search(r'width="([\d.]+)pt"', svg)[1]) / 72
        assert inches == pytest.approx(3.5 if file.stem == "quarters" else 7.1), file
        assert min(map(float, re.findall(r"font-size: ([\d.]+)px", svg))) >= 7, file  # (of an SVG in points)
        with Image.open(file.with_suffix(".png")) as png:
            assert png.info["dpi"] == pytest.approx((300, 300), rel=1e-3)
            assert png.width == pytest.approx(300 * inches, abs=1)


def test_where_it_comes_from_is_said(page):
    for fact in (
        "<dd>fast</dd>",
        "one training seed, 5",
        "0123456789abcdef",
        "an abacus",
        "abc123",
        "512 steps in 0.1 minutes",
        "jax 0.10.2",
    ):
        assert fact in page


def test_the_page_needs_no_network(page):
    assert not re.search(r"""(?:src|href)\s*=\s*["'](?!#|data:)""", page)
    assert not re.search(r"url\((?!#)", page)
    assert "@import" not in page


def test_every_entry_of_the_contents_leads_somewhere(page, several):
    for text in (page, (several / "report.html").read_text(encoding="utf-8")):
        contents = re.search(r'<nav class="contents".*?</nav>', text, re.DOTALL)
        entries = re.findall(r'href="#([^"]+)"', contents[0]) if contents else []
        assert len(entries) > 15
        assert entries == re.findall(r'<(?:header|details class="section") id="([^"]+)"', text)


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
    assert rows[1][2] == "66.7 [9.4, 99.2]"  # the exact interval of 2 in 3
    assert [rows[1][3], rows[1][5]] == ["65", "20"]
    assert len(_table(folder, "ablation")) == 10
    route_follower = _table(folder, "waiting")[4]
    assert route_follower["driver"] == "route-follower"
    assert route_follower["waits in danger %"].startswith("50.0 [")
    assert route_follower["pace [m/s]"].startswith("0.83 [")  # of six people, one stands and five walk 1 m/s
    assert route_follower["of always-go's %"] == "100.0"
    assert (route_follower["harmless %"], route_follower["longest stand on a roadway [steps]"]) == ("–", "0")


def test_tables_of_several_seeds(several):
    rule, *_, learned = _table(several, "matrix")
    assert rule["goal %"] == "66.7 [9.4, 99.2]"  # nobody was trained: as with one seed
    assert learned["goal %"] == "33.3"  # of 2, 1 and 0 in 3; three seeds give no interval
    assert (learned["goal %, IQM"], learned["collision %, IQM"]) == ("33.3", "66.7")
    assert [row["training seed"] for row in _table(several, "training_seeds")] == ["5", "6", "7"] * 4
    assert [row["collision %"][:4] for row in _table(several, "training_seeds")[:3]] == ["33.3", "66.7", "100."]
    moving = [row["moving contacts %"][:4] for row in _table(several, "training_seeds")[:3]]
    assert moving == ["33.3", "66.7", "100."]
    assert learned["moving contacts %"] == "66.7"
    lines = (several / "tables" / "training_seeds.md").read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("| driver | pedestrians | training seed |")
    assert len(lines) == 2 + 12
    (pair,) = _table(several, "pairs")
    assert (pair["A"], pair["B"]) == ("random among always-go", "co-trained among always-go")
    # three pairs for each seed; the second and third seed hit 1 and 2 more than always-go's one match
    assert (pair["A %"], pair["B %"], pair["A alone"], pair["B alone"]) == ("33.3", "66.7", "0", "3")
    assert (pair["p"], pair["p, Holm"]) == ("cannot be judged", "cannot be judged")


def test_what_a_report_of_several_seeds_says(several, page):
    text = (several / "report.html").read_text(encoding="utf-8")
    assert "3 training seeds, 5 to 7" in text
    first = "Shown for training seed 5, the first of several."
    assert text.count(first) == sum(not section.over_seeds for section in SECTIONS)
    assert first not in page
    assert text.count(">each training seed<") == 1
    assert ">goal, IQM<" in text


def test_two_seeds_give_no_interval(tmp_path, undrawn):
    write_report(tmp_path, material(2))
    assert "2 training seeds, 5 to 6: rates are their means (IQM: interquartile means), without intervals" in (
        tmp_path / "report.html"
    ).read_text(encoding="utf-8")
    assert _table(tmp_path, "matrix")[-1]["goal %"] == "50.0"


@pytest.mark.long
def test_the_same_results_make_the_same_report(documents, folder, tmp_path):
    write_report(tmp_path, documents)
    for name in ("report.html", "figures/baselines.svg", "tables/matrix.csv", "tables/matrix.tex"):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


@pytest.mark.parametrize(
    ("lacking", "message"),
    [
        ({"cells": ()}, "the results have no cells"),
        ({"over_seeds": ()}, "lack numbers over training seeds of random among always-go"),
    ],
)
def test_results_that_lack_something_are_refused(documents, lacking, message):
    with pytest.raises(ReportError, match=message):
        dataclasses.replace(documents, results=dataclasses.replace(documents.results, **lacking))


def test_a_driver_that_did_not_meet_everybody_is_refused(documents):
    cells = [cell for cell in documents.results.cells if (cell.driver, cell.pedestrians) != ("random", "learned")]
    with pytest.raises(ReportError, match="the results lack random among learned; evaluate again"):
        dataclasses.replace(documents, results=dataclasses.replace(documents.results, cells=tuple(cells)))


@pytest.mark.parametrize("error", [KeyError, TypeError, IndexError])
def test_a_fault_in_a_figure_is_a_traceback(documents, tmp_path, monkeypatch, error):
    """It must not be called damage of somebody's results."""

    def broken(material):
        raise error("a fault of ours")

    monkeypatch.setitem(FIGURES, "baselines", broken)
    with pytest.raises(error, match="a fault of ours"):
        write_report(tmp_path, documents)
    assert not (tmp_path / "report.html").exists()


def test_verdicts():
    inside = Versus("goals", Interval(0.7, 0.6, 0.8), 65.0)
    outside = Versus("collisions", Interval(0.02, 0.01, 0.03), 14.0)
    unknown = Versus("time", Interval(None, None, None), 3.38)
    assert verdict([inside], "Because.") == "The paper's value lies in our 95 % interval for goals."
    assert verdict([outside], "Because.") == "Differs from the paper: collisions: 2.00, below 14.0 %. Because."
    assert verdict([unknown], "Because.") == "Too few cases to say: time."
    assert "Because." in verdict([inside, outside, unknown], "Because.")
    assert brief([inside]) == "Agrees with the paper in 1 number."
    assert brief([inside, outside, unknown]) == "Differs from the paper in 1 of 2 numbers."
    assert brief([unknown]) == ""


def test_any_drivers_among_any_people(documents, tmp_path, undrawn):
    def alone(found):
        mine = (dataclasses.replace(one, driver=f"my/{one.driver}") for one in found if one.driver != "random")
        return tuple(one for one in mine if one.pedestrians == "always-go")

    found = documents.results
    results = Results(found.scenarios, alone(found.cells), over_seeds=alone(found.over_seeds))
    subject = "my/rule-based"
    mine = Material(
        results=results, minutes={"all": 1.0}, provenance=documents.provenance, subject=subject, headline=(subject,),
        gallery=watched(gallery_document()),
    )  # fmt: skip
    text = write_report(tmp_path, mine).read_text(encoding="utf-8")
    for heading in ("Co-training against training alone", "More and less jaywalking", "How the drivers learned"):
        assert heading not in text
    for heading in ("Collisions and near misses", "Who reaches the goal", "Every driver among every population"):
        assert f"<h2>{heading}" in text
    assert f"Mean speed of {subject} among always-go pedestrians" in text
    assert f"of {subject} by what the pedestrian was doing" in text
    assert "Training seeds" not in text
    assert "None" not in text
    assert "Differs from the paper" not in text
    for path in (tmp_path / "tables").glob("*.csv"):
        head, *rows = csv.reader(path.read_text(encoding="utf-8").splitlines())
        empty = [name for place, name in enumerate(head) if all(row[place] in ("", NONE) for row in rows)]
        assert not [name for name in empty if "paper" in name], path.name
    assert "data-cell" not in text.split('<script type="application/json"')[0]  # the gallery is about others
    assert len(_table(tmp_path, "matrix")) == 6


def test_numbers_of_who_can_be_watched_are_links(documents, tmp_path, undrawn):
    gallery = gallery_document()
    for episode in gallery["episodes"]:
        episode["driver"] = {"rash": "co-trained", "careful": "route-follower"}[episode["driver"]]
    text = write_report(tmp_path, dataclasses.replace(documents, gallery=watched(gallery))).read_text(encoding="utf-8")
    linked = re.findall(r'<a href="#gallery" data-cell="([^"]*)">', text)
    assert set(linked) == {"co-trained among always-go", "route-follower among always-go"}
    first = text.split("</header>")[0]
    assert len(re.findall("data-cell=", first)) == 2
    assert re.findall(r'data-incident="(\d)">([^,<]*)', first) == [
        ("0", "Hit at 5.0 m/s"),
        ("1", "Hit at 5.0 m/s"),
        ("2", "Near miss"),
    ]
    assert 'href="#episode=7&amp;driver=co-trained&amp;pedestrians=always-go&amp;t=1.0"' in first
    assert '"incidents":' in text
