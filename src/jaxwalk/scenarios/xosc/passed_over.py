"""What of an OpenSCENARIO document isn't played, in words for the page of a test."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping

from jaxwalk.scenarios.xosc.elements import XoscRefusal, called, number, only, part, word
from jaxwalk.scenarios.xosc.road_users import DRIVING, Happening, RoadUser
from jaxwalk.scenarios.xosc.triggers import ABOVE


def passed_over(document: ET.Element, users: Mapping[str, RoadUser]) -> Iterator[str]:
    """Yield what isn't played, one line each. Raise XoscRefusal for other traffic."""
    yield from _global(document)
    for user in users.values():
        yield from (f"{one.tag} of {user.name} isn't played" for one in user.first if one.tag not in DRIVING)
        for event in user.events:
            yield from _of_event(event, user)
    for entity in document.findall("Entities/ScenarioObject"):
        if entity.find("ObjectController") is not None:
            yield f"ObjectController of {word(entity, 'name')} isn't played"


def _of_event(event: Happening, user: RoadUser) -> Iterator[str]:
    yield from _global(event.element)
    kinds = [kind for _, kind in event.private_actions] + event.element.findall("Action/UserDefinedAction")
    others = (kind.tag for kind in kinds if kind.tag not in DRIVING)
    yield from (f"{called(event.element)} of {user.name}: {tag} isn't played" for tag in others)


def _global(element: ET.Element) -> Iterator[str]:
    for kind in element.iterfind(".//GlobalAction/*"):
        if kind.tag == "TrafficAction":
            raise XoscRefusal("TrafficAction: other traffic isn't supported; remove it")
        yield f"{kind.tag} of the file isn't played"


def stop_times(document: ET.Element) -> list[float]:
    """Return the times at which the storyboard's stop trigger ends the scenario [s]."""
    times = document.iterfind("Storyboard/StopTrigger//SimulationTimeCondition")
    return [number(one, "value") for one in times if word(one, "rule") in ABOVE]


def other_ends(document: ET.Element, lasts: float) -> Iterator[str]:
    """Yield what of the storyboard's stop trigger isn't played. A test ends at a contact, or after ``lasts`` [s]."""
    for condition in document.iterfind("Storyboard/StopTrigger//Condition"):
        by = only(condition)
        kind = only(by) if by.tag == "ByValueCondition" else only(part(by, "EntityCondition"))
        if kind.tag not in ("SimulationTimeCondition", "CollisionCondition"):
            yield f"StopTrigger: {kind.tag} isn't played"
    times = stop_times(document)
    if times and lasts not in times:
        yield f"StopTrigger: the file ends at {max(times):g} s, the test at {lasts:g} s at the latest"
