"""OpenSCENARIO files as scripted tests: what is read, by hand, and what is refused in words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from jaxwalk.scenarios import Scripted
from jaxwalk.scenarios.crash_suite import CrashFileError
from jaxwalk.scenarios.xosc.script_reading import read_xosc
from jaxwalk.sim.script import Trigger
from scenarios.xosc_documents import (
    EGO,
    PARKED,
    RELATIVE,
    ROAD,
    TIME,
    WALKER,
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

NORTH = 1.5707963267948966
FRONT = 3.5
"""Where the car's front begins [m]."""
LINEAR = '<SpeedActionDynamics dynamicsShape="linear" dynamicsDimension="rate" value="2"/>'


def walker(script):
    """The only person of the only test, with the places of the document."""
    (test,) = script.suite.tests
    (person,) = test.people
    return person, np.add(person.path, (FRONT, 0.0))


def test_a_document_becomes_a_test(read):
    script = read(document(crossing(by_value(TIME.format(1.5)))))
    (test,) = script.suite.tests
    assert (test.name, test.speeds, test.begins, test.title) == ("by-hand", (36.0,), 36.0, "by hand")
    person, path = walker(script)
    np.testing.assert_allclose(path, [[43.5, -4], [43.5, 6]], atol=1e-9)
    np.testing.assert_allclose(person.times, [0, 5])
    assert person.time == 1.5


def test_its_numbers_in_the_simulator(tmp_path):
    """At 10 m/s the front is at x = 43.5 after 4 s, so its centre is at x = 41.25 then."""
    arrival = (
        '<TimeToCollisionCondition freespace="true" rule="lessThan" value="2" relativeDistanceType="longitudinal">'
        f"<TimeToCollisionConditionTarget>{world(43.5, 0)}</TimeToCollisionConditionTarget>"
        "</TimeToCollisionCondition>"
    )
    (tmp_path / "a.xosc").write_text(document(crossing(by_car(arrival))))
    source = Scripted.load(tmp_path / "a.xosc")
    script, shift = source.script, read_xosc(tmp_path / "a.xosc").shift
    assert np.asarray(script.trigger).tolist() == [[Trigger.TIME_TO_COLLISION]]
    route = np.asarray(source.route(0).coords)
    place = np.array(source.route(0).interpolate(float(script.place[0, 0])).coords[0]) - shift
    np.testing.assert_allclose(place, [41.25, 0], atol=1e-3)
    begin = np.array(source.route(0).interpolate(float(script.start[0])).coords[0]) - shift
    np.testing.assert_allclose(begin, [1.25, 0], atol=1e-3)
    assert route[-1, 0] - shift[0] > 150
    np.testing.assert_allclose(script.waits_for, 2)
    np.testing.assert_allclose(np.asarray(script.path_time)[:, 0, 0], [0, 5])
    np.testing.assert_allclose(script.kerb, 4 - 1.75, atol=0.011)  # the kerb is beside a lane of 3.5 m


@pytest.mark.parametrize(
    ("condition", "centre"),
    [
        ('<TraveledDistanceCondition value="12"/>', 13.25),
        (f'<ReachPositionCondition tolerance="5">{world(30, 3)}</ReachPositionCondition>', 30 - 4 + 1.25),
        (
            f'<DistanceCondition freespace="true" rule="lessThan" value="15" relativeDistanceType="longitudinal">'
            f"{world(43.5, 0)}</DistanceCondition>",
            43.5 - 15 - 2.25,
        ),
        (
            f'<DistanceCondition freespace="false" rule="lessThan" value="5">{world(30, -3)}</DistanceCondition>',
            30 - 4 + 1.25,
        ),
        (
            '<RelativeDistanceCondition entityRef="walker" freespace="false" rule="lessThan" value="5" '
            'relativeDistanceType="cartesianDistance"/>',
            43.5 - 3 + 1.25,
        ),
    ],
    ids=["travelled", "reached", "front", "reference point", "relative"],
)
def test_places_of_the_car_are_triggers(read, condition, centre):
    person, _ = walker(read(document(crossing(by_car(condition)))))
    assert person.distance == 0
    assert person.beyond == pytest.approx(centre - 1.25), "counted from where the centre begins"


def test_several_places_are_one_place(read):
    near = f'<ReachPositionCondition tolerance="5">{world(30, 0)}</ReachPositionCondition>'
    both = by_car('<TraveledDistanceCondition value="12"/>') + by_car(near)
    assert walker(read(document(crossing(both))))[0].beyond == pytest.approx(25)
    either = by_car('<TraveledDistanceCondition value="12"/>') + "</ConditionGroup><ConditionGroup>" + by_car(near)
    assert walker(read(document(crossing(either))))[0].beyond == pytest.approx(12)


def test_speeds_that_change_are_a_timed_path(read):
    """2 m/s² up to 2 m/s: 1 s and 1 m; after 5 m of the way they stop in 1 s and another metre, and stand."""
    stops = event([speed(0, LINEAR)], by_car('<TraveledDistanceCondition value="5"/>', who="walker"), name="stops")
    starts = event([speed(2, LINEAR)], by_value(TIME.format(1), delay=0.5))
    person, path = walker(read(document(starts + stops)))
    assert person.time == 1.5
    np.testing.assert_allclose(path[-1], [43.5, 2], atol=1e-6)
    at = np.interp([0, 0.5, 1, 2, 3, 3.5, 4, 9], person.times, path[:, 1])
    np.testing.assert_allclose(at, [-4, -3.75, -3, -1, 1, 1.75, 2, 2], atol=3e-3)


def test_events_follow_each_other(read):
    done = '<StoryboardElementStateCondition storyboardElementRef="{}" state="completeState"/>'
    stops = event([speed(0)], by_value(done.format("walks"), delay=2), name="stops")
    again = event([speed(1)], by_value(done.format("stops"), delay=1), name="again")
    person, path = walker(read(document(event([speed(2)]) + stops + again)))
    assert person.time is None
    np.testing.assert_allclose(np.interp([1, 2, 3, 4], person.times, path[:, 1]), [-2, 0, 0, 1], atol=2e-3)


def test_trajectories_with_times(read):
    way = follow([(43.5, -4), (43.5, -4), (43.5, 0)], (0, 1, 3), RELATIVE)
    person, path = walker(read(document(event([way], by_value(TIME.format(2))))))
    assert person.time == 2
    np.testing.assert_allclose(person.times, [0, 1, 3])
    np.testing.assert_allclose(path[:, 1], [-4, -4, 0], atol=1e-9)
    absolute = RELATIVE.replace("relative", "absolute")
    person, _ = walker(read(document(event([follow([(43.5, -4), (43.5, 0)], (3, 5), absolute)]))))
    np.testing.assert_allclose(person.times, [0, 3, 5])


def test_who_has_no_speed_stands(read):
    person, path = walker(read(document()))
    assert person.stands
    np.testing.assert_allclose(path, [[43.5, -4]])


def test_parameters_and_sums(read):
    declared = (
        '<ParameterDeclarations><ParameterDeclaration name="v" value="${$kph / 3.6}"/>'
        '<ParameterDeclaration name="kph" value="54"/></ParameterDeclarations>'
    )
    script = read(document(car=teleport(world("${-(2 + 1) * 2}", "${sin(pi) + 1}")) + speed("$v"), more=declared))
    assert script.suite.tests[0].speeds == (54.0,)


def test_other_positions(read):
    relative = '<Position><RelativeObjectPosition entityRef="Ego" dx="40" dy="-3"/></Position>'
    _, path = walker(read(document(walker=teleport(relative))))
    np.testing.assert_allclose(path, [[40, -3]], atol=1e-9)
    relative = relative.replace("RelativeObject", "RelativeWorld")
    _, path = walker(read(document(walker=teleport(relative), car=teleport(world(0, 0, NORTH)) + speed(10))))
    np.testing.assert_allclose(path - [FRONT, 0], [[40, -3 - FRONT]], atol=1e-9)


def test_positions_on_lanes(read, tmp_path):
    """The lanes meet at y = 2.5; the middle of lane -1 is at 0.5, that of -2 at -2.5, that of 1 at 4."""
    (tmp_path / "road.xodr").write_text(ROAD)
    network = '<RoadNetwork><LogicFile filepath="road.xodr"/></RoadNetwork>'
    lane = '<Position><LanePosition roadId="7" laneId="{}" s="{}" offset="{}"/></Position>'
    script = read(
        document(
            car=teleport(lane.format(-1, 10, 0)) + speed(10), walker=teleport(lane.format(-2, 60, 0.5)), more=network
        )
    )
    np.testing.assert_allclose(script.suite.tests[0].people[0].path, [[50 - 3.5, -2 - 0.5]], atol=1e-6)
    oncoming = read(
        document(
            car=teleport(lane.format(1, 150, 0)) + speed(10), walker=teleport(lane.format(-2, 60, 0)), more=network
        )
    )
    np.testing.assert_allclose(oncoming.suite.tests[0].people[0].path, [[50 - (140 - 3.5), -2.5 - 4]], atol=1e-6)
    waypoints = "".join(f'<Waypoint routeStrategy="shortest">{lane.format(1, s, 0)}</Waypoint>' for s in (160, 20))
    on_route = (
        f'<Position><RoutePosition><RouteRef><Route name="r" closed="false">{waypoints}</Route></RouteRef>'
        '<InRoutePosition><FromLaneCoordinates pathS="10" laneId="1"/></InRoutePosition></RoutePosition></Position>'
    )
    same = read(document(car=teleport(on_route) + speed(10), walker=teleport(lane.format(-2, 60, 0)), more=network))
    np.testing.assert_allclose(same.suite.tests[0].people[0].path, oncoming.suite.tests[0].people[0].path, atol=1e-6)


def test_entries_of_catalogs(read, tmp_path):
    (tmp_path / "catalogs").mkdir()
    catalog = (
        '<OpenSCENARIO><FileHeader revMajor="1" revMinor="2"/><Catalog name="c"><Pedestrian name="e" mass="75">'
        '<ParameterDeclarations><ParameterDeclaration name="w" value="1"/></ParameterDeclarations><BoundingBox>'
        '<Center x="0" y="0" z="0"/><Dimensions length="$w" width="$w" height="2"/></BoundingBox></Pedestrian>'
        "</Catalog></OpenSCENARIO>"
    )
    (tmp_path / "catalogs" / "people.xosc").write_text(catalog)
    places = '<CatalogLocations><PedestrianCatalog><Directory path="catalogs"/></PedestrianCatalog></CatalogLocations>'
    user = '<ScenarioObject name="walker"><CatalogReference catalogName="c" entryName="e"/></ScenarioObject>'
    assert walker(read(document(entities=EGO + user, more=places)))[0].stands
    with pytest.raises(CrashFileError, match="Catalog: is a catalog; name the scenario that uses it"):
        read(catalog)


def test_vehicles_that_stand_hide_what_is_behind_them(read):
    init = f'<Private entityRef="van">{teleport(world(20, -3, NORTH))}</Private>'
    (box,) = read(document(entities=EGO + WALKER + PARKED, init=init)).suite.tests[0].parked
    assert (box.length, box.width, box.heading) == (6.0, 2.0, pytest.approx(90))
    np.testing.assert_allclose(box.at, [20 - FRONT, -3 + 1], atol=1e-6)


def test_what_the_tested_car_does_is_left_to_drivers_and_said(read):
    brakes = event([speed(0)], by_value(TIME.format(1)), name="brakes", actor="Ego")
    assert "Event 'brakes' of Ego isn't played: the driver under test drives" in read(document(brakes)).suite.assumed


def test_the_file_of_the_documentation_is_read(read):
    page = (Path(__file__).parents[2] / "docs" / "crash-tests.md").read_text()
    person, path = walker(read(page.split('```xml title="mine.xosc"\n')[1].split("```")[0]))
    assert (person.time_to_collision, person.beyond) == (2, 60 - 3.5)
    np.testing.assert_allclose(person.times, [0, 6])
    np.testing.assert_allclose(path, [[60, -4], [60, 5]], atol=1e-9)
