"""What stands beside and on a street: parking strips, and buildings."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, product

import numpy as np
import shapely

from jaxwalk.maps.generated.crossing_sites import Site
from jaxwalk.maps.generated.ground_shapes import Ground
from jaxwalk.maps.generated.town import Town
from jaxwalk.maps.generated.town_plan import Dice, TownPlan, TownRoad

FROM_CROSSWALK, FROM_MOUTH = 5.0, 8.0
"""Nobody parks this close to a crosswalk, or to the place where a junction's kerbs begin to bend [m]."""
SHORTEST_STRIP = 6.0
"""A shorter parking strip is left out [m]."""
GAP, DEPTH = (1.0, 8.0), (8.0, 14.0)
"""Distance between two plots, and depth of a building [m]."""
SMALLEST = 40.0
"""A smaller building is left out [m2]."""
NEAREST = 0.02
"""Smallest distance of a building from the sidewalk, whose outline is simplified by less [m]."""
GRID = 0.001
"""Corners of buildings are rounded to this [m]: shapely fails on edges that nearly coincide, but not on a grid."""
AROUND = 12.0
"""Ground beyond the sidewalks on which buildings may stand [m]."""


def parking_strips(plan: TownPlan, mouths: list[tuple[float, float]], sites: list[Site]) -> Iterator[np.ndarray]:
    """Yield the outlines of parking strips: clear of crosswalks and junctions."""
    for number, (road, (low, high)) in enumerate(zip(plan.roads, mouths, strict=True)):
        begin, end = (x is not None for x in road.junctions)
        free = _free(low + FROM_MOUTH * begin, high - FROM_MOUTH * end, [x for x in sites if x.road == number])
        right, left = road.profile.parking
        sides = [(-road.profile.right, -road.profile.right + right), (road.profile.left - left, road.profile.left)]
        strips = product(free, [side for side in sides if side[1] > side[0]])
        yield from (road.curve.band(*side, *stretch) for stretch, side in strips)


def _free(low: float, high: float, sites: list[Site]) -> Iterator[tuple[float, float]]:
    """Yield the stretches between crosswalks."""
    for site in sorted(sites, key=lambda x: x.at):
        if site.at - site.half - FROM_CROSSWALK - low >= SHORTEST_STRIP:
            yield low, site.at - site.half - FROM_CROSSWALK
        low = max(low, site.at + site.half + FROM_CROSSWALK)
    if high - low >= SHORTEST_STRIP:
        yield low, high


def buildings(town: Town, dice: Dice, plan: TownPlan, ground: Ground) -> Iterator[shapely.Polygon]:
    """Yield buildings: on plots along all roads, off the sidewalks, and apart."""
    bounds = shapely.union_all([ground.roadway, ground.sidewalk]).bounds
    within = shapely.box(bounds[0] - AROUND, bounds[1] - AROUND, bounds[2] + AROUND, bounds[3] + AROUND)
    distance = max(dice.between(town.building_distance), NEAREST)
    taken = ground.whole.buffer(plan.sidewalk + distance, join_style="mitre")
    beyond = plan.sidewalk + distance
    plots = [_plots(town, dice, road, side * beyond) for road in plan.roads for side in (1, -1)]
    for plot in chain.from_iterable(plots):
        shape = shapely.intersection(shapely.difference(plot, taken, grid_size=GRID), within, grid_size=GRID)
        if dice.chance(town.building) and isinstance(shape, shapely.Polygon) and shape.area > SMALLEST:
            taken = shapely.union(taken, shape.buffer(GAP[0], join_style="mitre"), grid_size=GRID)
            yield shape


def _plots(town: Town, dice: Dice, road: TownRoad, beyond: float) -> Iterator[shapely.Polygon]:
    """Yield rectangles along one side of a road; ``beyond`` is how far from the kerb, positive at the left [m]."""
    kerb = road.profile.left if beyond > 0 else -road.profile.right
    at = road.begin
    while at < road.end:
        length, depth = dice.between(town.building_length), dice.between(DEPTH)
        middle = road.curve.heading(at + length / 2)
        ahead = np.array([np.cos(middle), np.sin(middle)])
        out = np.sign(beyond) * np.array([-ahead[1], ahead[0]])
        front = road.curve.beside(at + length / 2, kerb + beyond)
        ends = [front - length / 2 * ahead, front + length / 2 * ahead]
        yield shapely.Polygon([ends[0], ends[1], ends[1] + depth * out, ends[0] + depth * out])
        at += length + dice.between(GAP)
