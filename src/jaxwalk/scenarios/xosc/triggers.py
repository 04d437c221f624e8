"""Triggers of an OpenSCENARIO document: what people wait for before they set out."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Callable
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from jaxwalk.scenarios.xosc.elements import XoscRefusal, called, entity_refs, number, only, part, word
from jaxwalk.scenarios.xosc.plain_roads import Pose
from jaxwalk.scenarios.xosc.positions import Positions

BELOW, ABOVE = ("lessThan", "lessOrEqual"), ("greaterThan", "greaterOrEqual")
"""Rules of conditions that come true when a value falls, and when it rises."""
STRAIGHT = ("euclidianDistance", "cartesianDistance")
"""Names of the distance in a straight line."""


class Comes(StrEnum):
    """What must come before somebody sets out, or before something else happens."""

    AT_ONCE = "at once"
    TIME = "time"
    """A time since the start [s]."""
    PLACE = "place"
    """The car's centre is at a place of its route [m along it]."""
    ARRIVAL = "arrival"
    """It is so long before that place, at its present speed [s]."""
    AFTER = "after"
    """Another event or action is over, or has begun."""
    OWN_WAY = "own way"
    """The person has walked so far [m]."""
    CONTACT = "contact"
    """A collision, at which tests end."""


class Beginning(NamedTuple):
    """When something begins."""

    comes: Comes
    value: float = 0.0
    place: float = 0.0
    """For an arrival: the place [m along the route, of the car's centre]."""
    after: str = ""
    """For what comes after something: its name."""
    started: bool = False
    """Whether that something must have begun, not ended."""
    delay: float = 0.0
    """It begins so much later [s]."""


class CarLine(NamedTuple):
    """The way of the tested car, and what its front is."""

    points: np.ndarray
    """float64 (point, 2) [m]."""
    along: np.ndarray
    """How far along the way each point is [m]."""
    start: float
    """Where its centre begins [m along the way]."""
    half_length: float
    half_width: float
    reference: float
    """How far its reference point is behind its centre [m]."""
    speed: float
    """Its speed at the start, or the highest one if it begins at rest [m/s]."""

    def project(self, x: float, y: float) -> tuple[float, float]:
        """Return how far along the way the nearest place is, and how far to its left the point lies [m]."""
        begin, step = self.points[:-1], np.diff(self.points, axis=0)
        away = np.array([x, y]) - begin
        lengths = np.maximum(np.hypot(*step.T), 1e-9)
        share = np.clip((away * step).sum(axis=1) / lengths**2, 0, 1)
        missed = away - share[:, None] * step
        nearest = int(np.argmin((missed**2).sum(axis=1)))
        left = (step[nearest, 0] * away[nearest, 1] - step[nearest, 1] * away[nearest, 0]) / lengths[nearest]
        return float(self.along[nearest] + share[nearest] * lengths[nearest]), float(left)


class Triggers:
    """Reads triggers: those of the tested car at people, and those that follow other events."""

    def __init__(self, positions: Positions, car: CarLine, tested: str, still: Callable[[str], bool]) -> None:
        """Keep what conditions refer to; ``still`` says whether an entity hasn't moved when the car comes."""
        self.positions, self.car, self.tested, self.still = positions, car, tested, still

    def moment(self, owner: ET.Element, who: str) -> Beginning:
        """Return when an act or an event of an actor begins. Raise XoscRefusal if it can't wait so."""
        groups = [
            self._all([self._condition(one, who) for one in group.findall("Condition")], owner)
            for group in owner.findall("StartTrigger/ConditionGroup")
        ]
        return self._merged(groups, owner, min) if groups else Beginning(Comes.AT_ONCE)

    def both(self, one: Beginning, other: Beginning, owner: ET.Element) -> Beginning:
        """Return when two moments have come."""
        return self._all([one, other], owner)

    def _all(self, moments: list[Beginning], owner: ET.Element) -> Beginning:
        waits = [one for one in moments if one.comes != Comes.AT_ONCE]
        return self._merged(waits, owner, max) if waits else Beginning(Comes.AT_ONCE)

    def _merged(self, moments: list[Beginning], owner: ET.Element, choose: Callable) -> Beginning:
        if len(moments) == 1:
            return moments[0]
        if choose is min and any(one.comes == Comes.AT_ONCE for one in moments):
            return Beginning(Comes.AT_ONCE)
        kinds = {one.comes for one in moments}
        if kinds in ({Comes.TIME}, {Comes.PLACE}) and len({one.delay for one in moments}) == 1:
            return choose(moments, key=lambda one: one.value)
        words = " and ".join(sorted(kinds))
        raise XoscRefusal(f"{called(owner)}: waits for several conditions ({words}); a person waits for one")

    def _condition(self, condition: ET.Element, who: str) -> Beginning:
        by = only(condition)
        delay = number(condition, "delay", 0.0)
        found = self._by_value(condition, only(by)) if by.tag == "ByValueCondition" else self._by_entity(by, who)
        if found.comes in (Comes.TIME, Comes.AT_ONCE) and delay > 0:
            return found._replace(comes=Comes.TIME, value=found.value + delay)
        return found._replace(delay=found.delay + max(delay, 0.0))

    def _by_value(self, condition: ET.Element, value: ET.Element) -> Beginning:
        if value.tag == "SimulationTimeCondition" and word(value, "rule") in ABOVE:
            time = number(value, "value")
            return Beginning(Comes.TIME, time) if time > 0 else Beginning(Comes.AT_ONCE)
        if value.tag == "StoryboardElementStateCondition":
            state = word(value, "state")
            if state not in ("completeState", "endTransition", "startTransition", "runningState"):
                raise XoscRefusal(f"{called(condition)}: state {state} isn't supported; wait for completeState")
            begun = state in ("startTransition", "runningState")
            return Beginning(Comes.AFTER, after=word(value, "storyboardElementRef"), started=begun)
        rule = f" with rule {value.get('rule')}" if value.tag == "SimulationTimeCondition" else ""
        raise XoscRefusal(f"{called(condition)}: {value.tag}{rule} isn't supported; wait for a time or a distance")

    def _by_entity(self, by: ET.Element, who: str) -> Beginning:
        triggering, condition = set(entity_refs(by, "TriggeringEntities")), only(part(by, "EntityCondition"))
        if condition.tag == "CollisionCondition":
            return Beginning(Comes.CONTACT)
        readers = {
            "TraveledDistanceCondition": self._travelled, "ReachPositionCondition": self._reached,
            "DistanceCondition": self._near, "RelativeDistanceCondition": self._near,
            "TimeToCollisionCondition": self._arriving,
        }  # fmt: skip
        if condition.tag not in readers:
            raise XoscRefusal(f"{condition.tag}: isn't supported; wait for a time, a distance or a time to collision")
        if triggering == {who} and condition.tag == "TraveledDistanceCondition":
            return Beginning(Comes.OWN_WAY, number(condition, "value"))
        if triggering == {who} and condition.tag == "RelativeDistanceCondition":
            condition.set("entityRef", who)
        elif triggering != {self.tested}:
            raise XoscRefusal(
                f"{condition.tag}: is triggered by {', '.join(sorted(triggering))}; only by the tested car"
            )
        return readers[condition.tag](condition)

    def _travelled(self, condition: ET.Element) -> Beginning:
        return Beginning(Comes.PLACE, self.car.start + number(condition, "value"))

    def _reached(self, condition: ET.Element) -> Beginning:
        target = self.positions.at(part(condition, "Position"))
        reach = self._reach(condition, target, number(condition, "tolerance"), 0.0)
        return Beginning(Comes.PLACE, reach + self.car.reference)

    def _near(self, condition: ET.Element) -> Beginning:
        target, size = self._target(condition, condition)
        self._falls(condition)
        near, front = self._ends(condition, size)
        value = number(condition, "value")
        kind = word(condition, "relativeDistanceType", STRAIGHT[0])
        if kind == "longitudinal":
            return Beginning(Comes.PLACE, self.car.project(*target[:2])[0] - value - near - front)
        if kind not in STRAIGHT:
            raise XoscRefusal(
                f"{condition.tag}: a {kind} distance isn't supported; use longitudinal or euclidianDistance"
            )
        beside = self.car.half_width + near if front > 0 else 0.0
        return Beginning(Comes.PLACE, self._reach(condition, target, value, beside) - near - front)

    def _arriving(self, condition: ET.Element) -> Beginning:
        target, size = self._target(condition, part(condition, "TimeToCollisionConditionTarget"))
        self._falls(condition)
        near, front = self._ends(condition, size)
        place = self.car.project(*target[:2])[0] - near - front
        return Beginning(Comes.ARRIVAL, number(condition, "value"), place)

    def _target(self, condition: ET.Element, holder: ET.Element) -> tuple[Pose, float]:
        """Return the place to which a condition measures, and half the length of what is there [m]."""
        position = holder.find("Position")
        if position is not None:
            return self.positions.at(position), 0.0
        entity = holder if holder.get("entityRef") is not None else part(holder, "EntityRef")
        name = word(entity, "entityRef")
        if name == self.tested or not self.still(name):
            raise XoscRefusal(f"{condition.tag}: measures to {name!r}, who moves by then; measure to a position")
        return self.positions.begin(name), 0.25

    def _falls(self, condition: ET.Element) -> None:
        if word(condition, "rule") not in BELOW:
            raise XoscRefusal(f"{condition.tag}: rule {condition.get('rule')} isn't supported; use lessThan")

    def _ends(self, condition: ET.Element, size: float) -> tuple[float, float]:
        """Return how far the measured ends are from the target and from the car's centre [m]."""
        if condition.get("freespace") == "true":
            return size, self.car.half_length
        return 0.0, -self.car.reference

    def _reach(self, condition: ET.Element, target: Pose, value: float, beside: float) -> float:
        """Return where along the way a place is a straight distance away [m]."""
        along, left = self.car.project(*target[:2])
        gap = max(abs(left) - beside, 0.0)
        if gap >= value:
            raise XoscRefusal(f"{condition.tag}: the car on its way never comes nearer than {gap:.2f} m; correct it")
        return along - math.sqrt(value**2 - gap**2)
