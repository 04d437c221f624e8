"""A picture of a street from above: its ground, its lanes, and where people walk, cross and may jaywalk."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PatchCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

from jaxwalk.maps.network import Area, Crossing, Network, along
from jaxwalk.maps.network_zones import ZoneLines
from jaxwalk.viewer.ground import BLOCK, PAINT, ROAD, SIDEWALK, STRIPE
from jaxwalk.writing import whole

BUILDING, PARKING, ISLAND, RAISED = "#d8cfc0", "#84888f", "#8fbb78", "#b98b73"
LANE, WALK, ZONE = "#2f6fb0", "#3c7a3c", "#e08a2e"
"""Colours of kinds of ground; of lanes' middles, walkways and jaywalk zones."""
ORDER = {"building": 1, "sidewalk": 1, "roadway": 2, "parking": 3, "island": 4}
COLOURS = {"building": BUILDING, "sidewalk": SIDEWALK, "roadway": ROAD, "parking": PARKING, "island": ISLAND}
INCHES, DOTS = 7.0, 110
"""Longer side of a picture, and dots per inch."""
ARROWS = 25.0
"""Distance between a lane's arrows [m]."""
ACROSS = 12
"""Places at which a jaywalk zone is drawn."""


def draw_street(axes: Axes, network: Network) -> None:
    """Draw a street in metres, x to the east, y to the north."""
    axes.set_facecolor(BLOCK)
    axes.set_xlim(0, network.size[0])
    axes.set_ylim(0, network.size[1])
    axes.set_aspect("equal")
    for kind, order in ORDER.items():
        shapes = [area for area in network.areas if area.kind == kind]
        _fill(axes, [_outline(area) for area in shapes], COLOURS[kind], order)
    for crossing in network.crossings:
        _draw_crossing(axes, network, crossing)
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


def _outline(area: Area) -> PathPatch:
    """Return an area with its holes as matplotlib draws it."""
    rings = shapely.get_rings(shapely.orient_polygons(area.shape()))
    return PathPatch(Outline.make_compound_path(*(Outline(shapely.get_coordinates(x), closed=True) for x in rings)))


def _fill(axes: Axes, patches: list[PathPatch], colour: str, order: int) -> None:
    axes.add_collection(PatchCollection(patches, facecolor=colour, edgecolor="none", zorder=order))


def _draw_crossing(axes: Axes, network: Network, crossing: Crossing) -> None:
    """Draw a crossing's stripes, or the dashed edges of one without markings, and its jaywalk zone."""
    way = network.walk.nodes[list(crossing.nodes)]
    for number in crossing.areas:
        area = network.areas[number]
        if crossing.kind == "raised":
            _fill(axes, [_outline(area)], RAISED, 3)
        if crossing.kind == "unmarked":
            sides = list(_along_sides(area, way))
            axes.add_collection(LineCollection(sides, linestyles="dotted", colors=PAINT, linewidths=0.8, zorder=4))
        else:
            axes.add_collection(PolyCollection(list(_stripes(area, way)), facecolors=PAINT, linewidths=0, zorder=4))
    if crossing.zone is not None:
        lines = ZoneLines.of(network, crossing.zone)
        places = np.linspace(crossing.zone.begin, crossing.zone.end, ACROSS)
        sides = [np.array([lines.at(side, place) for place in places]) for side in (0, 1)]
        axes.fill(*np.concatenate([sides[0], sides[1][::-1]]).T, color=ZONE, alpha=0.3, linewidth=0, zorder=5)


def _frame(way: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return where a crossing begins, and the unit vectors across the roadway and along it."""
    across = (way[-1] - way[0]) / np.linalg.norm(way[-1] - way[0])
    return way[0], across, np.array([-across[1], across[0]])


def _stripes(area: Area, way: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the outlines of a crosswalk's stripes: along the road, side by side from kerb to kerb."""
    origin, across, ahead = _frame(way)
    over, beside = (area.outline - origin) @ across, (area.outline - origin) @ ahead
    shape = area.shape()
    for begin in np.arange(over.min() + STRIPE / 2, over.max() - STRIPE / 2, 2 * STRIPE):
        ends = [(begin, beside.min()), (begin + STRIPE, beside.min()),
                (begin + STRIPE, beside.max()), (begin, beside.max())]  # fmt: skip
        stripe = shapely.Polygon([origin + a * across + b * ahead for a, b in ends]).intersection(shape)
        yield from (shapely.get_coordinates(part) for part in shapely.get_parts(stripe) if part.area > 0)


def _along_sides(area: Area, way: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the two sides of a crosswalk that lead over the roadway."""
    origin, across, ahead = _frame(way)
    over, beside = (area.outline - origin) @ across, (area.outline - origin) @ ahead
    for place in (beside.min(), beside.max()):
        yield np.array([origin + a * across + place * ahead for a in (over.min(), over.max())])


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
