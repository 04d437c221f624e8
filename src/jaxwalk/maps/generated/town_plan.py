"""What a street is, before it is drawn: its roads with their cross-sections and junctions. All chances are drawn here
or with the plan's `Dice`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeVar

import numpy as np

from jaxwalk.maps.generated.curve import Curve
from jaxwalk.maps.generated.town import Layout, Range, Town

BEYOND = 15.0
"""Roads go on straight beyond the street's edges, where they are cut [m]."""
STRAIGHT = 12.0
"""A main street is straight for this long on either side of a junction's middle [m]."""
ARM_STRAIGHT = 20.0
"""A side street is straight for this long from the middle of the main street [m]."""
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
class Road:
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


class Arm(NamedTuple):
    """A side street to be."""

    side: int
    """1: to the left of the main street; -1: to the right."""
    angle: float
    """Angle between both [rad]."""


@dataclass(frozen=True)
class Plan:
    """The roads of a street. The first ones make up the main street, the others are its arms."""

    layout: Layout
    main: Curve
    main_length: float
    roads: tuple[Road, ...]
    junctions: tuple[float, ...]
    """Places of the junctions on the main street."""
    kerb_radius: float
    sidewalk: float
    """Width of the sidewalks [m]."""


def draw_plan(town: Town, dice: Dice) -> Plan:
    """Draw the roads of a street."""
    layout, length = dice.one_of(town.layouts), dice.between(town.main_length)
    junctions, arms = _draw_junctions(town, dice, layout, length)
    main = Curve.of(np.zeros(2), dice.between((0, 2 * np.pi)), _main_pieces(town, dice, junctions, length),
                    first=-BEYOND)  # fmt: skip
    limit = dice.one_of(town.speed_limits)
    profile = _draw_profile(town, dice, town.lanes)
    cuts = [0.0, *junctions, length]
    names = [None, *range(len(junctions)), None]
    roads = [
        Road(main, cuts[n], cuts[n + 1], profile, limit, (names[n], names[n + 1])) for n in range(len(junctions) + 1)
    ]
    for number, (place, around) in enumerate(zip(junctions, arms, strict=True)):
        roads += [_draw_arm(town, dice, arm, main, place, (number, limit)) for arm in around]
    return Plan(layout, main, length, tuple(roads), tuple(junctions), dice.between(town.kerb_radius),
                dice.between(town.sidewalk_width))  # fmt: skip


def _draw_junctions(town: Town, dice: Dice, layout: Layout, length: float) -> tuple[list[float], list[list[Arm]]]:
    """Return the places of the junctions on the main street, and the arms of each."""
    if layout == "straight":
        return [], []
    angle = np.deg2rad(dice.between(town.skewed_angle if layout == "skewed" else town.angle))
    side, half = dice.sign(), length / 2
    middle = half + dice.between((-0.06, 0.06)) * length
    if layout == "tee":
        return [middle], [[Arm(side, angle)]]
    if layout == "skewed":
        return [middle], [[Arm(1, angle), Arm(-1, angle)]]
    other = np.deg2rad(dice.between(town.angle))
    if layout == "cross":
        return [middle], [[Arm(1, angle), Arm(-1, other)]]
    block = dice.between(town.block_length)
    places = [half - block / 2, half + block / 2]
    if layout == "staggered":
        return places, [[Arm(side, angle)], [Arm(-side, other)]]
    arms = [[Arm(1, angle), Arm(-1, angle)], [Arm(side, other)]]
    return places, arms if dice.chance(0.5) else arms[::-1]


def _main_pieces(town: Town, dice: Dice, junctions: list[float], length: float) -> list[tuple[float, float]]:
    """Return the pieces of the main street: straight beyond its ends and at junctions, with bends between."""
    cuts = [0.0, *(x for place in junctions for x in (place - STRAIGHT, place + STRAIGHT)), length]
    pieces = [(BEYOND, 0.0)]
    for begin, end in zip(cuts[::2], cuts[1::2], strict=True):
        pieces += _bends(town, dice, end - begin)
        pieces.append((2 * STRAIGHT, 0.0))
    return [*pieces[:-1], (BEYOND, 0.0)]


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


def _draw_arm(town: Town, dice: Dice, arm: Arm, main: Curve, place: float, at: tuple[int, float]) -> Road:
    """Draw a side street at a place of the main street; ``at`` is the junction and the main street's speed limit."""
    junction, limit = at
    length = dice.between(town.arm_length)
    heading = main.heading(place) + arm.angle - (np.pi if arm.side < 0 else 0.0)
    # It begins behind the middle of the main street, where its surface is cut off.
    before = main.beside(place) - BEYOND * np.array([np.cos(heading), np.sin(heading)])
    pieces = [(BEYOND + ARM_STRAIGHT, 0.0), *_bends(town, dice, length - ARM_STRAIGHT), (BEYOND, 0.0)]
    curve = Curve.of(before, heading, pieces, first=-BEYOND)
    limits = [slower for slower in town.speed_limits if slower <= limit]
    return Road(curve, 0.0, length, _draw_profile(town, dice, town.arm_lanes), dice.one_of(limits), (junction, None))
