"""Which car is tested, and the way on which it goes, by hand; and ways on which none can go."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.maps.network_file import parse_network
from jaxwalk.scenarios.xosc.elements import XoscRefusal
from jaxwalk.scenarios.xosc.made_street import Strip, made_street, rounded
from scenarios.xosc_documents import EGO, PARKED, ROAD, WALKER, document, speed, teleport, world

BEGIN = teleport(world(0, 0)) + speed(10)
NETWORK = '<RoadNetwork><LogicFile filepath="road.xodr"/></RoadNetwork>'
LANE = '<Position><LanePosition roadId="7" laneId="-1" s="{}" offset="{}"/></Position>'
PLANNED = "<PrivateAction><RoutingAction>{}</RoutingAction></PrivateAction>"


def north_of(script, *easts):
    """How far north the car's way lies at some places to the east [m], in the document's coordinates."""
    line = parse_network(script.track.text, "street").lanes[0].line - script.shift
    return np.interp(easts, line[:, 0], line[:, 1])


def trip(*places):
    waypoints = "".join(f'<Waypoint routeStrategy="shortest">{one}</Waypoint>' for one in places)
    return PLANNED.format(f'<AssignRouteAction><Route name="r" closed="false">{waypoints}</Route></AssignRouteAction>')


WAYS = {
    "to a position": PLANNED.format(f"<AcquirePositionAction>{world(101.25, 10)}</AcquirePositionAction>"),
    "along a route": trip(world(-20, 0), world(101.25, 10)),
}


@pytest.mark.parametrize("case", WAYS)
def test_the_car_goes_straight_to_what_lies_ahead_and_on(read, case):
    """From its centre at x = 1.25, 10 m to the north on 100 m; what lies behind it is passed over."""
    assert north_of(read(document(car=BEGIN + WAYS[case])), 51.25, 101.25, 121.25) == pytest.approx(
        [5, 10, 12], abs=0.01
    )


def test_a_car_whose_action_names_no_place_goes_straight_on(read):
    car = BEGIN + PLANNED.format("<RandomRouteAction/>")
    assert north_of(read(document(car=car)), 50, 120) == pytest.approx([0, 0], abs=1e-6)


def test_waypoints_on_a_road_lead_straight_or_are_refused(read, check_refused, tmp_path):
    """Roads that bend between waypoints aren't followed: here by 4 m on 4 m, though the lane leads east."""
    (tmp_path / "road.xodr").write_text(ROAD)
    car = teleport(LANE.format(10, 0)) + speed(10)
    straight = read(document(car=car + trip(LANE.format(60, 0)), more=NETWORK))
    assert north_of(straight, 30, 60) == pytest.approx([0.5, 0.5], abs=1e-6)
    bent = trip(LANE.format(14, 4), LANE.format(60, 0))
    check_refused(document(car=car + bent, more=NETWORK), "Route: roads lead from one waypoint to the next in a bend")


def test_a_corner_is_rounded_until_the_car_can_turn():
    """The corner itself is cut by less than 3 m, and all else stays where it was."""
    line = rounded(np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 40.0]]))
    np.testing.assert_allclose(line[[0, -1]], [[0, 0], [40, 40]], atol=1e-9)
    away = np.minimum(np.abs(line[:, 1]), np.abs(line[:, 0] - 40))
    assert 1 < np.hypot(*(line - (40, 0)).T).min() < 3
    assert away[np.hypot(*(line - (40, 0)).T) > 8].max() < 1e-6


def test_a_way_back_is_too_sharp_for_the_car():
    with pytest.raises(XoscRefusal, match="the way of the tested car bends too sharply for it; write a smoother one"):
        rounded(np.array([[0.0, 0.0], [50.0, 0.0], [0.0, 0.0]]))


def test_a_street_along_a_way_in_circles_is_refused():
    """One and a half rounds of 8 m, with 20 m of roadway on the outside."""
    turn = np.linspace(0, 3 * np.pi, 60)
    line = np.concatenate([[[0.0, 0.0]], np.stack([20 + 8 * np.sin(turn), 8 - 8 * np.cos(turn)], axis=1)])
    with pytest.raises(XoscRefusal, match="bends too sharply for a street along it; write a smoother one"):
        made_street(Strip(line, 0.0, right=20.0, left=1.75), np.zeros((1, 2)), "rounds")


VAN = f'<Private entityRef="van">{teleport(world(20, -9))}{{}}</Private>'
TYPED = EGO.replace("<Properties/>", '<Properties><Property name="type" value="ego_vehicle"/></Properties>')
TESTED = {
    "the one that moves": document(entities=EGO + WALKER + PARKED, init=VAN.format("")),
    "the one whose property says so": document(entities=TYPED + WALKER + PARKED, init=VAN.format(""), car=BEGIN),
}


@pytest.mark.parametrize("case", TESTED)
def test_a_car_of_any_name_can_be_the_tested_one(read, case):
    """The van stands, 9 m beside it."""
    test = read(TESTED[case].replace('"Ego"', '"silver"')).suite.tests[0]
    assert test.speeds == (36.0,)
    assert [box.length for box in test.parked] == [6.0]


UNCLEAR = {
    "two that move": (
        document(entities=EGO + WALKER + PARKED, init=VAN.format(speed(5))),
        "Entities: 2 vehicles, and none is called Ego; name the car that is tested so",
    ),
    "no vehicle": (
        document(entities=EGO.replace("Vehicle", "MiscObject") + WALKER),
        "Entities: no Vehicle is called Ego; name the car that is tested so",
    ),
}


@pytest.mark.parametrize("case", UNCLEAR)
def test_which_car_is_tested_must_be_clear(check_refused, case):
    text, message = UNCLEAR[case]
    check_refused(text.replace('"Ego"', '"silver"'), message)
