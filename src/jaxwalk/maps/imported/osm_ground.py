"""The roadway of OpenStreetMap's roads: bands around their curves, with rounded corners at junctions."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.imported.osm_tags import Side, parked
from jaxwalk.maps.imported.road_chains import ChainPiece, RoadChain
from jaxwalk.maps.imported.smoothing import with_rounded_corners

AROUND = 8.0
"""Corners are rounded this far around a junction's roadway [m]."""
LONGEST_MOUTH, STEP, PROBE = 25.0, 0.5, 0.05
"""A mouth is looked for so far from a junction, in such steps, this far beside the road [m]."""
WIDENED = 3.0
"""Where only lanes change, their ends are so far apart from the place [m]."""


def strip_width(piece: ChainPiece, side: Side) -> float:
    """Return the width of the parking strip at a side of a chain [m], 0 without one."""
    strip = parked(piece.way.tags, way_side(piece, side))
    return 0.0 if strip is None else strip[0]


def way_side(piece: ChainPiece, side: Side) -> Side:
    """Return which side of the way a side of the chain is."""
    return side if not piece.turned else "left" if side == "right" else "right"


def sides(chain: RoadChain, piece: ChainPiece) -> tuple[float, float]:
    """Return the distance of the right and of the left kerb from a chain's curve [m]."""
    half = chain.profile.width / 2
    return half + strip_width(piece, "right"), half + strip_width(piece, "left")


def band(chain: RoadChain, low: float, high: float, right: float, left: float) -> BaseGeometry:
    """Return the ground between two lines along a chain; ``right`` and ``left`` are metres to the left of its curve."""
    middle = chain.curve.parallel((right + left) / 2, low, high)
    return shapely.LineString(middle).buffer((left - right) / 2, cap_style="flat", join_style="round")


def raw_roadway(chains: Sequence[RoadChain]) -> BaseGeometry:
    """Return the union of all roads, with corners rounded at junctions."""
    whole = shapely.union_all(list(_bands(chains)))
    around = shapely.union_all([
        shapely.Point(place).buffer(reach + AROUND) for _, place, reach, count in junctions(chains) if count > 2
    ])  # fmt: skip
    return with_rounded_corners(whole, around)


def _bands(chains: Sequence[RoadChain]) -> Iterator[BaseGeometry]:
    for chain in chains:
        for piece in (piece for piece in chain.pieces if piece.end - piece.begin > 1e-3):
            right, left = sides(chain, piece)
            yield band(chain, piece.begin, piece.end, -right, left)
    for _, place, reach, count in junctions(chains):
        if count > 1:
            yield shapely.Point(place).buffer(reach)


def junctions(chains: Iterable[RoadChain]) -> Iterator[tuple[int, np.ndarray, float, int]]:
    """Yield each chain end: its node, its place (2,) [m], half the narrowest road's width, and the number of ends."""
    places: dict[int, np.ndarray] = {}
    widths: dict[int, list[float]] = defaultdict(list)
    for chain in chains:
        for end, node in enumerate(chain.ends):
            places[node] = chain.curve.points[-end]  # the first one, or the last
            widths[node].append(chain.profile.width / 2)
    for node, own in widths.items():
        yield node, places[node], min(own), len(own)


def mouths(chains: Sequence[RoadChain], roadway: BaseGeometry) -> list[tuple[float, float]]:
    """Return for each chain the places between which its kerbs run along it [m]."""
    counts = {node: count for node, _, _, count in junctions(chains)}
    shapely.prepare(roadway)
    found = []
    for chain in chains:
        begin, end = (_mouth(chain, n, counts[node], roadway) for n, node in enumerate(chain.ends))
        found.append((begin, chain.length - end))
    return found


def _mouth(chain: RoadChain, end: int, count: int, roadway: BaseGeometry) -> float:
    """Return how far from one end of a chain its kerbs begin to run along it [m]."""
    if count == 1:
        return 0.0
    if count == 2:
        return min(WIDENED, chain.length / 3)
    away = np.arange(0, min(LONGEST_MOUTH, chain.length), STEP)
    places = chain.length - away if end else away
    right, left = sides(chain, chain.pieces[-1 if end else 0])
    probes = np.concatenate([chain.curve.beside(places, left + PROBE), chain.curve.beside(places, -right - PROBE)])
    widened = shapely.contains_xy(roadway, probes).reshape(2, -1).any(axis=0)
    # The first place from which the kerbs are free for two metres: a parallel road farther off is no junction.
    free = np.convolve(widened, np.ones(4), "full")[3:][: len(away)] == 0
    return float(away[free.argmax()] if free.any() else away[-1]) + STEP
