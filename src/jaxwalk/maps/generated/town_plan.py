"""What a street is, before it is drawn: its roads with their cross-sections and junctions. All chances are drawn here
or with the plan's `Dice`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numpy as np

from jaxwalk.maps.generated.curve import Curve
from jaxwalk.maps.generated.refusal import Refusal
from jaxwalk.maps.generated.town import Range, Town

BEYOND = 15.0
"""Roads go on straight beyond the street's edges, where they are cut [m]."""
ROOM = 1.0
"""Roads are straight for this much longer than the kerbs of their junctions bend [m]."""
BETWEEN = 16.0
"""Room for crosswalks between two junctions' kerbs [m]."""
FARTHEST_TURN = 0.8
"""A bend turns by at most this [rad]; then the road goes on straight."""
LONGEST_BEND = 60.0
"""A longer way between junctions or edges has two bends [m]."""
Item = TypeVar("Item")


class Dice:
    """Random numbers of one street: they depend on the family's parameters and the street's number alone."""

    def __init__(self, town: Town, number: int) -> None:
        """Key a generator by family and number. Raise ValueError if the number is negative or needs over 63 bits."""
        if not 0 <= number < 2**63:
            raise ValueError(f"the number of a street must lie in [0, 2^63), not {number}")
        self._generator = np.random.Generator(np.random.Philox(key=np.array([int(town.hash, 16), number], np.uint64)))

    def between(self, limits: Range) -> float:
        """Draw a number."""
        return limits[0] + (limits[1] - limits[0]) * float(self._generator.random())

    def chance(self, probability: float) -> bool:
        """Return True with a probability."""
        return float(self._generator.random()) < probability

    def one_of(self, items: Sequence[Item]) -> Item:
        """Draw one of several things."""
        return items[int(self._generator.random() * len(items))]

    def sign(self) -> int:
        """Return 1 or -1."""
        return self.one_of((1, -1))


@dataclass(frozen=True)
class Profile:
    """A road's cross-section. Forward is the direction of its curve; lengths are metres, positive to the left."""

    forward: int
    """Lanes."""
    backward: int
    lane_width: float
    median: float
    """Width of the median; 0 without."""
    parking: tuple[float, float]
    """Widths of the parking strips at the right and at the left; 0 without."""

    @property
    def _middle(self) -> tuple[float, float]:
        """Where forward lanes end at the left, and backward lanes at the right."""
        if self.forward and self.backward:
            return -self.median / 2, self.median / 2
        half = self.lane_width * (self.forward + self.backward) / 2
        return half, -half

    @property
    def right(self) -> float:
        """Distance of the right kerb from the curve [m]."""
        left_end, right_end = self._middle
        lanes = self.forward * self.lane_width - left_end if self.forward else -right_end
        return lanes + self.parking[0]

    @property
    def left(self) -> float:
        """Distance of the left kerb from the curve [m]."""
        left_end, right_end = self._middle
        lanes = self.backward * self.lane_width + right_end if self.backward else left_end
        return lanes + self.parking[1]

    def lane(self, forward: bool, number: int) -> float:
        """Return where the middle of a lane lies; lanes of a direction count from the leftmost, seen by a driver."""
        left_end, right_end = self._middle
        inward = (number + 0.5) * self.lane_width
        return left_end - inward if forward else right_end + inward


@dataclass(frozen=True)
class TownRoad:
    """A piece of road between junctions or edges: a part of a curve."""

    curve: Curve
    begin: float
    end: float
    profile: Profile
    speed_limit: float
    junctions: tuple[int | None, int | None]
    """Junction at its begin and end; None: the street's edge."""

    @property
    def length(self) -> float:
        """Its length [m]."""
        return self.end - self.begin


class SideArm(NamedTuple):
    """A side street to be."""

    side: int
    """1: to the left of the main street; -1: to the right."""
    angle: float
    """Angle between both [rad]."""
    profile: Profile


@dataclass(frozen=True)
class TownPlan:
    """The roads of a street. The first ones make up the main street, the others are its arms."""

    layout: str
    main: Curve
    main_length: float
    roads: tuple[TownRoad, ...]
    junctions: tuple[float, ...]
    """Places of the junctions on the main street."""
    bent: tuple[float, ...]
    """How far from each junction's middle kerbs may bend [m]."""
    kerb_radius: float
    sidewalk: float
    """Width of the sidewalks [m]."""


def draw_plan(town: Town, dice: Dice) -> TownPlan:
    """Draw the roads of a street. Raise Refusal if its junctions don't fit into it."""
    layout, length = dice.one_of(town.layouts), dice.between(town.main_length)
    radius, sidewalk = dice.between(town.kerb_radius), dice.between(town.sidewalk_width)
    profile, limit = _draw_profile(town, dice, town.lanes), dice.one_of(town.speed_limits)
    arms = _draw_arms(town, dice, layout)
    straight = [max(_bent(profile, arm, radius) for arm in around) for around in arms]
    places = _place_junctions(town, dice, length, straight)
    main = Curve.of(np.zeros(2), dice.between((0.0, 2 * np.pi)), _main_pieces(town, dice, places, straight, length),
                    first=-BEYOND)  # fmt: skip
    ends = [(0.0, None), *((place, n) for n, place in enumerate(places)), (length, None)]
    roads = [TownRoad(main, a, b, profile, limit, (one, other)) for (a, one), (b, other) in pairwise(ends)]
    for number, around in enumerate(arms):
        for arm in around:
            curve, end = _draw_side_street(town, dice, arm, (main, places[number]), straight[number])
            slower = [x for x in town.speed_limits if x <= limit]
            roads.append(TownRoad(curve, 0.0, end, arm.profile, dice.one_of(slower), (number, None)))
    return TownPlan(layout, main, length, tuple(roads), tuple(places), tuple(straight), radius, sidewalk)


def _draw_arms(town: Town, dice: Dice, layout: str) -> list[list[SideArm]]:
    """Return the arms of each junction, in the order of the main street."""

    def arm(side: int, angle: float) -> SideArm:
        return SideArm(side, float(np.deg2rad(angle)), _draw_profile(town, dice, town.arm_lanes))

    side = dice.sign()
    angle, other = dice.between(town.angle), dice.between(town.angle)
    if layout == "skewed":
        skewed = dice.between(town.skewed_angle)
        return [[arm(side, skewed), arm(-side, skewed)]]
    if layout == "block":
        both = [[arm(1, angle), arm(-1, angle)], [arm(side, other)]]
        return both if dice.chance(0.5) else both[::-1]
    arms: dict[str, list[list[SideArm]]] = {
        "straight": [],
        "tee": [[arm(side, angle)]],
        "cross": [[arm(side, angle), arm(-side, other)]],
        "staggered": [[arm(side, angle)], [arm(-side, other)]],
    }
    return arms[layout]


def _bent(profile: Profile, arm: SideArm, radius: float) -> float:
    """Return how far from the middle of a junction the kerbs of both its roads bend, at its sharper corner [m]."""
    angle = min(arm.angle, np.pi - arm.angle)
    wide = [max(x.left, x.right) for x in (profile, arm.profile)]
    corner = (max(wide) + min(wide) * np.cos(angle)) / np.sin(angle)
    return float(corner + radius / np.tan(angle / 2)) + ROOM


def _place_junctions(town: Town, dice: Dice, length: float, straight: list[float]) -> list[float]:
    """Return the places of the junctions on the main street."""
    middle = length / 2 + dice.between((-0.06, 0.06)) * length
    block = max(dice.between(town.block_length), sum(straight) + BETWEEN)
    places = {0: [], 1: [middle], 2: [(length - block) / 2, (length + block) / 2]}[len(straight)]
    if places and (places[0] < straight[0] or places[-1] > length - straight[-1]):
        raise Refusal("the junctions are too large for the main street")
    return places


def _main_pieces(
    town: Town, dice: Dice, places: list[float], straight: list[float], length: float
) -> list[tuple[float, float]]:
    """Return the pieces of the main street: straight beyond its ends and at junctions, with bends between."""
    pieces, at = [(BEYOND, 0.0)], 0.0
    for place, half in zip(places, straight, strict=True):
        pieces += [*_bends(town, dice, place - half - at), (2 * half, 0.0)]
        at = place + half
    return [*pieces, *_bends(town, dice, length - at), (BEYOND, 0.0)]


def _bends(town: Town, dice: Dice, length: float) -> list[tuple[float, float]]:
    """Return pieces of a bend, or of two."""
    if length > LONGEST_BEND:
        return _bends(town, dice, length / 2) + _bends(town, dice, length / 2)
    curvature = dice.sign() * dice.between(town.curvature)
    turning = min(length, FARTHEST_TURN / max(abs(curvature), 1e-9))
    return [(turning, curvature)] + ([(length - turning, 0.0)] if length > turning else [])


def _draw_profile(town: Town, dice: Dice, lanes: tuple[int, ...]) -> Profile:
    """Draw a cross-section."""
    count, width = dice.one_of(lanes), dice.between(town.lane_width)
    median = dice.between(town.median_width) if dice.chance(town.median) else 0.0
    strip = dice.between(town.parking_width)
    parking = (strip * dice.chance(town.parking), strip * dice.chance(town.parking))
    profile = Profile(count, count, width, median, parking)
    if not dice.chance(town.one_way):
        return profile
    forward = dice.chance(0.5)
    return replace(profile, forward=count * forward, backward=count * (not forward), median=0.0)


def _draw_side_street(
    town: Town, dice: Dice, arm: SideArm, on: tuple[Curve, float], straight: float
) -> tuple[Curve, float]:  # fmt: skip
    """Draw the curve of a side street, and its length [m]; ``on`` is the main street and a place on it."""
    main, place = on
    length = max(dice.between(town.arm_length), straight + BETWEEN)
    heading = main.heading(place) + arm.angle - (np.pi if arm.side < 0 else 0.0)
    # It begins behind the middle of the main street, where its surface is cut off.
    before = main.beside(place) - BEYOND * np.array([np.cos(heading), np.sin(heading)])
    pieces = [(BEYOND + straight, 0.0), *_bends(town, dice, length - straight), (BEYOND, 0.0)]
    return Curve.of(before, heading, pieces, first=-BEYOND), length
