"""Drawing of the map, which is the same in every frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.path import Path

from jaxwalk.maps.network import Network
from jaxwalk.viewer.drawn_map import SURFACES, DrawnMap, Outline

BLOCK, PAINT = "#f3f1ea", "#f7f7f4"
"""Colours of what lies between roads, and of road markings."""
COLOURS = {
    "building": "#d8cfc0", "sidewalk": "#b5d3a2", "roadway": "#9a9ea5", "parking": "#84888f", "island": "#8fbb78",
    "raised": "#b98b73",
}  # fmt: skip
"""Colour of each surface."""
DASHES = (0, (5, 5))
PAINTED = 3
"""Order of what is painted on the surfaces, which have orders from 1 to 2."""
LAST = 50
"""Order of the attribution, which nothing covers."""


def draw_ground(axes: Axes, network: Network) -> None:
    """Draw surfaces, lines between lanes and crosswalks of a street, in metres."""
    drawn = DrawnMap.of(network)
    axes.set_facecolor(BLOCK)
    axes.set_xlim(0, drawn.width)
    axes.set_ylim(0, drawn.height)
    axes.set_aspect("equal")
    for number, kind in enumerate(SURFACES):
        rings = [_closed(outline) for outline in drawn.surfaces[kind]]
        whole = [Path.make_compound_path(*rings)] if rings else []
        order = 1 + number / len(SURFACES)
        axes.add_collection(PathCollection(whole, facecolor=COLOURS[kind], edgecolor="none", zorder=order))
    lines = {"linestyles": [DASHES], "colors": PAINT, "linewidths": 0.8, "zorder": PAINTED}
    axes.add_collection(LineCollection(_each(drawn.dashed), **lines))
    axes.add_collection(LineCollection(_each(drawn.dotted), **{**lines, "linestyles": "dotted"}))
    stripes = PolyCollection(_each(drawn.stripes), facecolors=PAINT, linewidths=0, zorder=PAINTED)
    axes.add_collection(stripes)
    if drawn.attribution:
        box = {"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1.0}
        axes.text(0.995, 0.005, drawn.attribution, transform=axes.transAxes, ha="right", va="bottom", fontsize=6,
                  zorder=LAST, bbox=box, parse_math=False)  # fmt: skip


def _points(outline: Outline) -> np.ndarray:
    return np.reshape(outline, (-1, 2))


def _each(outlines: Sequence[Outline]) -> list[np.ndarray]:
    return [_points(outline) for outline in outlines]


def _closed(outline: Outline) -> Path:
    return Path([*_points(outline), outline[:2]], closed=True)
