"""People who are at a place when the unbraked car is at another, and what can't be met so."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.scenarios.crash_suite import CrashFileError
from scenarios.xosc_documents import TIME, by_value, document, event, follow, speed, teleport, world


def synchronized(metres, target, final, *, master="Ego", place=None):
    """The walker is `metres` along the way, or at a place, when the car's rear axle is at x = target."""
    along = f"<TrajectoryPosition s='{metres}'><TrajectoryRef>{TRAJECTORY}</TrajectoryRef></TrajectoryPosition>"
    place = along if place is None else inner(place)
    return (
        f'<PrivateAction><SynchronizeAction masterEntityRef="{master}"><TargetPositionMaster>{inner(world(target, 0))}'
        f"</TargetPositionMaster><TargetPosition>{place}</TargetPosition><FinalSpeed>{final}</FinalSpeed>"
        "</SynchronizeAction></PrivateAction>"
    )


def inner(position):
    return position.removeprefix("<Position>").removesuffix("</Position>")


WAY = follow([(43.5, -4), (43.5, 6)])
TRAJECTORY = WAY[WAY.index("<Trajectory ") : WAY.index("<TimeReference")]
STEADY = '<AbsoluteSpeed value="2"><TargetDistanceSteadyState distance="3"/></AbsoluteSpeed>'


def test_people_who_meet_the_car_at_a_place(read):
    """One metre at 1 m/s on average and three at 2 m/s: 2.5 s. The axle is at 40 when the centre is at 41.25."""
    (person,) = read(document(event([synchronized(4, 40, STEADY)]), walker=WAY)).suite.tests[0].people
    assert person.time_to_collision == pytest.approx(2.5, abs=0.01)
    assert person.beyond == pytest.approx(40)
    np.testing.assert_allclose(np.interp([1, 2.5], person.times, [y for _, y in person.path]), [-3, 0], atol=0.02)
    with pytest.raises(CrashFileError, match=r"would set out 0\.5 s before the start"):
        read(document(event([synchronized(4, 20, STEADY)]), walker=WAY))
    with pytest.raises(CrashFileError, match="TargetPosition: is where the way of the pedestrian begins"):
        read(document(event([synchronized(0, 40, STEADY)]), walker=WAY))
    stops = event([speed(0)], by_value(TIME.format(3)), name="stops")
    for late in (stops, event([speed(1)], name="on")):
        with pytest.raises(CrashFileError, match="SynchronizeAction: is read only alone"):
            read(document(event([synchronized(4, 40, STEADY)]) + late, walker=WAY))


def test_people_who_meet_the_car_from_init_on(read):
    (person,) = read(document(walker=WAY + synchronized(4, 40, STEADY))).suite.tests[0].people
    assert person.time_to_collision == pytest.approx(2.5, abs=0.01)


STEADY_AT_ONCE = '<AbsoluteSpeed value="2"/>'


def test_the_place_of_a_meeting_can_be_a_position(read):
    """4 m of the way at 2 m/s, from setting out on: 2 s."""
    text = document(walker=WAY + synchronized(0, 40, STEADY_AT_ONCE, place=world(43.5, 0)))
    (person,) = read(text).suite.tests[0].people
    assert person.time_to_collision == pytest.approx(2)
    np.testing.assert_allclose(np.interp([1, 2], person.times, [y for _, y in person.path]), [-2, 0], atol=1e-6)


HERE = f"<AssignRouteAction><Route name='r'><Waypoint>{world(43.5, -4)}</Waypoint></Route></AssignRouteAction>"
NO_WAY = teleport(world(43.5, -4)) + f"<PrivateAction><RoutingAction>{HERE}</RoutingAction></PrivateAction>"
REFUSED = {
    "another car": (
        document(walker=WAY + synchronized(4, 40, STEADY, master="walker")),
        "SynchronizeAction: masterEntityRef isn't the tested car; let it be",
    ),
    "standing": (
        document(walker=WAY + synchronized(4, 40, STEADY_AT_ONCE.replace("2", "0"))),
        "FinalSpeed: is 0; people walk when the car comes",
    ),
    "no way": (
        document(walker=NO_WAY + synchronized(4, 40, STEADY)),
        "TargetPosition: the pedestrian has no way to it; write a FollowTrajectoryAction",
    ),
    "beside the way": (
        document(walker=WAY + synchronized(0, 40, STEADY, place=world(46.5, 0))),
        "TargetPosition: lies 3.0 m beside the way of the pedestrian; correct it",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_meeting_that_cannot_be_is_refused_in_words(check_refused, case):
    check_refused(*REFUSED[case])
