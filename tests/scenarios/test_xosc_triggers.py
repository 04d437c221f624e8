"""What people wait for: distances to bodies of their own sizes, from the entities that are named."""

from __future__ import annotations

import pytest

from scenarios.xosc_documents import (
    EGO,
    PARKED,
    STEP,
    TIME,
    WALKER,
    body,
    by_car,
    by_value,
    crossing,
    document,
    event,
    follow,
    speed,
    teleport,
    world,
)

EAST, NORTH = 0.0, 1.5707963267948966
FRONT = 3.5
"""Where the car's front begins [m]."""
LARGE = body("Pedestrian", "walker", 'pedestrianCategory="wheelchair" mass="75"', (1.2, 0.8), 0.2)
SMALL = body("Pedestrian", "child", 'pedestrianCategory="pedestrian" mass="30"', (0.4, 0.4), 0.0)


def distance(value, to="walker", kind="longitudinal", freespace="true"):
    return (
        f'<RelativeDistanceCondition entityRef="{to}" freespace="{freespace}" rule="lessThan" value="{value}" '
        f'relativeDistanceType="{kind}"/>'
    )


def arrival(value, to, kind="longitudinal", freespace="true"):
    return (
        f'<TimeToCollisionCondition freespace="{freespace}" rule="lessThan" value="{value}" '
        f'relativeDistanceType="{kind}">'
        f'<TimeToCollisionConditionTarget><EntityRef entityRef="{to}"/></TimeToCollisionConditionTarget>'
        "</TimeToCollisionCondition>"
    )


def driven(read, condition, *, who="Ego", heading=NORTH, entities=EGO + LARGE, init=""):
    """How far the car has driven when the walker at (43.5, -4) sets out [m]."""
    place = teleport(world(43.5, -4, heading))
    text = document(crossing(by_car(condition, who=who)), walker=place, entities=entities, init=init)
    return read(text).suite.tests[0].people[0].beyond


@pytest.mark.parametrize(
    ("heading", "near"),
    [(NORTH, 43.5 - 0.4), (EAST, 43.5 + 0.2 - 0.6), (2 * NORTH, 43.5 - 0.2 - 0.6)],
    ids=["across", "along", "against"],
)
def test_distances_count_to_the_nearest_side_of_a_body(read, heading, near):
    """Its box is 1.2 m long and 0.8 m wide, its middle 0.2 m ahead of its reference point."""
    assert driven(read, distance(10), heading=heading) == pytest.approx(near - 10 - FRONT)
    assert driven(read, arrival(2, "walker"), heading=heading) == pytest.approx(near - FRONT)


def test_straight_distances_count_between_boxes(read):
    """Across, the box ends at y = -4 + 0.2 + 0.6 = -3.2; the car's side is at -0.9: 2.3 m beside, 4 m ahead."""
    metres = (2.3**2 + 4**2) ** 0.5
    found = driven(read, distance(metres, kind="cartesianDistance"))
    assert found == pytest.approx(43.5 - 0.4 - 4 - FRONT, abs=1e-6)


def test_a_distance_to_somebody_else(read):
    """The van stands 10 m nearer than the walker: its box is 6 m long, its middle 1 m ahead of its reference point."""
    van = f'<Private entityRef="van">{teleport(world(33.5, -4))}</Private>'
    found = driven(read, distance(10, "van"), entities=EGO + WALKER + PARKED, init=van)
    assert found == pytest.approx(33.5 + 1 - 3 - 10 - FRONT)
    assert driven(read, distance(10, "Ego"), who="walker") == pytest.approx(43.5 - 0.4 - 10 - FRONT)


def test_distances_without_freespace_count_between_reference_points(read):
    """That of the car, its rear axle, begins at x = 0, and that of the walker is at x = 43.5."""
    assert driven(read, distance(10, freespace="false")) == pytest.approx(43.5 - 10)
    assert driven(read, arrival(2, "walker", freespace="false")) == pytest.approx(43.5)


def test_a_position_has_no_size(read):
    """The car's side is 0.9 m north of its middle, so the place is 3 m beside it: 4 m ahead, its front is 5 m away."""
    place = f'<DistanceCondition freespace="true" rule="lessThan" value="5">{world(30, 3.9)}</DistanceCondition>'
    assert driven(read, place) == pytest.approx(30 - 4 - FRONT, abs=1e-6)


def test_one_of_several_conditions_may_come_at_once(read):
    """From the time 0 on, or when the car has driven 12 m: they set out at the start."""
    either = by_value(TIME.format(0)) + "</ConditionGroup><ConditionGroup>" + by_car(DRIVEN.format(12))
    (person,) = read(document(crossing(either))).suite.tests[0].people
    assert (person.time, person.distance, person.time_to_collision) == (None, None, None)


DRIVEN = '<TraveledDistanceCondition value="{}"/>'
STATE = '<StoryboardElementStateCondition storyboardElementRef="walks" state="{}"/>'
CHILD = f'<Private entityRef="child">{teleport(world(30, -4))}{{}}</Private>'
MEETS = '<PrivateAction><SynchronizeAction masterEntityRef="Ego"/></PrivateAction>'
WALKS = event([speed(1)], by_value(TIME.format(1)), name="child walks", actor="child")
VAN = f'<Private entityRef="van">{teleport(world(33.5, -4))}</Private>'
EDGED = by_value(TIME.format(1)).replace('"none"', '"{}"')
STOPS = "<StopTrigger><ConditionGroup>{}</ConditionGroup></StopTrigger></Act>"


def to_child(init="", more=""):
    return document(
        more + crossing(by_car(distance(9, "child"))), entities=EGO + WALKER + SMALL, init=CHILD.format(init)
    )


REFUSED = {
    "a van to a van": (
        document(crossing(by_car(distance(9, "van"), who="walker")), entities=EGO + WALKER + PARKED, init=VAN),
        "RelativeDistanceCondition: is triggered by walker; only by the tested car",
    ),
    "itself": (document(crossing(by_car(distance(9, "Ego")))), "RelativeDistanceCondition: measures to 'Ego'"),
    "nobody": (document(crossing(by_car(distance(9, "nobody")))), "RelativeDistanceCondition: measures to 'nobody'"),
    "who walks later": (to_child(more=WALKS), "measures to 'child', who moves by then"),
    "who walks": (to_child(speed(1)), "measures to 'child', who moves by then"),
    "who meets": (to_child(MEETS), "measures to 'child', who moves by then"),
    "lateral": (document(crossing(by_car(distance(9, kind="lateral")))), "a lateral distance isn't supported"),
    "lateral arrival": (
        document(crossing(by_car(arrival(2, "walker", kind="lateral")))),
        "TimeToCollisionCondition: a lateral distance isn't supported; use longitudinal",
    ),
    "farther": (
        document(crossing(by_car(distance(9).replace("lessThan", "greaterThan")))),
        "RelativeDistanceCondition: rule greaterThan isn't supported; use lessThan",
    ),
    "until a time": (
        document(crossing(by_value(TIME.format(3).replace("greaterThan", "lessThan")))),
        "Condition 'c': SimulationTimeCondition with rule lessThan isn't supported; wait for a time or a distance",
    ),
    "a parameter": (
        document(crossing(by_value('<ParameterCondition parameterRef="p" rule="equalTo" value="1"/>'))),
        "Condition 'c': ParameterCondition isn't supported; wait for a time or a distance",
    ),
    "a state": (
        document(event([speed(1)]) + event([speed(0)], by_value(STATE.format("standbyState")), name="stops")),
        "Condition 'c': state standbyState isn't supported; wait for completeState",
    ),
    "falling": (document(crossing(EDGED.format("falling"))), "Condition 'c': conditionEdge falling isn't supported"),
    "both edges": (document(crossing(EDGED.format("risingOrFalling"))), "conditionEdge risingOrFalling"),
    "a stop of the act": (
        document(crossing("")).replace("</Act>", STOPS.format(by_value(TIME.format(3)))),
        "Act 'a': its StopTrigger would stop people",
    ),
    "a stop by the car": (
        document(crossing("")).replace("</Act>", STOPS.format(by_car('<TraveledDistanceCondition value="1"/>'))),
        "Act 'a': its StopTrigger would stop people",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_people_cannot_wait_for_is_refused_in_words(check_refused, case):
    check_refused(*REFUSED[case])


def test_who_stands_for_ever_is_measured_to(read):
    script = read(to_child(speed(0, STEP)))
    assert script.suite.tests[0].people[0].beyond == pytest.approx(30 - 0.2 - 9 - FRONT)


def test_stops_that_come_too_late_or_with_the_contact_are_none(read):
    contact = by_car('<CollisionCondition><EntityRef entityRef="walker"/></CollisionCondition>')
    for condition in (by_value(TIME.format(20)), contact):
        assert read(document(crossing("")).replace("</Act>", STOPS.format(condition))).suite.tests[0].people


def test_an_act_that_waits_for_the_contact_is_not_played(read):
    contact = by_car('<CollisionCondition><EntityRef entityRef="walker"/></CollisionCondition>')
    start = f"<StartTrigger><ConditionGroup>{contact}</ConditionGroup></StartTrigger></Act>"
    script = read(document(event([follow([(43.5, -4), (43.5, 6)]), speed(2)])).replace("</Act>", start))
    assert script.suite.tests[0].people[0].stands
    assert "Event 'walks' of walker: a test ends at the contact" in script.suite.assumed
