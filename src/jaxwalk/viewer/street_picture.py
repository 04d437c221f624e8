"""A picture of a street from above: its ground, its lanes, and where people walk, cross and may jaywalk."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from jaxwalk.maps.network import JaywalkZone, Network, along
from jaxwalk.maps.network_zones import ZoneLines
from jaxwalk.viewer.ground import draw_ground
from jaxwalk.writing import whole

LANE, WALK, ZONE = "#2f6fb0", "#3c7a3c", "#e08a2e"
"""Colours of lanes' middles, walkways and jaywalk zones."""
INCHES, DOTS = 7.0, 110
"""Longer side of a picture, and dots per inch."""
ARROWS = 25.0
"""Distance between a lane's arrows [m]."""
ACROSS = 12
"""Places at which a jaywalk zone is drawn."""


def draw_street(axes: Axes, network: Network) -> None:
    """Draw a street in metres, x to the east, y to the north."""
    draw_ground(axes, network)
    for crossing in network.crossings:
        if crossing.zone is not None:
            _draw_zone(axes, network, crossing.zone)
    _draw_lanes(axes, network)
    edges = network.walk.nodes[network.walk.edges]
    axes.add_collection(LineCollection(list(edges), colors=WALK, linewidths=0.7, zorder=7))
    axes.scatter(*network.walk.nodes[: network.walk.waypoints].T, s=5, color=WALK, linewidths=0, zorder=8)


def street_picture(network: Network, path: Path, title: str) -> None:
    """Write a picture of a street; the file appears whole or not at all."""
    figure = Figure(figsize=_size(network), dpi=DOTS, layout="constrained")
    _titled(figure.add_subplot(), network, title)
    _write(figure, path)


def contact_sheet(networks: Sequence[tuple[str, Network]], path: Path, columns: int = 4) -> None:
    """Write one picture of several streets with their titles."""
    rows = -(-len(networks) // columns)
    columns = min(columns, len(networks))
    figure = Figure(figsize=(4 * columns, 4 * rows), dpi=70, layout="constrained")
    for number, (title, network) in enumerate(networks):
        _titled(figure.add_subplot(rows, columns, number + 1), network, title)
    _write(figure, path)


def _titled(axes: Axes, network: Network, title: str) -> None:
    draw_street(axes, network)
    axes.set_title(title, fontsize=9, parse_math=False)
    axes.tick_params(labelsize=7)


def _size(network: Network) -> tuple[float, float]:
    """Return the size of a picture [inch]."""
    width, height = (INCHES * side / max(network.size) for side in network.size)
    return max(width, 2.0) + 0.4, max(height, 2.0) + 0.5


def _write(figure: Figure, path: Path) -> None:
    FigureCanvasAgg(figure)
    with whole(path) as unfinished:
        figure.savefig(unfinished)


def _draw_zone(axes: Axes, network: Network, zone: JaywalkZone) -> None:
    lines = ZoneLines.of(network, zone)
    places = np.linspace(zone.begin, zone.end, ACROSS)
    sides = [np.array([lines.at(side, place) for place in places]) for side in (0, 1)]
    axes.fill(*np.concatenate([sides[0], sides[1][::-1]]).T, color=ZONE, alpha=0.3, linewidth=0, zorder=5)


def _draw_lanes(axes: Axes, network: Network) -> None:
    """Draw the middles of lanes with arrows in the direction of travel."""
    lines = [lane.line for lane in network.lanes]
    axes.add_collection(LineCollection(lines, colors=LANE, linewidths=0.8, zorder=6))
    heads = []
    for line in lines:
        metres = along(line)
        for at in np.arange(min(5.0, metres[-1] / 2), metres[-1], ARROWS):
            piece = int(np.clip(np.searchsorted(metres, at) - 1, 0, len(line) - 2))
            ahead = (line[piece + 1] - line[piece]) / (metres[piece + 1] - metres[piece])
            heads.append((*(np.array([np.interp(at, metres, line[:, k]) for k in (0, 1)])), *ahead))
    x, y, u, v = np.array(heads).T
    axes.quiver(x, y, u, v, color=LANE, angles="xy", scale_units="xy", scale=0.5, width=1.2, units="xy",
                headwidth=2.2, headlength=2.2, headaxislength=2.2, minlength=0, zorder=6)  # fmt: skip
