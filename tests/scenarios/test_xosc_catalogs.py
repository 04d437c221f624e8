"""What is wrong in a catalog is named, with its file and its entry; and files that only cost time."""

from __future__ import annotations

import time

import pytest

from jaxwalk.scenarios.crash_suite import CrashFileError
from scenarios.xosc_documents import (
    EGO,
    RELATIVE,
    ROAD,
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

PLACES = (
    '<CatalogLocations><PedestrianCatalog><Directory path="catalogs"/></PedestrianCatalog><TrajectoryCatalog>'
    '<Directory path="catalogs"/></TrajectoryCatalog></CatalogLocations>'
)
USER = '<ScenarioObject name="walker"><CatalogReference catalogName="c" entryName="e"/></ScenarioObject>'
CATALOG = '<OpenSCENARIO><FileHeader revMajor="1" revMinor="2"/><Catalog name="c">{}</Catalog></OpenSCENARIO>'
PERSON = (
    '<Pedestrian name="e" mass="75"><BoundingBox><Center x="0" y="0" z="0"/><Dimensions length="{}" width="0.5" '
    'height="2"/></BoundingBox></Pedestrian>'
)
WAY = follow([(43.5, -4), (43.5, 6)])
WAY_OF_CATALOG = (
    WAY[: WAY.index("<Trajectory ")]
    + '<TrajectoryRef><CatalogReference catalogName="c" entryName="way"/></TrajectoryRef>'
    + WAY[WAY.index("<TimeReference") :]
)
NEAR = by_car(
    '<RelativeDistanceCondition entityRef="walker" freespace="true" rule="lessThan" value="5" '
    'relativeDistanceType="longitudinal"/>'
)


@pytest.fixture
def with_catalog(read, tmp_path):
    def reading(entries, text):
        (tmp_path / "catalogs").mkdir()
        (tmp_path / "catalogs" / "people.xosc").write_text(entries)
        return read(text)

    return reading


BY_CATALOG = document(crossing(NEAR), entities=EGO + USER, more=PLACES)
TRAJECTORY = '<Trajectory name="way" closed="{}"><Shape><Polyline><Vertex>{}</Vertex></Polyline></Shape></Trajectory>'
FAULTS = {
    "no XML": ("nothing", BY_CATALOG, "catalog people.xosc: not XML that can be read"),
    "parameter": (
        CATALOG.format(PERSON.format("$l")),
        BY_CATALOG,
        "CatalogReference c/e in people.xosc: parameter $l isn't declared",
    ),
    "size": (
        CATALOG.format(PERSON.format("large")),
        BY_CATALOG,
        "CatalogReference c/e in people.xosc: Dimensions: length 'large' is no number",
    ),
    "short": (
        CATALOG.format(TRAJECTORY.format("false", world(0, 0))),
        document(event([WAY_OF_CATALOG, speed(2)]), more=PLACES),
        "CatalogReference c/way in people.xosc: Polyline: needs two vertices or more",
    ),
    "closed": (
        CATALOG.format(TRAJECTORY.format("true", world(0, 0))),
        document(event([WAY_OF_CATALOG, speed(2)]), more=PLACES),
        "CatalogReference c/way in people.xosc: Trajectory: closed ones aren't supported",
    ),
}


@pytest.mark.parametrize("case", FAULTS)
def test_errors_in_catalogs_name_file_and_entry(with_catalog, case):
    entries, text, message = FAULTS[case]
    with pytest.raises(CrashFileError, match=r"by-hand\.xosc: ") as error:
        with_catalog(entries, text)
    assert message in str(error.value)
    assert str(error.value).count("people.xosc") == 1


@pytest.mark.parametrize("place", ["catalogs", "catalogs/people.xosc"], ids=["its folder", "the file itself"])
def test_entries_are_found_wherever_their_file_is_named(with_catalog, place):
    """A folder that isn't there is passed over. The van is an entry as well: 2 m long, its middle over its place."""
    nowhere = '<CatalogLocations><VehicleCatalog><Directory path="nowhere"/></VehicleCatalog>'
    places = PLACES.replace("<CatalogLocations>", nowhere).replace('"catalogs"', f'"{place}"')
    van = PERSON.format(2).replace("Pedestrian", "Vehicle").replace('name="e"', 'name="van"')
    entities = EGO + USER + USER.replace('"walker"', '"van"').replace('"e"', '"van"')
    init = f'<Private entityRef="van">{teleport(world(23.5, -4))}</Private>'
    text = document(crossing(NEAR), entities=entities, init=init, more=places)
    (test,) = with_catalog(CATALOG.format(PERSON.format(1) + van), text).suite.tests
    assert [(box.length, box.at) for box in test.parked] == [(2, pytest.approx((20, -4)))]
    assert test.people[0].beyond == pytest.approx(43.5 - 0.25 - 5 - 3.5), "0.5 m wide, and it looks across"


def test_a_number_that_no_test_can_have_is_refused_in_words(read):
    """A time to collision below 0."""
    arrival = (
        '<TimeToCollisionCondition freespace="true" rule="lessThan" value="-2" relativeDistanceType="longitudinal">'
        f"<TimeToCollisionConditionTarget>{world(43.5, 0)}</TimeToCollisionConditionTarget></TimeToCollisionCondition>"
    )
    with pytest.raises(CrashFileError, match=r"by-hand\.xosc: .*should be greater than or equal to 0, not -2"):
        read(document(crossing(by_car(arrival))))


def test_a_trajectory_that_begins_farther_along_is_refused(read):
    way = WAY.replace("<FollowTrajectoryAction>", '<FollowTrajectoryAction initialDistanceOffset="2">')
    with pytest.raises(CrashFileError, match="initialDistanceOffset isn't supported"):
        read(document(event([way, speed(2)])))


POINTS = [(43.5, -4 + n * 1e-4) for n in range(6000)]
ROUTE = (
    '<PrivateAction><RoutingAction><AssignRouteAction><Route name="r" closed="false">'
    + "".join(f'<Waypoint routeStrategy="shortest">{world(*point)}</Waypoint>' for point in POINTS)
    + "</Route></AssignRouteAction></RoutingAction></PrivateAction>"
)
SUMS = "".join(
    f'<ParameterDeclaration name="p{n}" value="${{$p{n + 1} + $p{n + 1}}}"/>' for n in range(40)
)  # 2 to the power of 40 sums, if each is done anew
DOUBLED = f'<ParameterDeclarations>{SUMS}<ParameterDeclaration name="p40" value="0"/></ParameterDeclarations>'
COSTLY = {
    "vertices": (document(event([follow(POINTS), speed(2)])), "Vertex: 6,000 in one way; at most 5,000 are read"),
    "waypoints": (document(event([ROUTE, speed(2)])), "Waypoint: 6,000 in one way; at most 5,000 are read"),
    "people": (
        document(entities=EGO + "".join(
            f'<ScenarioObject name="p{n}">{PERSON.format(1)}</ScenarioObject>' for n in [*range(200), "walker"])
            .replace("pwalker", "walker")),
        "Entities: 201 pedestrians are too many; a test has at most 100",
    ),
    "zigzag": (document(event([follow([(43.5, -4), (43.5, 6)] * 2000, range(4000), RELATIVE)])), "path: 4000 points"),
}  # fmt: skip


@pytest.mark.parametrize("case", COSTLY)
def test_a_file_that_only_costs_time_is_refused_soon(read, case):
    text, message = COSTLY[case]
    began = time.monotonic()
    with pytest.raises(CrashFileError) as error:
        read(text)
    assert message in str(error.value)
    assert time.monotonic() - began < 10


def test_parameters_that_use_each_other_are_read_soon(read):
    began = time.monotonic()
    assert read(document(crossing(by_value(TIME.format("$p0"))), more=DOUBLED)).suite.tests[0].people[0].time is None
    assert time.monotonic() - began < 10


GEOMETRY = ROAD[ROAD.index("<geometry") : ROAD.index("</planView>")].replace("200", "20000")
SECTION = ROAD[ROAD.index("<laneSection") : ROAD.index("</lanes>")]


@pytest.mark.parametrize(
    ("road", "message"),
    [
        (
            ROAD.replace("</planView>", GEOMETRY * 1000 + "</planView>"),
            "road 7: is 2.00002e+07 m long; at most 100,000 m",
        ),
        (
            ROAD.replace("</lanes>", SECTION * 3000 + "</lanes>"),
            "laneSection: 3,001 of one road; at most 2,000 are read",
        ),
    ],
    ids=["long", "in pieces"],
)
def test_a_road_that_only_costs_time_is_refused_soon(read, tmp_path, road, message):
    (tmp_path / "road.xodr").write_text(road)
    network = '<RoadNetwork><LogicFile filepath="road.xodr"/></RoadNetwork>'
    lane = '<Position><LanePosition roadId="7" laneId="-1" s="10" offset="0"/></Position>'
    began = time.monotonic()
    with pytest.raises(CrashFileError) as error:
        read(document(car=teleport(lane) + speed(10), more=network))
    assert message in str(error.value)
    assert time.monotonic() - began < 10
