"""The report of an import: what was mapped, inferred, invented and left out, with a picture of each street."""

from __future__ import annotations

import base64
import io
import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from jaxwalk.maps.imported.street_report import ImportReport, StreetReport
from jaxwalk.maps.network import Network
from jaxwalk.viewer.filled_page import filled_in
from jaxwalk.viewer.ground import draw_ground
from jaxwalk.writing import write_whole

SCHEMA = 1
"""Version of the report's JSON."""
COLOURS = {"mapped": "#1b7837", "inferred": "#2f6fb0", "joined": "#7a1fb8", "invented": "#d7642c"}
"""Colours of pavement by where it is from; crossings have those of mapped and invented."""
INCHES, DOTS = 6.0, 80
"""Longer side of a picture, and dots per inch."""


def report_json(report: ImportReport) -> str:
    """Return the report as a JSON document."""
    crossings = [asdict(outcome) for outcome in report.crossings().values()]
    document = {"schema": SCHEMA, **asdict(report), "crossings": crossings}
    return json.dumps(document, indent=1, default=float)


def write_import_page(path: Path, report: ImportReport, networks: Mapping[str, Network | None]) -> None:
    """Write the report as a page. ``networks`` are the streets by name; None for one that can't be used."""
    template = resources.files("jaxwalk.report").joinpath("import_page.html").read_text(encoding="utf-8")
    streets = [(street, _picture(street, networks.get(street.name))) for street in report.streets]
    page = filled_in(
        template,
        report=report, streets=streets, colours=COLOURS, verdicts=Counter(street.verdict for street in report.streets),
        crossings=list(report.crossings().values()), totals=_totals(report), origins=_origins(report),
    )  # fmt: skip
    write_whole(path, page)


def _totals(report: ImportReport) -> dict[str, float]:
    """Return the sums over streets that can be used; what lies in several streets counts in each."""
    own = [street.pavement for street in report.streets if street.usable]
    names = ("mapped", "inferred", "joined", "invented", "known", "kept")
    return {name: sum((getattr(x, name) for x in own), 0.0) for name in names}


def _origins(report: ImportReport) -> dict[str, Counter[str]]:
    """Return for lanes, widths and limits the number of roads by where the number is from."""
    return {
        what: Counter(element[field] for element in report.elements if field in element)
        for what, field in (("lanes", "lanes_from"), ("lane width", "width_from"), ("speed limit", "limit_from"))
    }


def _picture(street: StreetReport, network: Network | None) -> str | None:
    """Return a picture as a data address, or None without a street."""
    if network is None:
        return None
    width, height = (INCHES * side / max(network.size) for side in network.size)
    figure = Figure(figsize=(max(width, 2.0) + 0.4, max(height, 2.0) + 0.4), dpi=DOTS, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    draw_ground(axes, network)
    _draw_origins(axes, street)
    axes.tick_params(labelsize=7)
    file = io.BytesIO()
    figure.savefig(file, format="png")
    return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode()


def _draw_origins(axes: Axes, street: StreetReport) -> None:
    """Draw where pavement and crossings are from; people don't walk on dotted pavement."""
    for origin, colour in COLOURS.items():
        for kept, style in ((True, "solid"), (False, "dotted")):
            own: list[Any] = [np.array(x.line) for x in street.kerbsides if x.origin == origin and x.kept == kept]
            axes.add_collection(LineCollection(own, colors=colour, linewidths=2.0, linestyles=style, zorder=7))
        at = np.array([x.at for x in street.facts if x.origin == origin]).reshape(-1, 2)
        axes.scatter(*at.T, s=30, facecolors="none", edgecolors=colour, linewidths=1.5, zorder=8)
