"""Generated streets at the limits of their shapes: numbers that give none, islands, bends, and the car's body."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from jaxwalk.maps.generated import TOWN, Refusal, Split, make_street
from jaxwalk.maps.generated.check_town import swept_on_road
from jaxwalk.maps.generated.lane_paths import arc_way
from jaxwalk.maps.network import Lane
from maps.networks import bend

SHORT = {"layouts": ("cross",), "main_length": (40.0, 41.0)}
"""The main street is hardly longer than its junction."""
WINDING = {"layouts": ("block",), "curvature": (0.012, 0.0166), "sidewalk_width": (5.0, 6.0)}
"""Roads bend towards each other, and have wide sidewalks."""


@pytest.mark.parametrize(
    "values, number, message",
    [
        (SHORT, 2, "the junctions are too large for the main street"),
        (SHORT, 3, "no room for the crosswalks that join all sidewalks"),
        (WINDING, 11, "sidewalks meet beyond their junctions"),
        (WINDING, 1, "roads meet at the street's edge"),
    ],
)
def test_a_number_whose_roads_do_not_fit_gives_no_street(values, number, message):
    family = replace(TOWN, **values)
    with pytest.raises(Refusal) as refusal:
        make_street(family, number)
    assert str(refusal.value) == message
    split, refused = Split("some", family, range(number, number + 1)), Counter()
    assert split.street(number) is None and split.street(number, refused) is None
    assert refused == {message: 1}, "counted only if that is asked for"


@pytest.mark.parametrize("crosswalk, length", [(2.0, 4.7), (4.0, 4.0 + 2 * 1.2)])
def test_an_island_is_1_2_m_longer_than_its_crosswalk_at_each_end_and_at_least_a_disc(crosswalk, length):
    """In a median of 5 m it is 4.7 m wide: 0.15 m narrower on each side."""
    family = replace(
        TOWN, layouts=("straight",), curvature=(0.0, 0.0), one_way=0.0, median=1.0, median_width=(5.0, 5.0), island=1.0,
        middle_crosswalks=(1.0, 1.0), crosswalk_width=(crosswalk, crosswalk),
    )  # fmt: skip
    network = make_street(family, 1).network
    (island, *_) = (area.shape() for area in network.areas if area.kind == "island")
    lane = network.lanes[0].line
    ahead = (lane[-1] - lane[0]) / np.hypot(*(lane[-1] - lane[0]))
    corners = np.array(island.exterior.coords)
    assert np.ptp(corners @ ahead) == pytest.approx(length, abs=0.01)
    assert np.ptp(corners @ (-ahead[1], ahead[0])) == pytest.approx(4.7, abs=0.01)


@pytest.mark.parametrize("end, is_arc", [((10.0, 10.0), True), ((10.0, -10.0), False), ((-10.0, 10.0), False)])
def test_an_arc_leads_from_one_line_to_another_only_if_they_meet_between(end, is_arc):
    """From (0, 0) to the east, then to the north: both lines meet at (10, 0), ahead of the begin and before the end."""
    arc = arc_way((np.zeros(2), np.array(end)), 0.0, np.pi / 2, 10.0)
    assert (arc is not None) == is_arc
    if arc is not None:
        np.testing.assert_allclose(np.hypot(*(arc - (0, 10)).T), 10.0, atol=1e-9)


@pytest.mark.parametrize("metres, swept", [(3.0, True), (10.0, False)])
def test_the_car_is_never_wholly_on_a_lane_that_is_shorter_than_it(metres, swept):
    """A lane from edge to edge beside the road: a car's body fits on 10 m of it, not on 3 m."""
    network = bend()
    beside = Lane(np.array([(1.0, 40.0), (1.0, 40.0 + metres)]), 3.0, 8.0)
    assert swept_on_road(network) and swept_on_road(replace(network, lanes=(*network.lanes, beside))) == swept
