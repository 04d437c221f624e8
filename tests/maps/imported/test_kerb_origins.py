"""Where the pavement along a line of people is from; closed lines have no end."""

import numpy as np
import pytest
import shapely

from jaxwalk.maps.imported.kerb_origins import KerbEvidence, known_lines, touching
from jaxwalk.maps.imported.source_map import WalkEvidence

RING = shapely.LineString([(0, 0), (60, 0), (60, 20), (0, 20), (0, 0)])
"""160 m around, from one corner on."""


def stretches(*gaps, walk=RING):
    """Those of a line along which the source has a sidewalk but for some gaps (from, to) [m]."""
    ends = [0.0, *(end for gap in gaps for end in gap), walk.length]
    parts = [shapely.ops.substring(walk, a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if b > a]
    evidence = [WalkEvidence(shapely.get_coordinates(part), "mapped", 0.1) for part in parts]
    return KerbEvidence(evidence).stretches([walk])


def test_pavement_goes_on_where_a_closed_line_begins():
    found = stretches((60, 80))
    assert [(x.origin, x.begin, x.end) for x in found] == [("mapped", 0, 60), ("invented", 60, 80), ("mapped", 80, 160)]
    (line,) = known_lines([RING], found)
    assert line.length == pytest.approx(140) and not line.is_ring
    assert {line.coords[0], line.coords[-1]} == {(60.0, 20.0), (60.0, 0.0)}
    assert list(touching(found, [RING])) == [(0, 1), (1, 2), (2, 0)]


def test_a_closed_line_stays_closed_if_all_of_it_is_known():
    assert [line.is_ring for line in known_lines([RING], stretches())] == [True]
    assert list(known_lines([RING], stretches((0, 160)))) == []


def test_an_open_line_has_two_ends():
    walk = shapely.LineString([(0, 0), (100, 0)])
    found = stretches((40, 60), walk=walk)
    assert [line.length for line in known_lines([walk], found)] == [40, 40]
    assert list(touching(found, [walk])) == [(0, 1), (1, 2)]


@pytest.mark.parametrize("gap, closed", [((6, 154), True), ((10, 150), False)])
def test_a_gap_may_lie_where_a_closed_line_begins(gap, closed):
    """Gaps of up to 15 m are closed: here 6 + 6 or 10 + 10 m."""
    found = stretches((0, gap[0]), (gap[1], 160))
    assert [x.joined for x in found] == [closed, False, closed]
    np.testing.assert_allclose([x.metres for x in found], [gap[0], gap[1] - gap[0], gap[0]])
