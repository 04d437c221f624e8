"""Where crossings are placed on a straight road by hand, why some aren't, and what the report says of them."""

import numpy as np
import pytest
import shapely

from jaxwalk.maps.imported.crossing_places import CrossingOutcome, CrossingPlaces, RoadLines
from jaxwalk.maps.imported.kerb_ground import KerbGround
from jaxwalk.maps.imported.kerb_origins import KerbEvidence
from jaxwalk.maps.imported.source_map import SourceCrossing, SourceMap, StreetFrame
from jaxwalk.maps.imported.street_parts import street_areas
from jaxwalk.maps.imported.street_summary import Built, summary

ROAD = shapely.box(-100, -4, 100, 4)
"""A roadway of 8 m; people walk 1.25 m beside it, so that a way straight over it is 10.5 m long."""
REGION = shapely.box(-90, -12, 90, 12)
LANE = np.array([(-90.0, 0.0), (90.0, 0.0)])


def places(road=ROAD, lanes=(LANE,), through=(), walks=None):
    """The crossings of the road, none yet."""
    ground = KerbGround.along(road).within(REGION)
    ground = ground if walks is None else ground._replace(walks=tuple(map(shapely.LineString, walks)))
    return CrossingPlaces(ground, REGION, RoadLines(lanes, through))


def crossing(x, y=0.0, *, name="new", across=None, width=4.0, **more):
    direction = None if across is None else np.array(across) / np.hypot(*across)
    return SourceCrossing(name, "zebra", np.array([x, y]), direction, width=width, **more)


GAP = shapely.union(shapely.box(-100, -2.5, -2.9, 2.5), shapely.box(2.9, -2.5, 100, 2.5))
TWO_ROADS = shapely.union(shapely.box(-100, -4, 100, -0.4), shapely.box(-100, 0.4, 100, 4))
NARROW = shapely.union(shapely.box(-100, -4, 100, -2.5), shapely.box(-100, 0, 100, 4))
AT_KERB = [[(-89, -4.05), (89, -4.05)], [(-89, 5.25), (89, 5.25)]]


@pytest.mark.parametrize(
    "about, point, reason",
    [
        ({"lanes": ()}, (0, 0), "no lane near it"),
        ({"lanes": (LANE + np.array((0, 15.5)),)}, (0, 0), "no lane near it"),
        ({}, (88, 0), "at the street's edge"),
        ({}, (0, 8), "it lies on no roadway of the street"),
        ({"road": GAP}, (0, 0), "it lies on no roadway of the street"),
        ({"road": TWO_ROADS}, (0, 0), "an island of less than 1 m"),
        ({"road": NARROW}, (0, 2), "it only grazes a roadway"),
        ({"walks": AT_KERB}, (0, 0), "no pavement at one of its kerbs"),
        ({"walks": AT_KERB[1:]}, (0, 0), "no pavement at one of its kerbs"),
    ],
)
def test_a_crossing_that_cannot_be_placed_has_a_reason(about, point, reason):
    outcome = places(**about).place(crossing(*point))
    assert (outcome.placed, outcome.reason, outcome.point) == (False, reason, point)


def test_the_direction_of_a_road_in_a_junction_is_that_of_the_ways_through_it():
    """Lanes outside junctions count first, if there are some within 15 m."""
    aside, ahead = np.array([(0.0, -9.0), (0.0, 9.0)]), LANE + np.array((0, 20))
    for lanes, expected in (((), (0, 1)), ((ahead,), (0, 1)), ((ahead - (0, 6),), (1, 0))):
        np.testing.assert_allclose(RoadLines(lanes, (aside,)).direction(np.array([0.0, 0.0])), expected, atol=1e-9)


@pytest.mark.parametrize("across, length", [((2, 10.5), np.hypot(2, 10.5)), ((10.5, 10.5), 10.5), (None, 10.5)])
def test_a_mapped_way_is_kept_unless_it_is_much_longer_than_the_shortest_one(across, length):
    """At 45 degrees it would be 1.41 times as long; 1.3 times is allowed."""
    made = places()
    assert made.place(crossing(0, across=across)).placed
    assert made.placed[0].chord.length == pytest.approx(length)


@pytest.mark.parametrize(
    "point, first, second",
    [(2.5, 2.0, 2.0), (4.1, 4.0, 2.0)],
    ids=["a landing in the same place", "crosswalks over each other"],
)
def test_a_crossing_in_the_way_of_another_one_is_moved_along_the_road(point, first, second):
    """The second way is oblique, 5 m along the road, and comes close to the first one at one kerb."""
    made = places()
    assert made.place(crossing(0, name="first", width=first)).moved == 0
    outcome = made.place(crossing(point, across=(5, 10.5), width=second))
    assert outcome.placed and outcome.moved == 1
    np.testing.assert_allclose(made.placed[1].chord.ends[:, 0], point + 1)


def test_no_crossing_is_invented_at_the_street_s_edge_or_over_another_one():
    """The pavement in the north has a gap at x = 0. A crossing leads to its western part, none to the eastern one.

    Crossings may be invented 3 m from where a lane ends: at x = 0.7, in the way of the mapped one; or at 1.2 m from the
    edge; or at 60 m, where there is room.
    """
    walks = [[(-89, -5.25), (89, -5.25)], [(-89, 5.25), (-0.5, 5.25)], [(0.5, 5.25), (89, 5.25)]]
    for ends, joined in (((-2.3, 3.71), False), ((85.7, 91.8), False), ((57, 63.01), True)):
        made = places(walks=walks)
        assert made.place(crossing(-2)).placed
        made.join([], [np.array([(x, 0.0) for x in ends])])
        assert [x.origin for x in made.placed] == ["mapped", "invented"][: 1 + joined]
        assert (len(set(made.parts())) == 1) == joined


def test_lines_of_people_of_another_road_are_none_of_a_region():
    both = KerbGround.along(shapely.union(ROAD, shapely.box(-100, 40, 100, 48)))
    assert len(both.walks) == 2
    within = both.within(REGION)
    assert sorted(walk.bounds for walk in within.walks) == [(-89, -5.25, 89, -5.25), (-89, 5.25, 89, 5.25)]


def source(*buildings):
    extent = (-90.0, -12.0, 90.0, 60.0)
    return SourceMap("", "", extent, (), np.zeros(0, bool), ROAD, (), (), (), (), buildings=tuple(buildings))


def test_only_buildings_near_the_roadway_and_in_the_street_are_in_it():
    """Within 30 m of the roadway, which ends at y = 4 m; less what isn't in the street, and what is pavement."""
    near, far, beyond = shapely.box(0, 5, 10, 15), shapely.box(0, 35, 10, 45), shapely.box(95, 8, 99, 12)
    box = shapely.box(-90, -12, 90, 60)
    areas, _ = street_areas(source(near, far, beyond), box, KerbGround.along(ROAD).within(box), [])
    (building,) = (area.shape() for area in areas if area.kind == "building")
    np.testing.assert_allclose(building.bounds, (0, 6.55, 10, 15), atol=0.002)  # 0.05 m off 2.5 m of pavement


def test_the_report_names_what_to_look_at():
    made = places()
    for x in (0, 2.5, 40):
        made.place(crossing(x, name=f"at {x}", across=(5, 10.5) if x == 2.5 else None, width=2.0, island=x == 40))
    lost = [CrossingOutcome(name, "zebra", False, "it is gone", at_edge=name == "edge") for name in ("edge", "inner")]
    walks = made.ground.walks
    built = Built(
        tuple(made.placed), tuple(made.placed), [0, 1], KerbEvidence([]).stretches(walks), tuple(lost),
        met=(True, False, True), lines=walks,
    )  # fmt: skip
    report = summary("road", StreetFrame((-90.0, -12.0, 90.0, 12.0)), built, "")
    assert [(repair.what, repair.metres, repair.at) for repair in report.repairs] == [
        ("at 2.5 moved along its road", 1.0, (93.5, 12.0))
    ]
    assert [x for x in report.advice if "look at it" in x] == ["inner: look at it, because it is gone"]
    assert report.left_out == (
        "at 40: the source has an island there, but no gap between the roadways",
        "at 2.5: no route of the car leads over it",
    )
