"""Speeds that change: in the order of their times, from standing on, and what can't be is refused."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.scenarios.crash_suite import CrashFileError
from scenarios.xosc_documents import (
    RELATIVE,
    STEP,
    TIME,
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

BEGIN = teleport(world(43.5, -4, 1.5707963))
DONE = '<StoryboardElementStateCondition storyboardElementRef="{}" state="completeState"/>'
LINEAR = '<SpeedActionDynamics dynamicsShape="linear" dynamicsDimension="{}" value="{}"/>'
NEAR = by_car('<TraveledDistanceCondition value="12"/>')
OWN = by_car('<TraveledDistanceCondition value="{}"/>', who="walker")


def at(script, *seconds):
    """Where the walker is so long after the start [m north of the kerb]; for who waits for the car, after that."""
    (person,) = script.suite.tests[0].people
    after = np.array(seconds) - (person.time or 0.0)
    return np.interp(after, person.times, [y + 4 for _, y in person.path])


@pytest.mark.parametrize("zero", ["0", "0.0"])
@pytest.mark.parametrize(
    ("condition", "trigger"),
    [(by_value(TIME.format(1.5)), "time"), (NEAR, "distance")],
    ids=["time", "car"],
)
def test_who_has_a_speed_of_0_in_init_stands_until_triggered(read, zero, condition, trigger):
    script = read(document(crossing(condition), walker=BEGIN + speed(zero)))
    (person,) = script.suite.tests[0].people
    assert getattr(person, trigger) is not None
    np.testing.assert_allclose(person.times, [0, 5])


def test_who_stands_by_a_speed_of_0_is_who_conditions_measure_to(read):
    near = by_car(
        '<RelativeDistanceCondition entityRef="walker" freespace="false" rule="lessThan" value="5" '
        'relativeDistanceType="cartesianDistance"/>'
    )
    assert read(document(crossing(near), walker=BEGIN + speed("0.0"))).suite.tests[0].people[0].distance == 0


def test_changes_come_in_the_order_of_their_times(read):
    """The file has the stop first. They walk from 1 s to 3 s at 2 m/s, and from 4 s on at 1 m/s."""
    again = event([speed(1)], by_value(TIME.format(4)), name="again")
    stops = event([speed(0)], by_value(TIME.format(3)), name="stops")
    script = read(document(again + stops + event([speed(2)], by_value(TIME.format(1)))))
    assert script.suite.tests[0].people[0].time == 1
    np.testing.assert_allclose(at(script, 1, 2, 3, 4, 6), [0, 2, 4, 4, 6], atol=2e-3)


def test_a_later_change_ends_one_that_is_not_over(read):
    """From 0 to 4 m/s in 4 s; after 2 s they are 2 m/s fast and 2 m far, and stop at once."""
    stops = event([speed(0)], by_value(TIME.format(2)), name="stops")
    script = read(document(stops + event([speed(4, LINEAR.format("time", 4))])))
    np.testing.assert_allclose(at(script, 1, 2, 5), [0.5, 2, 2], atol=2e-3)


def test_a_way_walked_counts_from_where_it_was_reached(read):
    """3 m are reached after 1.5 s; 2 s later, after another change, they stop."""
    slows = event([speed(1)], by_value(TIME.format(2)), name="slows")
    stops = event([speed(0)], OWN.format(3).replace('delay="0"', 'delay="2"'), name="stops")
    script = read(document(event([speed(2)]) + slows + stops))
    np.testing.assert_allclose(at(script, 2, 3.5, 9), [4, 5.5, 5.5], atol=2e-3)


def test_what_follows_the_beginning_of_an_event_does_not_wait_for_its_end(read):
    """Up to 4 m/s in 4 s, but 2 s after the beginning they stop: 2 m far, as 2 s at 1 m/s on average."""
    started = by_value(DONE.format("walks").replace("completeState", "startTransition"), delay=2)
    script = read(document(event([speed(4, LINEAR.format("time", 4))]) + event([speed(0)], started, name="stops")))
    np.testing.assert_allclose(at(script, 1, 2, 5), [0.5, 2, 2], atol=2e-3)


def test_a_change_after_the_longest_test_never_comes(read):
    """No test lasts longer than 60 s: at 1 m/s they come 60 m far."""
    stops = event([speed(0)], by_value(TIME.format(70)), name="stops")
    np.testing.assert_allclose(at(read(document(event([speed(1)]) + stops)), 30, 60), [30, 60], atol=2e-3)


@pytest.mark.parametrize("condition", [OWN.format(4), by_value(DONE.format("walks"), delay=2)], ids=["way", "event"])
def test_who_waits_for_the_car_changes_their_speed_by_themselves_afterwards(read, condition):
    """At 2 m/s, they stop after 4 m, or 2 s after the event that let them go."""
    script = read(document(event([speed(2)], NEAR) + event([speed(0)], condition, name="stops")))
    assert script.suite.tests[0].people[0].beyond == pytest.approx(12)
    np.testing.assert_allclose(at(script, 1, 2, 5), [2, 4, 4], atol=2e-3)


def test_the_delay_of_a_trigger_by_the_car_comes_before_the_times(read):
    """They stand for 1.5 s after the car has come, and then walk 10 m in 5 s."""
    way = follow([(43.5, -4), (43.5, 6)], (0, 5), RELATIVE)
    script = read(document(event([way], NEAR.replace('delay="0"', 'delay="1.5"'))))
    np.testing.assert_allclose(at(script, 0, 1.5, 4, 6.5), [0, 0, 5, 10], atol=2e-3)


def test_who_follows_times_on_one_spot_stands(read):
    script = read(document(event([follow([(43.5, -4), (43.5, -4)], (0, 5), RELATIVE)])))
    assert script.suite.tests[0].people[0].stands


@pytest.mark.parametrize("begin", [(), ((43.5, -4),)], ids=["from where they stand", "from their first waypoint"])
def test_people_walk_along_a_route(read, begin):
    """Two legs of 3 m and 4 m at 1 m/s."""
    waypoints = "".join(f"<Waypoint>{world(*place)}</Waypoint>" for place in (*begin, (43.5, -1), (47.5, -1)))
    route = PLANNED.format(f'<AssignRouteAction><Route name="r">{waypoints}</Route></AssignRouteAction>')
    (person,) = read(document(event([route, speed(1)]))).suite.tests[0].people
    np.testing.assert_allclose(person.times, [0, 3, 7], atol=1e-6)
    np.testing.assert_allclose(person.path, [[40, -4], [40, -1], [44, -1]], atol=1e-6)


def test_people_walk_straight_to_a_position(read):
    """5 m, to the place 3 m farther and 4 m to the north, at 1 m/s."""
    there = PLANNED.format(f"<AcquirePositionAction>{world(46.5, 0)}</AcquirePositionAction>")
    (person,) = read(document(event([there, speed(1)]))).suite.tests[0].people
    np.testing.assert_allclose(person.times, [0, 5], atol=1e-6)
    np.testing.assert_allclose(person.path, [[40, -4], [43, 0]], atol=1e-6)


def test_a_speed_in_init_that_is_gathered(read):
    """2 m/s² up to 2 m/s."""
    script = read(document(walker=BEGIN + speed(2, LINEAR.format("rate", 2))))
    np.testing.assert_allclose(at(script, 0.5, 1, 2), [0.25, 1, 3], atol=2e-3)


def test_who_stops_at_the_end_of_a_way_stands_there_anyway(read):
    stops = event([speed(0)], by_value(DONE.format("walks")), name="stops")
    for crosses in (crossing(""), event([follow([(43.5, -4), (43.5, 6)], (0, 5), RELATIVE)])):
        np.testing.assert_allclose(at(read(document(crosses + stops)), 1, 4, 9), [2, 8, 10], atol=2e-3)


def test_who_stands_in_init_follows_times(read):
    """Init may say that they stand; the times of the trajectory say the rest."""
    for events, walker in ((TIMED, BEGIN + speed(0)), (TIMED, BEGIN + speed("0.0"))):
        np.testing.assert_allclose(at(read(document(events, walker=walker)), 1, 5), [2, 10], atol=2e-3)


TIMED = event([follow([(43.5, -4), (43.5, 6)], (0, 5), RELATIVE)])
ABSOLUTE = RELATIVE.replace("relative", "absolute")
PLANNED = "<PrivateAction><RoutingAction>{}</RoutingAction></PrivateAction>"
CAR_WAY = follow([(0, 0), (100, 0)], (0, 10), RELATIVE)
REFUSED = {
    "a stop within a timed trajectory": (
        document(TIMED + event([speed(0)], by_value(TIME.format(2)), name="stops")),
        "SpeedAction: the times of the trajectory say the speed",
    ),
    "on from the end of a way": (
        document(crossing("") + event([speed(1)], by_value(DONE.format("walks")), name="on")),
        "people stand at the end of their way, so that nothing comes after 'walks'",
    ),
    "a way that begins under way": (
        document(event([follow([(43.5, -4), (43.5, 6)])], by_value(TIME.format(2))), walker=BEGIN + speed(1)),
        "RoutingAction: begins when the person has walked 2.0 m",
    ),
    "a way that waits for the car": (
        document(event([follow([(43.5, -4), (43.5, 6)])], NEAR), walker=BEGIN + speed(1)),
        "waits for the car at a place",
    ),
    "a stop by the car": (
        document(crossing("") + event([speed(0)], NEAR, name="stops")),
        "SpeedAction: waits for the car at a place after the person has set out; a person waits once",
    ),
    "a stop at a time": (
        document(crossing(NEAR) + event([speed(0)], by_value(TIME.format(6)), name="stops")),
        "waits for a time, and another one for the car at a place; a person waits once",
    ),
    "scale": (document(TIMED.replace('scale="1"', 'scale="2"')), "Timing: simulators differ on what scale 2 is"),
    "offset": (document(TIMED.replace('offset="0"', 'offset="3"')), "Timing: simulators differ on what offset 3 is"),
    "shape": (
        document(walker=BEGIN + speed(2, LINEAR.format("time", 4).replace("linear", "cubic"))),
        "SpeedActionDynamics: dynamicsShape cubic isn't supported; write step or linear",
    ),
    "the car's Init": (
        document(car=teleport(world(0, 0)) + speed(10, LINEAR.format("time", 4))),
        "as 'Ego': its speed in Init is gathered; write dynamicsShape step",
    ),
    "the car's times": (
        document(car=teleport(world(0, 0)) + CAR_WAY.replace('scale="1"', 'scale="2"')),
        "Timing: simulators differ on what scale 2 is",
    ),
    "another dimension": (
        document(walker=BEGIN + speed(2, LINEAR.format("jerk", 4))),
        "SpeedActionDynamics: dynamicsDimension jerk isn't supported; use time",
    ),
    "backwards": (document(walker=BEGIN + speed(-1)), "AbsoluteTargetSpeed: below 0; turn the entity round"),
    "a profile": (
        document(walker=BEGIN + speed(1).replace("SpeedAction>", "SpeedProfileAction>")),
        "SpeedProfileAction: isn't supported; write a SpeedAction",
    ),
    "as fast as another": (
        document(walker=BEGIN + speed(1).replace("AbsoluteTargetSpeed", "RelativeTargetSpeed")),
        "RelativeTargetSpeed: isn't supported; write an AbsoluteTargetSpeed",
    ),
    "farther than the way": (
        document(event([speed(2)]) + event([speed(0)], OWN.format(150), name="stops")),
        "TraveledDistanceCondition: the person never walks 150 m; correct it",
    ),
    "after nobody's event": (
        document(event([speed(2)]) + event([speed(0)], by_value(DONE.format("jumps")), name="stops")),
        "StoryboardElementStateCondition: 'jumps' isn't an earlier event of the same person",
    ),
    "times that wait for the car": (
        document(event([follow([(43.5, -4), (43.5, 6)], (0, 5), ABSOLUTE)], NEAR)),
        "Timing: absolute times can't wait for the car; write relative ones",
    ),
    "times before the event": (
        document(event([follow([(43.5, -4), (43.5, 6)], (1, 5), ABSOLUTE)], by_value(TIME.format(3)))),
        "Timing: the trajectory begins before its event; write relative times",
    ),
    "times before the start": (
        document(event([follow([(43.5, -4), (43.5, 6)], (-1, 5), RELATIVE)])),
        "Polyline: begins before the time 0; correct its times",
    ),
    "times that fall": (
        document(event([follow([(43.5, -4), (43.5, 6)], (5, 5), RELATIVE)])),
        "Polyline: the times of its vertices don't rise; correct them",
    ),
    "times after nothing": (
        document(event([follow([(43.5, -4), (43.5, 6)], (0, 5), RELATIVE)], by_value(DONE.format("jumps")))),
        "FollowTrajectoryAction: waits for 'jumps', but nothing comes before",
    ),
    "far from the way": (
        document(event([follow([(43.5, -8), (43.5, 6)]), speed(2)])),
        "Trajectory: begins 4.0 m from where the pedestrian begins; correct one of them",
    ),
    "another way": (
        document(event([PLANNED.format("<RandomRouteAction/>")])),
        "RandomRouteAction: isn't supported; write a FollowTrajectoryAction",
    ),
    "init": (
        document(walker=BEGIN + "<PrivateAction><LateralAction><LaneOffsetAction/></LateralAction></PrivateAction>"),
        "Init: LateralAction isn't supported",
    ),
    "ever changing": (
        document("".join(event([speed(1 + n % 2)], by_value(TIME.format(n / 100))) for n in range(300))),
        "300 changes of speed",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_people_cannot_do_is_refused_in_words(check_refused, case):
    check_refused(*REFUSED[case])


def test_the_speed_of_the_car_is_that_of_its_trajectory(read):
    """Without times its own speed counts; a trajectory that begins later isn't the speed at the start."""
    place = teleport(world(0, 0))
    begins = [read(text).suite.tests[0].begins for text in (
        document(car=place + CAR_WAY),
        document(event([CAR_WAY], by_value(TIME.format(3)), actor="Ego"), car=place),
    )]  # fmt: skip
    assert begins == [36.0, 0.0]
    unsaid = follow([(0, 0), (100, 0)], (0, 5))
    assert read(document(car=place + speed(10) + unsaid)).suite.tests[0].speeds == (36.0,)
    with pytest.raises(CrashFileError, match="nothing says how fast it drives"):
        read(document(car=place + unsaid))


@pytest.mark.parametrize(
    ("dynamics", "way"), [(LINEAR.format("time", 1e9), 0.0), (LINEAR.format("rate", 1e-9), 0.0), (STEP, 120.0)]
)
def test_a_change_that_takes_for_ever_is_read_at_once(read, dynamics, way):
    """Who gathers 2 m/s over 30 years has hardly moved after a minute; in a step, it is 2 m/s x 60 s."""
    (person,) = read(document(event([speed(2, dynamics)]))).suite.tests[0].people
    assert person.times == (0.0, 60.0)
    (_, begin), (_, end) = person.path
    assert end - begin == pytest.approx(way, abs=0.01)
