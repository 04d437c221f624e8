"""The road users of an OpenSCENARIO document: what they are, what they do at first, and which car is tested."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from functools import partial

from jaxwalk.scenarios.xosc.catalog_entries import CatalogEntries
from jaxwalk.scenarios.xosc.elements import XoscRefusal, called, entity_refs, number, only, part, word

PEDESTRIAN, VEHICLE, OBJECT = "Pedestrian", "Vehicle", "MiscObject"
TESTED = ("ego", "hero", "ego_vehicle", "egovehicle", "vut", "host", "hostvehicle", "sut")
"""Names of the tested car, in small letters."""
DRIVING = ("LongitudinalAction", "LateralAction", "RoutingAction", "TeleportAction", "SynchronizeAction")
"""Actions that move a road user."""


@dataclass(frozen=True)
class Happening:
    """An event of the storyboard."""

    element: ET.Element
    act: ET.Element
    actors: tuple[str, ...]

    @property
    def private_actions(self) -> list[tuple[str, ET.Element]]:
        """Return the kinds of its private actions, each with the name of its ``Action``."""
        actions = self.element.findall("Action")
        return [(word(one, "name", ""), kind) for one in actions for private in one.findall("PrivateAction")
                for kind in private]  # fmt: skip

    @property
    def names(self) -> set[str]:
        """Return the names of the event and of its actions."""
        return {word(one, "name", "") for one in (self.element, *self.element.findall("Action"))}


@dataclass
class RoadUser:
    """Somebody or something of the scenario."""

    name: str
    element: ET.Element
    """Vehicle, Pedestrian or MiscObject."""
    naming: Callable[[], AbstractContextManager] = nullcontext
    """Names the entry of a catalog in errors, if it is one."""
    first: list[ET.Element] = field(default_factory=list)
    """The kinds of its actions of Init, such as ``TeleportAction``."""
    events: list[Happening] = field(default_factory=list)

    @property
    def kind(self) -> str:
        """Return `PEDESTRIAN`, `VEHICLE` or `OBJECT`."""
        return self.element.tag

    @property
    def size(self) -> tuple[float, float, float]:
        """Return length and width, and how far the middle is ahead of the reference point [m]."""
        with self.naming():
            return self._size()

    def _size(self) -> tuple[float, float, float]:
        box = part(self.element, "BoundingBox")
        dimensions, centre = part(box, "Dimensions"), part(box, "Center")
        length, width = number(dimensions, "length"), number(dimensions, "width")
        if min(length, width) <= 0:
            raise XoscRefusal(
                f"{called(self.element)} as {self.name!r}: Dimensions of {length:g} x {width:g} m; correct them"
            )
        return length, width, number(centre, "x")

    def actions(self, kind: str) -> list[ET.Element]:
        """Return actions of a kind, those of Init first."""
        own = [one for event in self.events for one in private_actions(event.element)]
        return [one for one in (*self.first, *own) if one.tag == kind]

    def stands_at_first(self) -> bool:
        """Return whether nothing of Init moves it."""
        return all(
            one.tag not in DRIVING or one.tag == "TeleportAction" or _stands(one) or
            (one.tag == "RoutingAction" and one.find("*/TimeReference/Timing") is None)
            for one in self.first
        )  # fmt: skip

    def moves(self) -> ET.Element | None:
        """Return an action that moves it after it was put to its place; None if there is none."""
        later = [one for event in self.events for one in private_actions(event.element)]
        for action in (*(one for one in self.first if one.tag != "TeleportAction"), *later):
            if action.tag in DRIVING and not _stands(action):
                return action
        return None


def _stands(action: ET.Element) -> bool:
    """Return whether an action gives a speed of 0."""
    target = action.find("SpeedAction/SpeedActionTarget/AbsoluteTargetSpeed")
    return target is not None and number(target, "value") == 0


def private_actions(event: ET.Element) -> list[ET.Element]:
    """Return the kinds of the private actions of an event."""
    return [one for action in event.findall("Action/PrivateAction") for one in action]


def road_users(document: ET.Element, catalogs: CatalogEntries) -> dict[str, RoadUser]:
    """Return everybody of a document, by name. Raise XoscRefusal if somebody's kind can't be read."""
    found = {}
    for entity in document.findall("Entities/ScenarioObject"):
        name = word(entity, "name")
        said = only(entity)
        body = catalogs.resolved(said)
        if body.tag not in (PEDESTRIAN, VEHICLE, OBJECT):
            raise XoscRefusal(f"ScenarioObject {name!r}: is a {body.tag}, which isn't read; write its element itself")
        found[name] = RoadUser(name, body, partial(catalogs.naming, said))
    for private in document.findall("Storyboard/Init/Actions/Private"):
        user = _known(found, word(private, "entityRef"))
        user.first += [one for action in private.findall("PrivateAction") for one in action]
    for event in happenings(document, catalogs):
        for name in event.actors:
            _known(found, name).events.append(event)
    return found


def happenings(document: ET.Element, catalogs: CatalogEntries) -> list[Happening]:
    """Return all events of the storyboard. Raise XoscRefusal where actors are those who trigger it."""
    groups = [(act, one) for act in document.findall("Storyboard/Story/Act") for one in act.findall("ManeuverGroup")]
    return [event for act, group in groups for event in _of_group(act, group, catalogs)]


def _of_group(act: ET.Element, group: ET.Element, catalogs: CatalogEntries) -> list[Happening]:
    actors, chooses = tuple(entity_refs(group, "Actors")), group.find("Actors")
    maneuvers = [catalogs.resolved(one) for one in group if one.tag in ("Maneuver", "CatalogReference")]
    events = [event for maneuver in maneuvers for event in maneuver.findall("Event")]
    if events and chooses is not None and chooses.get("selectTriggeringEntities") == "true":
        raise XoscRefusal(f"{called(group)}: selectTriggeringEntities isn't supported; name its actors")
    return [Happening(event, act, actors) for event in events]


def tested_car(users: dict[str, RoadUser]) -> RoadUser:
    """Return the car that drivers are to drive: the one called so, else the only one that moves.

    Raise XoscRefusal if nothing says which it is.
    """
    cars = [one for one in users.values() if one.kind == VEHICLE]
    named = [one for one in cars if one.name.lower() in TESTED]
    said = [one for one in cars if any(
        property.get("name") == "type" and property.get("value", "").lower() in TESTED
        for property in one.element.findall("Properties/Property"))]  # fmt: skip
    moving = [one for one in cars if one.moves() is not None]
    for found in (named, said, moving, cars):
        if len(found) == 1:
            return found[0]
    count = "no Vehicle" if not cars else f"{len(cars)} vehicles, and none"
    raise XoscRefusal(f"Entities: {count} is called Ego; name the car that is tested so")


def _known(users: dict[str, RoadUser], name: str) -> RoadUser:
    if name not in users:
        raise XoscRefusal(f"entityRef {name[:60]!r}: there is no such ScenarioObject; correct the name")
    return users[name]
