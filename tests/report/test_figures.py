"""What figures show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jaxwalk.experiments.tournament import COMPARED
from jaxwalk.metrics import SURROGATE_DISTRIBUTIONS
from jaxwalk.metrics.crossings import ByType
from jaxwalk.metrics.severity import Distribution, Distributions
from jaxwalk.report.figures.frontier import SIGNS
from jaxwalk.report.figures.surrogates import surrogates
from report.material import material


def test_curves_of_surrogate_safety():
    found = material(1)
    share = {"threshold": (1.0, 2.0), "value": (0.25, 0.5), "low": (0.125, 0.25), "high": (0.5, 0.75)}
    many, few = (Distributions(*[Distribution(**share, count=count)] * 4) for count in (20, 19))
    summaries = (cell.summary for cell in found.results.cells)
    seen = [replace(x, numbers={**x.numbers, SURROGATE_DISTRIBUTIONS.name: ByType(many, few)}) for x in summaries]
    cells = tuple(replace(cell, summary=summary) for cell, summary in zip(found.results.cells, seen, strict=True))
    figure = surrogates(replace(found, results=replace(found.results, cells=cells)))
    for axis in figure.axes:
        lines = {line.get_label(): line for line in axis.lines}
        assert {"co-trained, crosswalk", "single-agent, crosswalk"} <= set(lines)
        assert not any("jaywalk" in label for label in lines)  # too few
        np.testing.assert_allclose(lines["co-trained, crosswalk"].get_xydata(), [[1, 25], [2, 50]])
        (band, _) = axis.collections
        assert {12.5, 25, 50, 75} <= set(band.get_paths()[0].vertices[:, 1])


def test_no_two_drivers_of_a_reproduction_look_alike():
    assert len(set(SIGNS)) == len(SIGNS) >= len(COMPARED) + 2  # its rules and two trained drivers
