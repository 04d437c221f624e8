"""Where a street has crosswalks, of which kind, and where people may jaywalk beside them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import shapely

from jaxwalk.maps.generated.ground_shapes import FROM_EDGE, Ground
from jaxwalk.maps.generated.lane_paths import SlowStretch
from jaxwalk.maps.generated.refusal import Refusal
from jaxwalk.maps.generated.town import Town
from jaxwalk.maps.generated.town_plan import Dice, TownPlan, TownRoad
from jaxwalk.maps.network import CrossingType

FROM_MOUTH = 0.5
"""Distance of a crosswalk from the place where a junction's kerbs begin to bend [m]."""
FROM_CORNER, APART = 18.0, 28.0
"""Smallest distances of a crosswalk away from junctions from a mouth or the street's edge, and from others [m]."""
ISLAND_BEYOND, ISLAND_ASIDE = 1.2, 0.15
"""An island is longer than its crosswalk's width, and narrower than its median, by this at each end [m]."""
RAMP = 2.0
"""The stretch of a raised crosswalk goes on by this on both sides [m]."""
BESIDE = 1.0
"""Distance of a jaywalk zone from its crosswalk, from the next one, and from junctions [m]."""
SHORTEST_ZONE = 4.0
"""A shorter zone is left out [m]."""


@dataclass(frozen=True)
class Site:
    """A crosswalk on a road."""

    road: int
    at: float
    """Place of its middle on the road's curve [m]."""
    width: float
    """Along the road [m]."""
    kind: CrossingType
    island: bool
    outward: int
    """Its jaywalk zone leads along the road's curve (1) or back (-1)."""
    zone: tuple[float, float] | None = None
    """Where the jaywalk zone begins and ends: distances from the middle of the crosswalk [m]; None: there is none."""

    @property
    def half(self) -> float:
        """Half the length that it occupies along the road, with its island [m]."""
        return self.width / 2 + ISLAND_BEYOND * self.island


def choose_sites(
    town: Town, dice: Dice, plan: TownPlan, ground: Ground, mouths: list[tuple[float, float]]
) -> list[Site]:
    """Return a street's crosswalks with their zones. Raise Refusal if they can't join all sidewalks."""
    density = dice.between(town.crosswalks)
    drawn, others = [], []
    ends = [(n, road, end) for n, road in enumerate(plan.roads) for end in (0, 1) if road.junctions[end] is not None]
    for number, road, end in ends:
        site = _at_mouth(town, dice, road, number, (mouths[number], end))
        (drawn if dice.chance(density) else others).append(site)
    fitting = [site for site in drawn if _fits(site, mouths)]
    fitting = [site for site in fitting if not _collides(site, fitting)]
    chosen = [*fitting, *_joining(fitting, [site for site in others if _fits(site, mouths)], plan, ground)]
    for number, road in enumerate(plan.roads):
        chosen += _between(town, dice, road, number, (mouths[number], [x for x in chosen if x.road == number]))
    if _parts(chosen, plan, ground) > 1:
        raise Refusal("no room for the crosswalks that join all sidewalks")
    zones = [dice.between(town.zone_length) for _ in chosen]
    return [_with_zone(site, chosen, plan, (mouths[site.road], zone)) for site, zone in zip(chosen, zones, strict=True)]


def raised_stretches(sites: list[Site], plan: TownPlan, mouths: list[tuple[float, float]]) -> list[list[SlowStretch]]:
    """Return for each road the stretches of its raised crosswalks."""
    stretches: list[list[SlowStretch]] = [[] for _ in plan.roads]
    for site in sites:
        low, high = mouths[site.road]
        if site.kind == "raised":
            half = site.width / 2 + RAMP
            stretches[site.road].append(SlowStretch(max(site.at - half, low), min(site.at + half, high)))
    return stretches


def _draw_site(town: Town, dice: Dice, road: TownRoad, number: int, at: float, outward: int) -> Site:
    """Draw a crosswalk."""
    unmarked, raised = dice.chance(town.unmarked), dice.chance(town.raised)
    island = dice.chance(town.island) and road.profile.median > 0
    width = dice.between(town.crosswalk_width)
    return Site(number, at, width, "unmarked" if unmarked else "raised" if raised else "zebra", island, outward)


def _at_mouth(
    town: Town, dice: Dice, road: TownRoad, number: int, where: tuple[tuple[float, float], int]
) -> Site:  # fmt: skip
    """Draw the crosswalk at one end of a road, where a junction is."""
    ends, end = where
    outward = -1 if end else 1
    site = _draw_site(town, dice, road, number, 0.0, outward)
    return replace(site, at=ends[end] + outward * (FROM_MOUTH + site.half))


def _fits(site: Site, mouths: list[tuple[float, float]]) -> bool:
    low, high = mouths[site.road]
    return low <= site.at - site.half and site.at + site.half <= high


def _collides(site: Site, sites: list[Site]) -> bool:
    """Return whether there is an earlier site too close on the same road."""
    earlier = sites[: sites.index(site)]
    return any(x.road == site.road and abs(x.at - site.at) < x.half + site.half + 4 * BESIDE for x in earlier)


def _joining(chosen: list[Site], others: list[Site], plan: TownPlan, ground: Ground) -> Iterator[Site]:
    """Yield those of the other sites that are needed to join all sidewalks."""
    taken = list(chosen)
    for site in others:
        needed = _parts([*taken, site], plan, ground) < _parts(taken, plan, ground)
        if needed and not _collides(site, [*taken, site]):
            taken.append(site)
            yield site


def _parts(sites: list[Site], plan: TownPlan, ground: Ground) -> int:
    """Return into how many parts the sidewalks fall, which crosswalks don't join."""
    groups = list(range(len(ground.walks)))
    for site in sites:
        one, other = (groups[nearest_walk(ground, point)] for point in landings(plan, site))
        groups = [one if group == other else group for group in groups]
    return len(set(groups))


def nearest_walk(ground: Ground, point: np.ndarray) -> int:
    """Return which of the sidewalks' middles is nearest to a point (2,)."""
    return int(np.argmin(shapely.distance(np.array(ground.walks), shapely.Point(point))))


def landings(plan: TownPlan, site: Site, ahead: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return the middles (2,) of the right and left sidewalk, ``ahead`` metres along the curve from the site."""
    road = plan.roads[site.road]
    aside = plan.sidewalk / 2
    right, left = -road.profile.right - aside, road.profile.left + aside
    return road.curve.beside(site.at + ahead, right), road.curve.beside(site.at + ahead, left)


def _between(
    town: Town, dice: Dice, road: TownRoad, number: int, where: tuple[tuple[float, float], list[Site]]
) -> Iterator[Site]:  # fmt: skip
    """Yield crosswalks of a road away from junctions; a street without junction has at least one."""
    (low, high), sites = where
    count = int(dice.between(town.middle_crosswalks) * (high - low) / 100 + dice.between((0.0, 1.0)))
    alone = road.junctions == (None, None)
    count = max(count, 1) if alone else count
    taken = [site.at for site in sites]
    for n in range(count):
        share = (n + dice.between((0.3, 0.7))) / count
        at = low + FROM_CORNER + share * max(high - low - 2 * FROM_CORNER, 0)
        site = _draw_site(town, dice, road, number, at, dice.sign())
        if low + FROM_CORNER <= at <= high - FROM_CORNER and all(abs(at - other) >= APART for other in taken):
            taken.append(at)
            yield site


def _with_zone(site: Site, sites: list[Site], plan: TownPlan, where: tuple[tuple[float, float], float]) -> Site:
    """Return a site with its jaywalk zone, if there is room for one."""
    ends, length = where
    road, side = plan.roads[site.road], int(site.outward > 0)
    edge = 0.0 if road.junctions[side] is not None else FROM_EDGE
    room = abs(ends[side] - site.at) - edge - BESIDE
    for other in sites:
        away = (other.at - site.at) * site.outward
        if other.road == site.road and away > 0:
            # Zones that lead toward each other share the way between.
            gap = away - other.half - BESIDE
            room = min(room, gap if other.outward == site.outward else (away + site.half - other.half) / 2 - BESIDE / 2)
    begin = site.half + BESIDE
    end = min(begin + length, room - 0.5)
    return replace(site, zone=(begin, end) if end - begin >= SHORTEST_ZONE else None)
