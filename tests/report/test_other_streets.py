"""Reports on other streets than the paper's."""

from __future__ import annotations

import dataclasses

from jaxwalk.evaluation.document_parts import StreetOrigin
from jaxwalk.maps import MapText
from jaxwalk.report import write_report
from jaxwalk.report.figures import FIGURES
from jaxwalk.sim.sim_config import WORLDS
from report.material import material


def test_on_other_streets_nothing_stands_beside_the_papers_numbers(tmp_path, undrawn):
    documents = material(1)
    street = StreetOrigin((MapText("town-1", "0" * 16),), WORLDS["town"])
    elsewhere = dataclasses.replace(
        documents, results=dataclasses.replace(documents.results, street=street), trainings=None, ablation=None,
        episode=None, episode_svg=None, collision=None, collision_svg=None,
    )  # fmt: skip
    text = write_report(tmp_path, elsewhere).read_text(encoding="utf-8")
    assert "nor collides in 60 s has timed out" in text
    there = write_report(tmp_path / "there", documents).read_text(encoding="utf-8")
    for said in ('<span class="source">paper', "Open diamonds", "The paper", "Aryan"):
        assert said in there and said not in text, said
    for path in (tmp_path / "tables").glob("*.csv"):
        assert "paper" not in path.read_text(encoding="utf-8").splitlines()[0], path.name
    for name in ("baselines", "speed_differential", "attribution", "quarters"):
        figure = FIGURES[name](elsewhere)
        labels = [label for axis in figure.axes for label in axis.get_legend_handles_labels()[1]]
        assert labels and not [label for label in labels if "paper" in label], name
