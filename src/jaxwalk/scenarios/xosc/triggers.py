"""Triggers of an OpenSCENARIO document: what people wait for before they set out."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from jaxwalk.scenarios.xosc.car_line import CarLine, MeasuredBody
from jaxwalk.scenarios.xosc.elements import XoscRefusal, called, entity_refs, number, only, part, word
from jaxwalk.scenarios.xosc.positions import Positions
from jaxwalk.scenarios.xosc.road_users import RoadUser

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


WORDS = {
    Comes.AT_ONCE: "nothing", Comes.TIME: "a time", Comes.PLACE: "the car at a place",
    Comes.ARRIVAL: "a time to collision", Comes.AFTER: "an event", Comes.OWN_WAY: "the way walked",
    Comes.CONTACT: "a contact",
}  # fmt: skip
"""What is waited for, in messages."""


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


class Triggers:
    """Reads triggers: those of the tested car at people, and those that follow other events."""

    def __init__(self, positions: Positions, car: CarLine, tested: str, users: Mapping[str, RoadUser]) -> None:
        """Keep what conditions refer to: ``tested`` is the name of the tested car, and ``users`` are all by name."""
        self.positions, self.car, self.tested, self.users = positions, car, tested, users

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
        words = " and ".join(sorted(WORDS[one] for one in kinds))
        raise XoscRefusal(f"{called(owner)}: waits for several conditions ({words}); a person waits for one")

    def _condition(self, condition: ET.Element, who: str) -> Beginning:
        by = only(condition)
        delay = number(condition, "delay", 0.0)
        found = self._by_value(condition, only(by)) if by.tag == "ByValueCondition" else self._by_entity(by, who)
        edge = word(condition, "conditionEdge", "none")
        if edge in ("falling", "risingOrFalling") and found.comes != Comes.CONTACT:
            raise XoscRefusal(f"{called(condition)}: conditionEdge {edge} isn't supported; use rising or none")
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
        mutual = condition.tag == "RelativeDistanceCondition" and condition.get("entityRef") == self.tested
        if triggering == {who} and mutual:  # as far as the car from them
            condition = _with(condition, "entityRef", who)
        elif triggering != {self.tested}:
            raise XoscRefusal(
                f"{condition.tag}: is triggered by {', '.join(sorted(triggering))}; only by the tested car"
            )
        return readers[condition.tag](condition, who)

    def _travelled(self, condition: ET.Element, who: str) -> Beginning:
        return Beginning(Comes.PLACE, self.car.start + number(condition, "value"))

    def _reached(self, condition: ET.Element, who: str) -> Beginning:
        place = self.positions.at(part(condition, "Position"))
        return self._within(condition, MeasuredBody(place, place), number(condition, "tolerance"))

    def _near(self, condition: ET.Element, who: str) -> Beginning:
        body, value = self._body(condition, condition, who), number(condition, "value")
        self._falls(condition)
        kind = word(condition, "relativeDistanceType", STRAIGHT[0])
        if kind == "longitudinal":
            return Beginning(Comes.PLACE, self._place(condition, body) - value)
        if kind not in STRAIGHT:
            raise XoscRefusal(
                f"{condition.tag}: a {kind} distance isn't supported; use longitudinal or euclidianDistance"
            )
        return self._within(condition, body, value)

    def _arriving(self, condition: ET.Element, who: str) -> Beginning:
        body = self._body(condition, part(condition, "TimeToCollisionConditionTarget"), who)
        self._falls(condition)
        kind = word(condition, "relativeDistanceType", STRAIGHT[0])
        if kind not in ("longitudinal", *STRAIGHT):
            raise XoscRefusal(f"{condition.tag}: a {kind} distance isn't supported; use longitudinal")
        return Beginning(Comes.ARRIVAL, number(condition, "value"), self._place(condition, body))

    def _body(self, condition: ET.Element, holder: ET.Element, who: str) -> MeasuredBody:
        """Return that to which a condition measures. Raise XoscRefusal if it may have moved by then."""
        position = holder.find("Position")
        if position is not None:
            place = self.positions.at(position)
            return MeasuredBody(place, place)
        name = self._named(condition, holder)
        if name == self.tested or name not in self.users:
            raise XoscRefusal(f"{condition.tag}: measures to {name!r}; name somebody else, or a position")
        user = self.users[name]
        if not user.stands_at_first() or (name != who and user.moves() is not None):
            raise XoscRefusal(f"{condition.tag}: measures to {name!r}, who moves by then; measure to a position")
        reference, (length, width, ahead) = self.positions.begin(name), user.size
        return MeasuredBody(reference, reference.beside(ahead, 0.0), length, width)

    def _named(self, condition: ET.Element, holder: ET.Element) -> str:
        """Return the name of the entity to which a condition measures."""
        entity = holder if holder.get("entityRef") is not None else part(holder, "EntityRef")
        return word(entity, "entityRef")

    def _falls(self, condition: ET.Element) -> None:
        if word(condition, "rule") not in BELOW:
            raise XoscRefusal(f"{condition.tag}: rule {condition.get('rule')} isn't supported; use lessThan")

    def _place(self, condition: ET.Element, body: MeasuredBody) -> float:
        """Return where the car's centre is when its measured end has come to a body [m along the way]."""
        if condition.get("freespace") != "true":
            return self.car.project(*body.reference[:2])[0] + self.car.reference
        along, _ = self.car.project(*body.centre[:2])
        heading = self.car.poses(np.array([along]))[0, 2]
        return along - body.half_along(heading) - self.car.half_length

    def _within(self, condition: ET.Element, body: MeasuredBody, metres: float) -> Beginning:
        """Return when the car first is within a straight distance of a body [m]."""
        freespace = condition.get("freespace") == "true"
        place = self.car.first_within(metres, body, freespace)
        if place is None:
            gap = self.car.nearest(body, freespace)
            raise XoscRefusal(f"{condition.tag}: the car on its way never comes nearer than {gap:.2f} m; correct it")
        return Beginning(Comes.PLACE, place)


def _with(element: ET.Element, name: str, value: str) -> ET.Element:
    """Return a copy of an element with another attribute."""
    copy = ET.Element(element.tag, element.attrib | {name: value})
    copy.extend(element)
    return copy


def check_stops(act: ET.Element, lasts: float) -> None:
    """Raise XoscRefusal if an act may be stopped before the test is over, which lasts so long [s]."""
    for group in act.findall(".//StopTrigger/ConditionGroup"):
        times = [number(one, "value") for one in group.iter("SimulationTimeCondition") if word(one, "rule") in ABOVE]
        if max(times, default=0.0) < lasts and group.find(".//CollisionCondition") is None:
            raise XoscRefusal(
                f"{called(act)}: its StopTrigger would stop people, which isn't supported; end their ways instead"
            )
