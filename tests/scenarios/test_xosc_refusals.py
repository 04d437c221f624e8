"""OpenSCENARIO files that are refused, in one message that says why, or damaged."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from jaxwalk.scenarios.crash_suite import CrashFileError
from scenarios.xosc_documents import (
    EGO,
    PARKED,
    TIME,
    WALKER,
    body,
    by_car,
    by_value,
    crossing,
    document,
    event,
    speed,
    teleport,
    world,
)

CYCLIST = PARKED.replace('vehicleCategory="van"', 'vehicleCategory="bicycle"')
MOVING = f'<Private entityRef="van">{teleport(world(20, -3))}{speed(5)}</Private>'
SPEEDS = by_car('<SpeedCondition value="3" rule="lessThan"/>')
FUNCTION = '<ParameterDeclarations><ParameterDeclaration name="a" value="{}"/></ParameterDeclarations>'
GOES_TO = (
    "<PrivateAction><RoutingAction><AcquirePositionAction>{}</AcquirePositionAction></RoutingAction></PrivateAction>"
)
ROUTE = "<AssignRouteAction><Route name='empty'/></AssignRouteAction>"
NOWHERE = f"<PrivateAction><RoutingAction>{ROUTE}</RoutingAction></PrivateAction>"
REFUSED = {
    "version": (document(header='revMajor="2" revMinor="0"'), "FileHeader: version 2.0; versions 1.0 to 1.3"),
    "no scenario": ("<OpenDRIVE/>", "its first element is OpenDRIVE, not OpenSCENARIO"),
    "no XML": ("speed = 3", "not XML that can be read"),
    "entities": (
        '<!DOCTYPE x [<!ENTITY a "b">]>' + document(),
        "declares a document type (<!DOCTYPE ...>), which no scenario",
    ),
    "too deep": (f"<OpenSCENARIO>{'<a>' * 100}{'</a>' * 100}</OpenSCENARIO>", "more than 60 elements in each other"),
    "cyclist": (document(entities=EGO + WALKER + CYCLIST, init=MOVING), "as 'van': moves (LongitudinalAction)"),
    "no size": (
        document(entities=EGO + WALKER + body("Vehicle", "van", "", (0.0, 2.0)), init=MOVING.replace("5", "0")),
        "Vehicle 'a vehicle' as 'van': Dimensions of 0 x 2 m; correct them",
    ),
    "no car": (document(entities=WALKER, car=""), "there is no such ScenarioObject"),
    "no speed": (document(car=teleport(world(0, 0))), "nothing says how fast it drives; write a SpeedAction"),
    "too fast": (document(car=teleport(world(0, 0)) + speed(30)), "speeds: 108 km/h is above 72"),
    "no place": (document(walker=speed(1)), "no TeleportAction of Init says where it begins"),
    "no place but a goal": (
        document(walker=GOES_TO.format(world(43.5, 6)) + speed(1)),
        "entity 'walker': no TeleportAction of Init says where it begins; add one",
    ),
    "condition": (document(crossing(SPEEDS)), "SpeedCondition: isn't supported; wait for a time"),
    "mixed": (
        document(crossing(by_value(TIME.format(1)) + by_car('<TraveledDistanceCondition value="1"/>'))),
        "Event 'walks': waits for several conditions (a time and the car at a place)",
    ),
    "never near": (
        document(crossing(by_car(f'<ReachPositionCondition tolerance="2">{world(30, 9)}</ReachPositionCondition>'))),
        "never comes nearer than 9.00 m",
    ),
    "shape": (
        document(crossing(by_value(TIME.format(1)))).replace("Polyline", "Nurbs"),
        "Nurbs: isn't supported as the shape",
    ),
    "teleport": (document(event([teleport(world(1, 1))])), "Event 'walks': TeleportAction isn't supported"),
    "twice": (
        document(crossing("") + crossing("").replace("'walks", "'again")),
        "follows several ways one after the other",
    ),
    "undeclared": (document(walker=teleport(world("$x", 0))), "parameter $x isn't declared"),
    "itself": (document(more=FUNCTION.format("$a"), walker=teleport(world("$a", 0))), "'a': refers to itself"),
    "code": (document(walker=teleport(world("${__import__('os').getpid()}", 0))), "can't be evaluated (only numbers"),
    "too much": (document(walker=teleport(world("${pow(10, pow(10, 9))}", 0))), "can't be evaluated"),
    "geo": (
        document(walker=teleport("<Position><GeoPosition latitude='1' longitude='1'/></Position>")),
        "GeoPosition: isn't read",
    ),
    "catalog": (
        document(
            entities=EGO + '<ScenarioObject name="walker"><CatalogReference catalogName="c" entryName="e"/>'
            "</ScenarioObject>"
        ),
        "CatalogReference c/e: isn't in the folders of CatalogLocations",
    ),
    "no road": (
        document(walker=teleport('<Position><LanePosition roadId="1" laneId="-1" s="1"/></Position>')),
        "RoadNetwork: names no OpenDRIVE file",
    ),
    "no number": (document(walker=teleport(world("east", 0))), "WorldPosition: x 'east' is no number"),
    "far away": (document(walker=teleport(world(1e8, 0))), "span"),
    "too large": (
        document() + " " * 20_000_000,
        "larger than 20,000,000 bytes, which no scenario needs; check the path",
    ),
    "no version": (document(header='revMajor="1"'), "FileHeader: revMinor is missing; add it"),
    "no storyboard": (document().replace("Storyboard>", "Board>"), "OpenSCENARIO: has no Storyboard; add it"),
    "an action of nothing": (
        document(event(["<PrivateAction><RoutingAction/></PrivateAction>"])),
        "RoutingAction: is empty; say what it does, or remove it",
    ),
    "an entity of another file": (
        document(entities=EGO + '<ScenarioObject name="walker"><ExternalObjectReference name="x"/></ScenarioObject>'),
        "ScenarioObject 'walker': is a ExternalObjectReference, which isn't read; write its element itself",
    ),
    "whoever triggers it": (
        document(event([speed(1)]).replace('selectTriggeringEntities="false"', 'selectTriggeringEntities="true"')),
        "ManeuverGroup 'walks group': selectTriggeringEntities isn't supported; name its actors",
    ),
    "traffic": (
        document(init="<GlobalAction><TrafficAction/></GlobalAction>"),
        "TrafficAction: other traffic isn't supported; remove it",
    ),
    "a long sum": (
        document(walker=teleport(world("${" + "1+" * 500 + "1}", 0))),
        "longer than 1000 characters; simplify it",
    ),
    "a route to nowhere": (document(event([NOWHERE, speed(1)])), "Route 'empty': has no Waypoint; add one"),
    "the car's route to nowhere": (
        document(car=teleport(world(0, 0)) + speed(10) + NOWHERE),
        "Route 'empty': has no Waypoint; add one",
    ),
    "runs": (document(event([speed(12)])), "times: faster than 36 km/h"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_said_is_refused_in_words(check_refused, case):
    check_refused(*REFUSED[case])


WHOLE = document(
    crossing(by_car('<TraveledDistanceCondition value="12"/>')),
    entities=EGO + WALKER + PARKED,
    init=f'<Private entityRef="van">{teleport(world(20, -3))}</Private>',
)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_a_damaged_document_is_read_or_refused(read, data):
    """Whatever is cut out of a document, or put into it, the answer is a script or one message."""
    begin = data.draw(st.integers(0, len(WHOLE)))
    length = data.draw(st.integers(0, 60))
    what = data.draw(st.sampled_from(["", "-1", "1e308", "nan", "$a", "${1/0}", "Ego", "<a/>", '"', "0", "walker"]))
    try:
        read(WHOLE[:begin] + what + WHOLE[begin + length :])
    except CrashFileError as error:
        assert "\n" not in str(error)


ATTRIBUTES = [piece for piece in WHOLE.split('"')[1::2]]


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.integers(0, len(ATTRIBUTES) - 1), st.sampled_from(["", "-1", "1e9", "inf", "walker", "van", "0", "1e-9", "²"])
)
def test_a_wrong_attribute_is_read_or_refused(read, number, text):
    pieces = WHOLE.split('"')
    pieces[2 * number + 1] = text
    try:
        read('"'.join(pieces))
    except CrashFileError as error:
        assert "\n" not in str(error)
