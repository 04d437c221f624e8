"""Generated streets: accepted, sound, the same again, and as drawn by hand."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import fields, replace
from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from jaxwalk.maps.generated import ARTERIAL, LAYOUTS, PARKED, SPLITS, TOWN, UNSEEN, Refusal, Split, Town, make_street
from jaxwalk.maps.generated.check_town import TIGHTEST, refuse_faults
from jaxwalk.maps.generated.lane_paths import smallest_radius
from jaxwalk.maps.network import Lane, along
from jaxwalk.maps.network_file import network_text
from jaxwalk.sim.sim_config import SimConfig
from maps.street_invariants import check_street
from maps.town_families import FAMILIES, hull

SIMPLE = {
    "layouts": ("straight",), "main_length": (100.0, 100.0), "curvature": (0.0, 0.0), "lanes": (1,), "arm_lanes": (1,),
    "lane_width": (3.0, 3.0), "one_way": 0.0, "median": 0.0, "parking": 0.0, "sidewalk_width": (2.0, 2.0),
    "middle_crosswalks": (0.0, 0.0), "crosswalk_width": (4.0, 4.0), "zone_length": (15.0, 15.0), "unmarked": 0.0,
    "raised": 0.0, "building": 0.0, "speed_limits": (10.0,),
}  # fmt: skip
"""A street of two lanes of 3 m, 100 m long, with sidewalks of 2 m and one crosswalk of 4 m."""

RECORDED = ("skewed", 26, 32, 3, (162.5963, 137.245))
"""Layout, lanes, areas, crossings and size [m] of street 12 of `TOWN`."""


def of_random_numbers(count):
    """Make this many streets of random families and numbers; return how many were refused, by reason."""
    refused = Counter()

    @settings(
        max_examples=count, deadline=None, derandomize=True, database=None, phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(FAMILIES, st.integers(0, 2**63 - 1))
    def make(family, number):
        family = family if isinstance(family, Town) else Town(**family)
        try:
            street = make_street(family, number)
        except Refusal as refusal:
            refused[str(refusal)] += 1
        else:
            check_street(street.network)

    make()
    return refused


def test_12_streets_of_random_parameters_are_sound():
    assert sum(of_random_numbers(12).values()) <= 3


@pytest.mark.long
def test_1000_streets_of_random_parameters_are_sound():
    assert sum(of_random_numbers(1000).values()) <= 100


@pytest.mark.parametrize("split", SPLITS.values(), ids=SPLITS)
def test_first_streets_of_the_splits_are_sound(split):
    refused = Counter()
    streets = [street for street, _ in zip(split.streets(refused), range(4), strict=False)]
    assert sum(refused.values()) <= 1
    for street in streets:
        check_street(street.network)


def test_a_number_always_gives_the_same_street():
    one, other = (network_text(make_street(Town(), 12).network) for _ in range(2))
    assert one == other
    assert network_text(make_street(TOWN, 13).network) != one
    assert network_text(make_street(replace(TOWN, unmarked=0.21), 12).network) != one


def test_numbers_of_a_street_as_recorded():
    """Other machines make the same street: these numbers were seen on an x86-64 with NumPy 2.3."""
    street = make_street(TOWN, 12)
    found = (street.layout, len(street.network.lanes), len(street.network.areas), len(street.network.crossings))
    assert found == RECORDED[:4]
    np.testing.assert_allclose(street.network.size, RECORDED[4], atol=1e-3)


def test_a_straight_street_by_hand():
    network = make_street(Town(**SIMPLE), 1).network
    assert network.surface("roadway").area == pytest.approx(100 * 6, abs=0.1)
    assert network.surface("sidewalk").area == pytest.approx(2 * 100 * 2, abs=1)  # outlines are simplified by 5 mm
    assert network.surface("crosswalk").area == pytest.approx(4 * 6, abs=0.01)
    assert [along(lane.line)[-1] for lane in network.lanes] == pytest.approx([100, 100], abs=1e-3)
    one, other = (shapely.LineString(lane.line) for lane in network.lanes)
    assert one.distance(other) == pytest.approx(3, abs=1e-3)
    assert [(route.lanes, route.start) for route in network.routes] == [((0,), 8.0), ((1,), 8.0)]
    assert [route.goal for route in network.routes] == pytest.approx([92, 92], abs=1e-3)
    (crossing,) = network.crossings
    landings = network.walk.nodes[[crossing.nodes[0], crossing.nodes[-1]]]
    assert np.hypot(*(landings[0] - landings[1])) == pytest.approx(6 + 2, abs=1e-3)
    # Half the crosswalk and 1 m; then 15 m.
    assert (crossing.zone.begin, crossing.zone.end) == pytest.approx((3, 18), abs=1e-3)
    walked = network.walk.nodes[network.walk.edges]
    assert np.hypot(*(walked[:, 0] - walked[:, 1]).T).sum() == pytest.approx(2 * 98 + 8, abs=0.01)


def test_a_junction_by_hand():
    """An arm of 50 m at a right angle, from the middle of the main street, with two corners of 6 m."""
    family = Town(**SIMPLE | {"layouts": ("tee",), "angle": (90.0, 90.0), "arm_length": (50.0, 50.0),
                              "kerb_radius": (6.0, 6.0), "crosswalks": (1.0, 1.0)})  # fmt: skip
    network = make_street(family, 1).network
    corners = 2 * (1 - np.pi / 4) * 6**2
    assert network.surface("roadway").area == pytest.approx(100 * 6 + (50 - 3) * 6 + corners, abs=0.2)
    outer = 2 * (1 - np.pi / 4) * 4**2  # the outer edge of a sidewalk of 2 m, around a corner of 6 m
    with_sidewalks = 100 * 10 + (50 - 5) * 10 + outer
    both = network.surface("roadway").union(network.surface("sidewalk").buffer(0.001))
    assert both.area == pytest.approx(with_sidewalks, abs=0.5)
    assert (len(network.crossings), len(network.routes)) == (3, 6)
    right = min(smallest_radius(lane.line) for lane in network.lanes)
    assert right == pytest.approx(6 + 1.5, rel=0.05), "right turns are concentric with the kerb"


def test_splits_never_meet():
    for one, other in combinations(SPLITS.values(), 2):
        assert not range(max(one.numbers[0], other.numbers[0]), min(one.numbers[-1], other.numbers[-1]) + 1)
    families = {name: split.family for name, split in SPLITS.items()}
    assert families == dict.fromkeys(("training", "validation", "test"), TOWN) | {
        "unseen-ranges": UNSEEN,
        "arterial": ARTERIAL,
        **dict.fromkeys(("parked-training", "parked-test"), PARKED),
    }


def test_unseen_ranges_meet_none_of_training():
    for field in fields(Town):
        if field.type == "Range":
            (low, high), (other_low, other_high) = getattr(TOWN, field.name), getattr(UNSEEN, field.name)
            assert high < other_low or other_high < low, field.name
            assert hull(field.name) == (min(low, other_low), max(high, other_high))
    assert not set(TOWN.speed_limits) & set(UNSEEN.speed_limits)


def test_an_arterial_has_four_fast_lanes_and_crosswalks_far_apart():
    """Its lanes are 3.25 m wide or more; what an island takes from the roadway, its median adds."""
    for street, _ in zip(SPLITS["arterial"].streets(), range(15), strict=False):
        network = street.network
        lines = [shapely.LineString(lane.line) for lane in network.lanes]
        assert {lane.speed_limit for lane in network.lanes} == {13.9}
        ways = [shapely.LineString(network.walk.nodes[[x.nodes[0], x.nodes[-1]]]) for x in network.crossings]
        crossed = [sum(line.crosses(way) for line in lines) for way in ways]
        wide = [way for way, lanes in zip(ways, crossed, strict=True) if lanes == 4]
        assert set(crossed) <= {2, 4} and 1 <= len(wide) <= 5
        assert min(way.intersection(network.surface("roadway")).length for way in wide) >= 4 * 3.25
        assert all(one.centroid.distance(other.centroid) > 25 for one, other in combinations(wide, 2))


def test_refused_numbers_are_left_out_and_counted():
    refused = Counter()
    numbers = [street.number for street in Split("some", TOWN, range(70, 75)).streets(refused)]
    assert numbers == [70, 71, 73, 74]
    assert refused == {"roads meet beyond their junctions": 1}
    with pytest.raises(Refusal, match="roads meet beyond their junctions"):
        make_street(TOWN, 72)


def test_the_tightest_bend_is_the_bicycles():
    """The centre turns about a point beside the rear axle: its radius is L / (tan d cos b), tan b = tan d / 2."""
    rules = SimConfig()
    steering = np.tan(rules.max_steering)
    assert pytest.approx(rules.wheelbase / (steering * np.cos(np.arctan(steering / 2)))) == TIGHTEST


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_is_made(layout):
    street = make_street(replace(TOWN, layouts=(layout,)), 5)
    assert street.layout == layout
    edges = {"straight": 2, "tee": 3, "cross": 4, "skewed": 4, "staggered": 4, "block": 5}[layout]
    roadway = shapely.LineString(street.network.surface("roadway").exterior)
    cuts = shapely.line_merge(roadway.difference(street.network.surface("sidewalk").buffer(0.03)))
    assert sum(line.length > 1 for line in shapely.get_parts(cuts)) == edges


@pytest.fixture(scope="module")
def cross():
    return make_street(replace(TOWN, layouts=("cross",)), 3).network


def lane_changed(network, number, **values):
    lanes = list(network.lanes)
    lanes[number] = replace(lanes[number], **values)
    return replace(network, lanes=tuple(lanes))


def test_what_cannot_be_driven_is_refused(cross):
    refuse_faults(cross)
    entry = next(n for n, lane in enumerate(cross.lanes) if lane.successors)
    through = cross.lanes[entry].successors[0]
    hairpin = np.array([(0, 0), (3, 0), (3, 2), (0, 2)]) + cross.lanes[through].line[0]
    aside = cross.lanes[through].line + 60.0
    for changed, message in [
        (replace(cross, size=(201.0, 100.0)), "larger than 200 m"),
        (replace(cross, lanes=tuple(Lane(x.line, x.width, x.speed_limit) for x in cross.lanes)), "begins nowhere"),
        (lane_changed(cross, through, line=hairpin), "bends more tightly"),
        (lane_changed(cross, through, line=aside), "leaves the roadway"),
        (lane_changed(cross, entry, speed_limit=0.0), "lanes.speed_limit: # m/s"),
        (replace(cross, crossings=cross.crossings[:1]), "walk.edges (# to #): crosses a roadway"),
    ]:
        with pytest.raises(Refusal, match=re.escape(message)):
            refuse_faults(changed)


@pytest.mark.parametrize(
    "values, message",
    [
        ({"layouts": ()}, "layouts is empty"),
        ({"layouts": ("maze",)}, "there is no 'maze'; there are: straight"),
        ({"median": 1.5}, "median is a probability"),
        ({"lane_width": (3.5, 3.0)}, "lane_width must be (smallest, largest), not (3.5, 3.0)"),
        ({"lanes": (0,)}, "lanes must lie in [1, 3]"),
        ({"angle": (20.0, 90.0)}, "angle must lie in [30, 150] degrees"),
        ({"speed_limits": (14.0,)}, "speed_limits must be above 0 and at most 13.9 m/s"),
    ],
)
def test_a_family_that_makes_no_street_is_refused(values, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        Town(**values)


def test_buildings_whose_edges_nearly_coincide():
    """Seen: shapely could not unite the plots of this street."""
    check_street(make_street(UNSEEN, 3_000_000_738).network)


@pytest.mark.parametrize("number", [-1, 2**63])
def test_numbers_have_63_bits(number):
    with pytest.raises(ValueError, match=re.escape("must lie in [0, 2^63)")):
        make_street(TOWN, number)


def areas_changed(network, kind, change):
    return replace(
        network, areas=tuple(replace(x, outline=change(x.outline)) if x.kind == kind else x for x in network.areas)
    )


def walk_changed(network, change):
    return replace(network, walk=replace(network.walk, nodes=change(network.walk.nodes)))


def backwards(network):
    """The same lanes the other way round: left-hand traffic."""
    lanes = network.lanes
    before = [tuple(n for n, lane in enumerate(lanes) if here in lane.successors) for here in range(len(lanes))]
    turned = (replace(x, line=x.line[::-1], successors=after) for x, after in zip(lanes, before, strict=True))
    return replace(network, lanes=tuple(turned), routes=())


WRONG = {
    "off the map": lambda n: replace(n, size=(n.size[0] - 20, n.size[1])),
    "a gap at the kerb": lambda n: areas_changed(n, "sidewalk", lambda outline: outline + 0.2),
    "crosswalks moved along": lambda n: areas_changed(n, "crosswalk", lambda outline: outline + 4.0),
    "people moved aside": lambda n: walk_changed(n, lambda nodes: nodes + 2.5),
    "left-hand traffic": backwards,
    "a lane that ends": lambda n: lane_changed(
        n, next(k for k, x in enumerate(n.lanes) if x.successors), successors=()
    ),
    "too fast": lambda n: lane_changed(n, 0, speed_limit=14.0),
    "a zone over the crosswalk": lambda n: replace(
        n, crossings=tuple(x if x.zone is None else replace(x, zone=replace(x.zone, begin=0.0)) for x in n.crossings)
    ),
}


@pytest.mark.parametrize("change", WRONG.values(), ids=WRONG)
def test_invariants_notice_what_is_wrong(cross, change):
    check_street(cross)
    with pytest.raises(AssertionError):
        check_street(change(cross))
