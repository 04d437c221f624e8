"""The ground of Lanelet2 maps: lanelets side by side, what lies between them in junctions, and where roads go on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.imported.kerb_ground import WIDEST_MEDIAN, polygons, surface, unit
from jaxwalk.maps.imported.lanelet_reading import LaneletFile
from jaxwalk.maps.imported.lanelet_shapes import USES, AreaShape, LaneletShape, beside
from jaxwalk.maps.imported.mapped_lanes import beyond_end
from jaxwalk.maps.imported.smoothing import with_rounded_corners

KERBS = ("curbstone", "road_border", "wall", "fence", "guard_rail", "jersey_barrier")
"""Types of lines at which a roadway ends."""
SOLID = ("traffic_island", "vegetation", "building")
"""Subtypes of areas that are no roadway."""
OVERLAP = 0.3
"""Lanelets lie over each other, as at forks and in junctions, if they do for more than twice this [m]."""
ALONG, HALF = 3.0, 0.5
"""A parking area that touches the roadway for longer than ``ALONG`` is a part of it [m], and a lane for bicycles if it
does so along half of its length too."""
AROUND_JUNCTION, AROUND_CORNERS = 4.0, 2.0
"""A junction's region reaches this far beyond it; its corners are rounded this far around it [m]."""
AT_KERB, KERB_SHARE = 0.3, 0.25
"""A gap in a junction is none of the roadway if more than this share of its edge is a kerb, this close [m]."""
PROBE = 1.0
"""A lanelet's end is where the road ends if so far beyond it there is no roadway [m]."""
ACROSS, NEAR_END = 0.6, 0.5
"""A road ends for good where kerbs run along this share of its end, this close [m]."""
FINEST = 0.02
"""Bounds are simplified by at most this [m]."""


class LaneletGround(NamedTuple):
    """The ground of a map."""

    roadway: BaseGeometry
    inner: frozenset[int]
    """Which of the driven lanelets lie over others, as in junctions."""
    junctions: tuple[BaseGeometry, ...]
    """Regions that no street's edge may cut."""
    parts: frozenset[int]
    """Numbers of the lanelets and areas on which nobody drives that are a part of the roadway."""
    kerbs: tuple[shapely.LineString, ...]


def lanelet_ground(
    file: LaneletFile, driven: Sequence[LaneletShape], others: Sequence[LaneletShape], areas: Sequence[AreaShape]
) -> LaneletGround:
    """Return the ground of a map of driven lanelets and ``others``."""
    lanes = shapely.union_all([x.shape for x in driven] + [x.shape for x in others if x.use == "roadway"])
    ways = [(x.number, x.shape, max(ALONG, HALF * shapely.length(shapely.LineString(x.middle)))) for x in others
            if x.use == "beside"]  # fmt: skip
    parts = beside(ways, lanes)
    ground = shapely.union_all([lanes, *(shape for number, shape, _ in ways if number in parts)])
    bays = [(x.number, x.shape, ALONG) for x in areas if USES.get(x.subtype) == "beside"]
    parts |= beside(bays, ground)
    ground = shapely.union_all([ground, *(shape for number, shape, _ in bays if number in parts)]).simplify(FINEST)
    inner = frozenset(_over_each_other([x.shape for x in driven], [x.number for x in driven]))
    clusters = polygons(shapely.union_all([driven[n].shape for n in inner]))
    lines = [line for line in file.lines.values() if line.tags.get("type") in KERBS]
    kerbs = tuple(shapely.LineString(line.points) for line in lines)
    solid = [x.shape for x in areas if x.subtype in SOLID or USES.get(x.subtype) == "walk"]
    solid += [x.shape for x in others if x.use == "walk"]
    roadway = ground if not clusters else _filled(ground, clusters, kerbs, shapely.union_all(solid))
    regions = tuple(shapely.Polygon(x.exterior).buffer(AROUND_JUNCTION) for x in clusters)
    parts |= {x.number for x in others if x.use == "roadway"}
    return LaneletGround(surface(roadway.difference(_islands(areas))), inner, regions, frozenset(parts), kerbs)


def _islands(areas: Sequence[AreaShape]) -> BaseGeometry:
    return shapely.union_all([x.shape for x in areas if x.subtype == "traffic_island"])


def _over_each_other(shapes: Sequence[BaseGeometry], numbers: Sequence[int]) -> set[int]:
    """Return which shapes lie over others of another number, and not only at their edges."""
    one, other = shapely.STRtree(shapes).query(shapes, "intersects") if shapes else (np.zeros(0, int),) * 2
    pairs = [(a, b) for a, b in zip(one.tolist(), other.tolist(), strict=True) if a < b and numbers[a] != numbers[b]]
    over = [(a, b) for a, b in pairs if not shapes[a].intersection(shapes[b]).buffer(-OVERLAP).is_empty]
    return {n for pair in over for n in pair}


def _filled(
    ground: BaseGeometry, clusters: Sequence[shapely.Polygon], kerbs: Sequence[BaseGeometry], solid: BaseGeometry
) -> BaseGeometry:
    """Return a roadway with the corners of junctions and the gaps in them that aren't bounded by kerbs."""
    around = shapely.union_all([x.buffer(AROUND_CORNERS) for x in clusters])
    rounded = with_rounded_corners(ground, around)
    holes = [shapely.Polygon(ring) for part in polygons(rounded) for ring in part.interiors]
    narrow = [x for x in holes if around.intersects(x) and x.buffer(-WIDEST_MEDIAN / 2).is_empty]
    tree = shapely.STRtree(list(kerbs))
    gaps = polygons(shapely.union_all([rounded, *narrow]).difference(ground))
    return shapely.union_all([ground, *(gap for gap in gaps if not _is_kept(gap, tree, solid))])


def _is_kept(gap: BaseGeometry, kerbs: shapely.STRtree, solid: BaseGeometry) -> bool:
    """Return whether a gap between lanelets is no roadway: kerbs run around it, or something is mapped there."""
    if gap.intersection(solid).area > KERB_SHARE * gap.area:
        return True
    near = gap.buffer(AT_KERB)
    own = shapely.union_all(kerbs.geometries[kerbs.query(near)].tolist())
    return gap.boundary.intersection(own.buffer(AT_KERB)).length > KERB_SHARE * gap.boundary.length


def open_ends_of(driven: Sequence[LaneletShape], ground: LaneletGround) -> Iterator[BaseGeometry]:
    """Yield a region across each end of a road that no kerb closes: maps end where nobody has surveyed."""
    kerbs = shapely.STRtree(list(ground.kerbs))
    shapely.prepare(ground.roadway)
    for lanelet in (x for one in driven for x in (one, one.turned())):
        last = lanelet.middle[-1]
        beyond = last + PROBE * unit(last - lanelet.middle[-2])
        if not shapely.intersects_xy(ground.roadway, *beyond) and not _is_closed(lanelet, kerbs):
            yield beyond_end(lanelet.middle, lanelet.width)


def _is_closed(lanelet: LaneletShape, kerbs: shapely.STRtree) -> bool:
    """Return whether a kerb runs across the end of a lanelet."""
    across = shapely.LineString([lanelet.left[-1], lanelet.right[-1]])
    near = across.buffer(NEAR_END)
    closing = shapely.union_all(kerbs.geometries[kerbs.query(near)].tolist()).intersection(near)
    return closing.length >= ACROSS * across.length
