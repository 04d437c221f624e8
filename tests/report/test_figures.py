"""What figures show."""

from __future__ import annotations

import numpy as np

from jaxwalk.report.figures.surrogates import surrogates
from jaxwalk.report.material import Material
from report.material import material


def test_curves_of_surrogate_safety():
    found = Material(**material(1))
    share = {"threshold": [1.0, 2.0], "value": [0.25, 0.5], "low": [0.125, 0.25], "high": [0.5, 0.75]}
    many, few = {**share, "count": 20}, {**share, "count": 19}
    cells = [
        {**cell, "surrogate_distributions": {
            kind: dict.fromkeys(("ttc", "pet", "drac", "min_distance"), seen)
            for kind, seen in (("crosswalk", many), ("jaywalk", few))
        }}
        for cell in found.results["cells"]
    ]  # fmt: skip
    figure = surrogates(Material(**{**vars(found), "results": {**found.results, "cells": cells}}))
    for axis in figure.axes:
        lines = {line.get_label(): line for line in axis.lines}
        assert {"co-trained, crosswalk", "single-agent, crosswalk"} <= set(lines)
        assert not any("jaywalk" in label for label in lines)  # too few
        np.testing.assert_allclose(lines["co-trained, crosswalk"].get_xydata(), [[1, 25], [2, 50]])
        (band, _) = axis.collections
        assert {12.5, 25, 50, 75} <= set(band.get_paths()[0].vertices[:, 1])
