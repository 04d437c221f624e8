"""The surfaces of a planned street: roadway with rounded kerbs, sidewalks, and the lines along which people walk."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.generated.curve import Curve
from jaxwalk.maps.generated.refusal import Refusal
from jaxwalk.maps.generated.town_plan import BEYOND, Profile, TownPlan, TownRoad

ROUNDING = 24
"""Points of a quarter of a circle."""
PROBE = 0.02
"""A kerb runs along its road where the ground at this distance beside the road is no roadway [m]."""
FINEST = 0.005
"""Curves are simplified by at most this [m]."""
FROM_EDGE = 1.0
"""People walk up to this distance from the street's edge [m]."""
FAR = 400.0
"""Longer than any street [m]."""


class Ground(NamedTuple):
    """Shapes [m]."""

    whole: shapely.Polygon
    """The roadway, going on beyond the street's edges; islands aren't cut out."""
    roadway: shapely.Polygon
    """The roadway up to the edges."""
    sidewalk: BaseGeometry
    walks: tuple[shapely.LineString, ...]
    """The middles of the sidewalks: a line for each piece of kerb from edge to edge."""


def lay_ground(plan: TownPlan) -> Ground:
    """Return the surfaces of a street. Raise Refusal if its roads meet where they shouldn't."""
    whole = _rounded(shapely.union_all(list(_bands(plan))), plan.kerb_radius).simplify(FINEST)
    edges = shapely.union_all([_edge_box(road, plan.sidewalk) for road in plan.roads if road.junctions[1] is None]
                              + [_edge_box(plan.roads[0], plan.sidewalk, at_begin=True)])  # fmt: skip
    roadway = whole.difference(edges)
    if not isinstance(whole, shapely.Polygon) or not isinstance(roadway, shapely.Polygon) or whole.interiors:
        raise Refusal("roads meet beyond their junctions")
    sidewalk = whole.buffer(plan.sidewalk, ROUNDING).simplify(FINEST).difference(whole).difference(edges)
    return Ground(whole, roadway, sidewalk, _walks(plan, whole))


def mouth(plan: TownPlan, ground: Ground, road: TownRoad, end: int) -> float:
    """Return the place on a road from which its kerbs run along it.

    Args:
        plan: the street.
        ground: its surfaces.
        road: one of its roads.
        end: 0 for the junction or edge at its begin, 1 for that at its end.
    """
    junction = road.junctions[end]
    if junction is None:
        return (road.begin, road.end)[end]
    away = np.arange(0, min(plan.bent[junction], road.length), 0.25)
    places = road.end - away if end else road.begin + away
    profile = road.profile
    probes = np.concatenate(
        [road.curve.beside(places, profile.left + PROBE), road.curve.beside(places, -profile.right - PROBE)]
    )
    widened = shapely.contains_xy(ground.whole, probes).reshape(2, -1).any(axis=0)
    last = away[widened].max(initial=0.0) + 0.5
    return float(road.end - last if end else road.begin + last)


def _bands(plan: TownPlan) -> Iterator[BaseGeometry]:
    """Yield the surface of the main street, and those of its arms from the middle of it."""
    main = plan.main
    yield _band(main, plan.roads[0].profile, -BEYOND, plan.main_length + BEYOND)
    for road in plan.roads[len(plan.junctions) + 1 :]:
        assert road.junctions[0] is not None
        place = plan.junctions[road.junctions[0]]
        side = float(np.sign(np.sin(road.curve.heading(0.0) - main.heading(place))))
        along = main.heading(place)
        ahead = np.array([np.cos(along), np.sin(along)])
        beside = side * np.array([-ahead[1], ahead[0]])
        middle = main.beside(place)
        half = shapely.Polygon(
            [middle - FAR * ahead, middle + FAR * ahead, middle + FAR * (ahead + beside),
             middle + FAR * (beside - ahead)]
        )  # fmt: skip
        yield _band(road.curve, road.profile, -BEYOND, road.end + BEYOND).intersection(half)


def _band(curve: Curve, profile: Profile, begin: float, end: float) -> shapely.Polygon:
    return shapely.Polygon(curve.band(-profile.right, profile.left, begin, end))


def _rounded(roads: BaseGeometry, radius: float) -> BaseGeometry:
    """Return roads whose inner corners are rounded."""
    return roads.buffer(radius, ROUNDING, join_style="mitre").buffer(-radius, ROUNDING)


def _edge_box(road: TownRoad, sidewalk: float, *, at_begin: bool = False, inward: float = 0.0) -> shapely.Polygon:
    """Return what lies beyond a street's edge at one end of a road."""
    place, sign = (road.begin, -1) if at_begin else (road.end, 1)
    heading, middle = road.curve.heading(place), road.curve.beside(place)
    out = sign * np.array([np.cos(heading), np.sin(heading)])
    aside = np.array([-out[1], out[0]]) * (max(road.profile.left, road.profile.right) + sidewalk + 1)
    near, far = middle - inward * out, middle + (BEYOND + sidewalk + 5) * out
    return shapely.Polygon([near - aside, near + aside, far + aside, far - aside])


def _walks(plan: TownPlan, whole: shapely.Polygon) -> tuple[shapely.LineString, ...]:
    """Return the middles of the sidewalks, up to `FROM_EDGE` from the edges."""
    beyond = [_edge_box(road, plan.sidewalk, inward=FROM_EDGE) for road in plan.roads if road.junctions[1] is None]
    beyond.append(_edge_box(plan.roads[0], plan.sidewalk, at_begin=True, inward=FROM_EDGE))
    ring = whole.buffer(plan.sidewalk / 2, ROUNDING)
    if not isinstance(ring, shapely.Polygon) or ring.interiors:
        raise Refusal("sidewalks meet beyond their junctions")
    lines = shapely.get_parts(shapely.line_merge(ring.exterior.difference(shapely.union_all(beyond))))
    if len(lines) != len(beyond):
        raise Refusal("roads meet at the street's edge")
    return tuple(lines)
