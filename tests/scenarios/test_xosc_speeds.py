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
