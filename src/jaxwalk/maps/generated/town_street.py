"""A street from its number: the plan is drawn, laid out, and checked."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.generated.check_town import refuse_faults
from jaxwalk.maps.generated.crossing_sites import ISLAND_BEYOND, Site, choose_sites, raised_stretches
from jaxwalk.maps.generated.ground_shapes import ROUNDING, Ground, lay_ground, mouth
from jaxwalk.maps.generated.kerbside import buildings, parking_strips
from jaxwalk.maps.generated.lane_paths import make_lanes, make_routes
from jaxwalk.maps.generated.town import Town
from jaxwalk.maps.generated.town_plan import Dice, TownPlan, draw_plan
from jaxwalk.maps.generated.town_walks import island_width, make_walks
from jaxwalk.maps.network import Area, AreaKind, Lane, Network, WalkGraph

AROUND = 2.0
"""Empty ground around everything [m]."""
DIGITS = 4
"""Digits after the point of all positions [m]."""


class TownStreet(NamedTuple):
    """A street of a family."""

    number: int
    layout: str
    network: Network


def make_street(town: Town, number: int) -> TownStreet:
    """Return the street of a number: the same one on every machine.

    Raises:
        Refusal: the number's street can't be driven or walked; the message says why.
        ValueError: the number is negative, or needs more than 63 bits.
    """
    dice = Dice(town, number)
    plan = draw_plan(town, dice)
    ground = lay_ground(plan)
    mouths = [(mouth(plan, ground, road, 0), mouth(plan, ground, road, 1)) for road in plan.roads]
    sites = choose_sites(town, dice, plan, ground, mouths)
    areas, crosswalks = _areas(plan, ground, sites)
    areas += [_area("parking", shapely.Polygon(outline)) for outline in parking_strips(plan, mouths, sites)]
    areas += [_area("building", shape) for shape in buildings(town, dice, plan, ground)]
    lanes = make_lanes(plan, ground.whole, mouths, raised_stretches(sites, plan, mouths))
    walk, crossings = make_walks(plan, ground, sites, crosswalks)
    network = _placed(Network((1.0, 1.0), lanes, tuple(areas), walk, crossings, make_routes(lanes)))
    refuse_faults(network)
    return TownStreet(number, plan.layout, network)


def _area(kind: AreaKind, shape: shapely.Polygon) -> Area:
    outline, *holes = (shapely.get_coordinates(ring)[:-1] for ring in (shape.exterior, *shape.interiors))
    return Area(kind, outline, tuple(holes))


def _areas(plan: TownPlan, ground: Ground, sites: list[Site]) -> tuple[list[Area], list[tuple[int, ...]]]:
    """Return roadway, sidewalks, islands and crosswalks; and for each site the numbers of its crosswalks."""
    islands = {number: _island(plan, site) for number, site in enumerate(sites) if site.island}
    roadway = ground.roadway.difference(shapely.union_all(list(islands.values())))
    areas = [_area("roadway", part) for part in _parts(roadway)]
    areas += [_area("sidewalk", part) for part in _parts(ground.sidewalk)]
    areas += [_area("island", shape) for shape in islands.values()]
    crosswalks = []
    for number, site in enumerate(sites):
        road = plan.roads[site.road]
        stretch = site.at - site.width / 2, site.at + site.width / 2
        shape = shapely.Polygon(road.curve.band(-road.profile.right, road.profile.left, *stretch))
        parts = list(_parts(shape.difference(islands[number]) if number in islands else shape))
        crosswalks.append(tuple(range(len(areas), len(areas) + len(parts))))
        areas += [_area("crosswalk", part) for part in parts]
    return areas, crosswalks


def _parts(shape: BaseGeometry) -> Iterator[shapely.Polygon]:
    """Yield the polygons of a shape, without slivers."""
    yield from (part for part in shapely.get_parts(shape).tolist() if part.area > 0.1)


def _island(plan: TownPlan, site: Site) -> shapely.Polygon:
    """Return the shape of a crosswalk's island: rounded at both ends."""
    road = plan.roads[site.road]
    half = island_width(road.profile.median) / 2
    reach = site.width / 2 + ISLAND_BEYOND - half
    if reach <= 0:
        return shapely.Point(road.curve.beside(site.at)).buffer(half, ROUNDING)
    return shapely.LineString(road.curve.parallel(0.0, site.at - reach, site.at + reach)).buffer(half, ROUNDING)


def _placed(network: Network) -> Network:
    """Return a network moved so that everything lies from (0, 0) to its size."""
    outlines = np.concatenate([area.outline for area in network.areas])
    low, high = outlines.min(axis=0) - AROUND, outlines.max(axis=0) + AROUND
    width, height = (high - low).tolist()

    def moved(points: np.ndarray) -> np.ndarray:
        return np.round(points - low, DIGITS)

    walk = network.walk
    return Network(
        size=(round(width, DIGITS), round(height, DIGITS)),
        lanes=tuple(Lane(moved(x.line), x.width, x.speed_limit, x.successors) for x in network.lanes),
        areas=tuple(Area(x.kind, moved(x.outline), tuple(moved(hole) for hole in x.holes)) for x in network.areas),
        walk=WalkGraph(moved(walk.nodes), walk.edges, walk.waypoints),
        crossings=network.crossings,
        routes=network.routes,
    )
