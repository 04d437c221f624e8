"""Lanes that a source maps each by its line: where they are cut, joined, or lead nowhere."""

from itertools import pairwise

import numpy as np
import pytest
import shapely

from jaxwalk.maps.imported.lane_net import fits
from jaxwalk.maps.imported.mapped_lanes import MappedLane, MappedTurn, mapped_lane_net

NOT_MAPPED = np.zeros((0, 2))


def net(lines, turns):
    """The lanes along some lines, on ground that has room for all, with turns (from, to) whose ways aren't mapped."""
    lanes = [MappedLane(np.array(line, float), 3.5, 8.0) for line in lines]
    ground = shapely.union_all([shapely.LineString(line).buffer(20) for line in lines])
    return mapped_lane_net(lanes, [MappedTurn(a, b, NOT_MAPPED) for a, b in turns], ground, [])


@pytest.mark.parametrize(
    "degrees, lengths, no_turns",
    [(0, [120.0], 0), (90, [54 + 6 * np.pi / 2 + 54], 0), (170, [51.0, 51.0], 1)],
    ids=["straight on", "around a corner", "almost back"],
)
def test_lanes_are_cut_until_the_way_between_them_is_not_too_tight(degrees, lengths, no_turns):
    """Two lanes of 60 m, cut by 3 m first, then by 6 m, then by 9 m where they meet: the car turns within 4.7 m.

    A corner is an arc of 6 m. A turn that still has no room isn't made.
    """
    radians = np.radians(degrees)
    made = net([[(-60, 0), (0, 0)], [(0, 0), (60 * np.cos(radians), 60 * np.sin(radians))]], [(0, 1)])
    np.testing.assert_allclose([lane.length() for lane in made.lanes], lengths, atol=0.01)
    assert made.no_turns == no_turns and not any(lane.successors for lane in made.lanes)


@pytest.mark.parametrize("count, lanes", [(4, 1), (5, 2)])
def test_a_way_leads_over_at_most_four_short_lanes(count, lanes):
    """Two lanes of 60 m with lanes of 1 m between: joined they are one lane."""
    ends = [-60, *range(count + 1), count + 60]
    made = net([[(a, 0), (b, 0)] for a, b in pairwise(ends)], [(n, n + 1) for n in range(count + 1)])
    assert len(made.lanes) == lanes and made.no_turns == 0


@pytest.mark.parametrize("gap, may", [(0, True), (5.9, True), (6.1, False)])
def test_a_way_may_be_off_the_roadway_for_at_most_6_m(gap, may):
    roadway = shapely.box(0, -3, 40, 3).difference(shapely.box(20, -3, 20 + gap, 3))
    assert fits(np.array([(0.0, 0.0), (40.0, 0.0)]), (0.0, 0.0), roadway) == may
