"""Walk graphs along lines."""

import numpy as np
import pytest
import shapely

from jaxwalk.maps.walk_lines import WalkLines

RING = shapely.LineString([(0, 0), (60, 0), (60, 20), (0, 20), (0, 0)])


def metres(lines):
    points = np.stack(lines.points)
    return sum(float(np.hypot(*(points[one] - points[other]))) for one, other in lines.edges)


@pytest.mark.parametrize("straight", [False, True])
def test_two_nodes_of_a_closed_line_are_joined_both_ways_around(straight):
    """One way is 20 m long and the other one 140 m; only the short one may be without nodes between."""
    lines = WalkLines([RING])
    one, other = (lines.add_on(0, np.array([x, 0.0]), waypoint=True) for x in (20.0, 40.0))
    lines.straight |= {frozenset((one, other))} if straight else set()
    lines.join(0)
    assert metres(lines) == pytest.approx(160)
    assert lines.edges.count((one, other)) == 1
    graph, _ = lines.renumbered()
    assert {(60, 0), (60, 20), (0, 20), (0, 0)} <= {tuple(point) for point in graph.nodes.tolist()}
