"""Roads of OpenDRIVE files, and positions in their coordinates: where they are, by hand, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from jaxwalk.scenarios.xosc.plain_roads import PlainRoads
from scenarios.xosc_documents import EGO, PARKED, ROAD, WALKER, document, speed, teleport, world

NETWORK = '<RoadNetwork><LogicFile filepath="road.xodr"/></RoadNetwork>'
LANE = '<Position><LanePosition roadId="{}" laneId="{}" s="{}"/></Position>'
RELATIVE_LANE = '<Position><RelativeLanePosition entityRef="Ego" dLane="{}" ds="{}" offset="0.5"/></Position>'
ON_LANE = teleport(LANE.format(7, -1, 10)) + speed(10)
"""The car begins at s = 10, which is x = 0; its front at x = 3.5, in the middle of lane -1, at y = 0.5."""
NORTH = math.pi / 2


@pytest.fixture
def road_file(tmp_path):
    """Write a road beside the document; by default the one of `ROAD`."""

    def write(text=ROAD):
        (tmp_path / "road.xodr").write_text(text)
        return tmp_path / "road.xodr"

    return write


def bent(length, shape):
    """A road that begins at the origin, to the east."""
    place = f'<geometry s="0" x="0" y="0" hdg="0" length="{length}">{shape}</geometry>'
    return f'<OpenDRIVE><road id="7"><planView>{place}</planView></road></OpenDRIVE>'


TURN = 0.02 * 10 / 2
"""What a curve of 10 m turns whose curvature grows evenly from 0 to 0.02 / m [rad]."""
CUBIC = '<paramPoly3 aU="0" bU="{}" cU="0" dU="0" aV="0" bV="0" cV="{}" dV="0" pRange="{}"/>'
BENDS = {
    "a quarter of a circle": (bent(100, '<arc curvature="0.02"/>'), 25 * math.pi, (50, 50, NORTH)),
    "a clothoid, by its series": (
        bent(10, '<spiral curvStart="0" curvEnd="0.02"/>'),
        10,
        (10 * (1 - TURN**2 / 10), 10 * (TURN / 3 - TURN**3 / 42), TURN),
    ),
    "a parabola, in shares": (bent(200, CUBIC.format(200, 10, "normalized")), 100, (100, 2.5, math.atan(0.05))),
    "a parabola, in metres": (bent(200, CUBIC.format(1, 0.001, "arcLength")), 100, (100, 10, math.atan(0.2))),
}


@pytest.mark.parametrize("case", BENDS)
def test_a_road_bends_as_its_geometry_says(road_file, case):
    text, s, place = BENDS[case]
    np.testing.assert_allclose(PlainRoads(road_file(text)).at("7", s, 0.0), place, atol=2e-3)


WITHOUT_GEOMETRY = ROAD[: ROAD.index("<geometry")] + ROAD[ROAD.index("</planView>") :]
WITHOUT_LANES = ROAD[: ROAD.index("<laneSection")] + ROAD[ROAD.index("</lanes>") :]
ROADS = {
    "no such road": (ROAD, (9, -1, 10), "LogicFile road.xodr: has no road 9; correct roadId"),
    "no such lane": (ROAD, (7, -5, 10), "road 7: has no lane -5 at s = 10; correct laneId"),
    "half a lane": (ROAD, (7, -1.5, 10), "LanePosition: laneId -1.5 is no whole number; correct it"),
    "beyond its end": (ROAD, (7, -1, 250), "road 7: is 200 m long, there is no s = 250; correct it"),
    "no geometry": (WITHOUT_GEOMETRY, (7, -1, 10), "road 7: has no geometry; correct the OpenDRIVE file"),
    "no lanes": (WITHOUT_LANES, (7, -1, 10), "road 7: has no lanes at s = 10; correct the OpenDRIVE file"),
    "below 0": (ROAD.replace('"200"', '"-200"'), (7, -1, 10), "geometry: a length of -200 m; correct the OpenDRIVE"),
    "another curve": (ROAD.replace("<line/>", "<poly3/>"), (7, -1, 10), "is no line, arc, spiral or paramPoly3"),
}


@pytest.mark.parametrize("case", ROADS)
def test_a_lane_that_cannot_be_found_is_refused_in_words(check_refused, road_file, case):
    text, lane, message = ROADS[case]
    road_file(text)
    check_refused(document(walker=teleport(LANE.format(*lane)), more=NETWORK), message)


ROAD_POSITION = '<Position><RoadPosition roadId="7" s="60" t="-4.5"/></Position>'
BESIDE = {
    "on the road": (ROAD_POSITION, (50, 2 - 4.5)),
    "from a lane": (RELATIVE_LANE.format(-1, 50), (50, -2.5 + 0.5)),
}


@pytest.mark.parametrize("case", BESIDE)
def test_places_on_a_road_are_where_its_line_is(read, road_file, case):
    """The road's line lies at y = 2, and the middle of lane -2 at y = -2.5."""
    road_file()
    position, place = BESIDE[case]
    (person,) = read(document(car=ON_LANE, walker=teleport(position), more=NETWORK)).suite.tests[0].people
    np.testing.assert_allclose(person.path, [np.subtract(place, (3.5, 0.5))], atol=1e-6)


def route(last, place):
    """A position on a route of two waypoints of lane -1."""
    waypoints = "".join(f'<Waypoint routeStrategy="shortest">{LANE.format(7, -1, s)}</Waypoint>' for s in (20, last))
    return (
        f'<Position><RoutePosition><RouteRef><Route name="r" closed="false">{waypoints}</Route></RouteRef>'
        f"<InRoutePosition>{place}</InRoutePosition></RoutePosition></Position>"
    )


POSITIONS = {
    "a lane from no lane": (RELATIVE_LANE.format(-1, 50), "its entity doesn't begin at a LanePosition"),
    "across the middle": (RELATIVE_LANE.format(2, 50), "a lane on the other side of the road; write a LanePosition"),
    "metres of a route": (
        route(100, '<FromRoadCoordinates pathS="10" t="0"/>'),
        "RoutePosition: is read only with FromLaneCoordinates",
    ),
    "beyond the road": (
        route(100, '<FromLaneCoordinates pathS="190" laneId="-1"/>'),
        "RoutePosition: lies beyond the road of the first waypoint",
    ),
    "from itself": (
        '<Position><RelativeWorldPosition entityRef="walker" dx="1" dy="1"/></Position>',
        "entity 'walker': its position counts from itself; write a WorldPosition",
    ),
}


@pytest.mark.parametrize("case", POSITIONS)
def test_a_position_that_is_nowhere_is_refused_in_words(check_refused, road_file, case):
    road_file()
    position, message = POSITIONS[case]
    car = teleport(world(0, 0)) + speed(10) if case == "a lane from no lane" else ON_LANE
    check_refused(document(car=car, walker=teleport(position), more=NETWORK), message)


@pytest.mark.parametrize(
    ("orientation", "degrees"),
    [
        ("", 90),
        ('<Orientation h="0.5"/>', math.degrees(0.5)),
        ('<Orientation type="relative" h="-0.5"/>', 90 - math.degrees(0.5)),
    ],
    ids=["as the other", "from the east", "from the other"],
)
def test_an_orientation_counts_from_the_east_unless_it_is_relative(read, orientation, degrees):
    """The van stands beside the car, which drives north; by default it does as well."""
    beside = f'<Position><RelativeObjectPosition entityRef="Ego" dx="20" dy="-4">{orientation}'
    van = f'<Private entityRef="van">{teleport(beside + "</RelativeObjectPosition></Position>")}</Private>'
    car, walker = teleport(world(0, 0, NORTH)) + speed(10), teleport(world(4, 40))
    (box,) = read(document(car=car, walker=walker, entities=EGO + WALKER + PARKED, init=van)).suite.tests[0].parked
    assert box.heading == pytest.approx(degrees)
