"""The style of figures: colours that colour-blind people can distinguish, text that follows the page's colour."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from jaxwalk.writing import current, whole

BLUE, ORANGE, GREEN, RED, PURPLE, SKY = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9"
"""Okabe and Ito's colours."""
INK, GRID = "#222221", "#9a9a99"
"""Text and lines; in the page, INK becomes the page's own text colour."""
PAPER = INK
"""The paper's numbers have the colour of the text."""

FULL, COLUMN = 7.1, 3.5
"""Widths of a journal's page and of one of its two columns [inches]: 180 and 89 mm."""
RESOLUTION = 300
"""Resolution of PNG files [dots per inch]."""
SCREEN = 1.25
"""Factor by which a page enlarges drawings over their printed size: small print is hard to read on a screen."""

_STYLE = {
    "svg.fonttype": "none",
    "text.parse_math": False,  # names are names
    "font.size": 8,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "legend.title_fontsize": 7,
    "lines.linewidth": 1.2,
    "axes.linewidth": 0.7,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": INK,
    "axes.titlesize": 8,
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.alpha": 0.3,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
}


@contextmanager
def drawing(name: str) -> Iterator[None]:
    """Apply the style; identifiers inside a drawing depend only on its name, so files are the same each time."""
    style: Any = {**_STYLE, "svg.hashsalt": name}
    with matplotlib.rc_context(style):
        yield


def panels(
    count: int, *, rows: int = 1, width: float = FULL, height: float = 3.0, **options
) -> tuple[Figure, list[Axes]]:
    """Return a figure [inches] with ``rows`` rows of ``count`` panels side by side, and its panels row by row."""
    figure = Figure(figsize=(width, height))
    axes = figure.subplots(rows, count, squeeze=False, **options)
    return figure, list(axes.flat)


def save(figure: Figure, folder: Path, name: str) -> str:
    """Write the figure as SVG and PNG on white; return the SVG for a page, without a background."""
    with whole(folder / f"{name}.svg") as file:
        figure.savefig(file, metadata={"Date": None}, facecolor="white")
    figure.set_layout_engine("none")  # the layout is done: repeating it would take as long as the drawing
    with whole(folder / f"{name}.png") as file:
        figure.savefig(file, dpi=RESOLUTION, facecolor="white")
    white = current(folder / f"{name}.svg").read_text(encoding="utf-8")
    return inline(white.replace("fill: #ffffff", "fill: none"), name)


def inline(svg: str, name: str) -> str:
    """Return an SVG file's drawing for a page: no preamble, unique identifiers, the page's colour, a screen's width."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'\bid="', f'id="{name}-', svg)
    svg = re.sub(r'href="#', f'href="#{name}-', svg)
    svg = re.sub(r"url\(#", f"url(#{name}-", svg)
    svg = svg.replace(INK, "currentColor")
    svg = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", svg, count=1)
    return re.sub(r'(<svg[^>]*?) width="([^"]*)"', rf'\1 style="width: calc({SCREEN} * \2)"', svg, count=1)


def as_picture(svg: str) -> str:
    """Return a drawing as the address of an image: its file may come from anybody, and images run no scripts."""
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()
