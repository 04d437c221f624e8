"""What every street must fulfil, worked out from its data by other means than the checks in src."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import shapely

from jaxwalk.maps.network import along
from jaxwalk.maps.network_zones import ZoneLines

CLOSE = 0.03
"""Surfaces and ends that meet are at most this far apart [m]."""


def check_street(network):
    """Raise AssertionError if a street isn't as docs/maps.md and docs/streets.md say."""
    ground = {kind: network.surface(kind) for kind in ("roadway", "sidewalk", "crosswalk", "island", "building")}
    _check_size(network)
    _check_lanes(network, ground["roadway"])
    _check_sides(network)
    _check_surfaces(network, ground)
    _check_walks(network, ground)
    for crossing in network.crossings:
        _check_crossing(network, crossing, ground)
        if crossing.zone is not None:
            _check_zone(network, crossing, ground)


def points_of(line, spacing=0.25):
    """Points along a line (point, 2)."""
    line = shapely.LineString(line)
    places = np.linspace(0, line.length, int(line.length / spacing) + 2)
    return shapely.get_coordinates(shapely.line_interpolate_point(line, places))


def heading_at(lane, point):
    """A lane's unit vector where it is nearest to a point."""
    line = shapely.LineString(lane.line)
    at = np.clip(line.project(shapely.Point(point)), 0.05, line.length - 0.05)
    a, b = (shapely.get_coordinates(line.interpolate(x))[0] for x in (at - 0.05, at + 0.05))
    return (b - a) / np.linalg.norm(b - a)


def _check_size(network):
    points = np.concatenate([*(area.outline for area in network.areas), *(lane.line for lane in network.lanes)])
    assert (points >= 0).all() and (points <= network.size).all() and max(network.size) <= 200


def _check_lanes(network, roadway):
    """Every lane leads on or to the edge, begins where one ends or at the edge, and lies on a way from edge to edge."""
    lanes = network.lanes
    before = {n: [m for m, lane in enumerate(lanes) if n in lane.successors] for n in range(len(lanes))}
    for n, lane in enumerate(lanes):
        assert 0 < lane.speed_limit <= 13.9
        for after in lane.successors:
            np.testing.assert_allclose(lanes[after].line[0], lane.line[-1], atol=CLOSE)
        for end, others in ((0, before[n]), (-1, lane.successors)):
            assert others or roadway.exterior.distance(shapely.Point(lane.line[end])) < CLOSE
    onward = _reached({n: lane.successors for n, lane in enumerate(lanes)}, [n for n in before if not before[n]])
    backward = _reached(before, [n for n, lane in enumerate(lanes) if not lane.successors])
    assert onward == backward == set(before)
    for route in network.routes:
        assert all(b in lanes[a].successors for a, b in pairwise(route.lanes))


def _reached(joined, starts):
    found, rest = set(starts), list(starts)
    while rest:
        new = set(joined[rest.pop()]) - found
        found |= new
        rest += new
    return found


def _check_sides(network):
    """Right-hand traffic: lanes in the other direction, side by side at the street's edge, lie to the left."""
    followed = {after for lane in network.lanes for after in lane.successors}
    entries = [lane for n, lane in enumerate(network.lanes) if n not in followed]
    exits = [lane for lane in network.lanes if not lane.successors]
    for entry in entries:
        ahead = entry.line[1] - entry.line[0]
        for leaving in exits:
            aside = leaving.line[-1] - entry.line[0]
            if np.hypot(*aside) < 20 and abs(aside @ ahead) < 0.1 * np.hypot(*ahead):
                assert ahead[0] * aside[1] - ahead[1] * aside[0] > 0


def _check_surfaces(network, ground):
    roadway, sidewalk = ground["roadway"], ground["sidewalk"]
    assert roadway.geom_type == "Polygon"
    # Sidewalks line the whole kerb: only the cuts at the street's edges, straight lines, have none.
    kerb = shapely.LineString(roadway.exterior)
    bare = shapely.get_parts(shapely.line_merge(kerb.difference(sidewalk.buffer(CLOSE))))
    bare = [line for line in bare if line.length > 0.2]
    assert 2 <= len(bare) <= 5
    for line in bare:
        ends = shapely.get_coordinates(line)[[0, -1]]
        assert np.hypot(*np.diff(ends, axis=0)[0]) > line.length - 0.05, "only straight cuts"
    assert roadway.intersection(sidewalk).area < 0.1
    assert roadway.intersection(ground["island"]).area < 0.1
    assert ground["building"].intersection(roadway.union(sidewalk)).area < 0.1
    strips = [area.shape() for area in network.areas if area.kind == "parking"]
    for strip in strips:
        assert strip.difference(roadway.buffer(CLOSE)).area < 0.05
        assert not strip.intersects(ground["crosswalk"].buffer(3.5))
    for one, other in combinations(strips, 2):
        assert one.intersection(other).area < 0.01


def _check_walks(network, ground):
    """Everybody reaches everybody, by ways that are on a roadway on crosswalks only."""
    walk, joined = network.walk, {n: [] for n in range(len(network.walk.nodes))}
    for a, b in walk.edges.tolist():
        joined[a].append(b)
        joined[b].append(a)
    assert _reached(joined, [0]) == set(joined)
    inside = ground["roadway"].buffer(-CLOSE)
    shapely.prepare(inside)
    over = ground["crosswalk"].buffer(CLOSE)
    for a, b in walk.edges.tolist():
        points = points_of(walk.nodes[[a, b]])
        on_roadway = points[shapely.contains_xy(inside, points)]
        assert shapely.contains_xy(over, on_roadway).all(), "on a roadway, off a crosswalk"
        off = points[~shapely.contains_xy(ground["roadway"].buffer(CLOSE), points)]
        assert shapely.contains_xy(ground["sidewalk"].union(ground["island"]).buffer(CLOSE), off).all()


def _check_crossing(network, crossing, ground):
    """A crosswalk lies across its whole road, at a right angle to the lanes, and ends on sidewalks."""
    way = network.walk.nodes[list(crossing.nodes)]
    assert shapely.contains_xy(ground["sidewalk"], way[[0, -1]]).all()
    line = shapely.LineString(way)
    areas = shapely.union_all([network.areas[n].shape() for n in crossing.areas])
    assert line.intersection(ground["roadway"]).difference(areas.buffer(CLOSE)).length < 0.01
    across = (way[-1] - way[0]) / np.linalg.norm(way[-1] - way[0])
    crossed = [lane for lane in network.lanes if shapely.LineString(lane.line).intersects(line)]
    assert crossed
    for lane in crossed:
        here = shapely.get_coordinates(shapely.LineString(lane.line).intersection(line))[0]
        assert abs(heading_at(lane, here) @ across) < 0.05


def _check_zone(network, crossing, ground):
    """A zone is clear of crosswalks, islands and junctions: only lanes along its road lead through it."""
    zone = crossing.zone
    lines = ZoneLines.of(network, zone)
    places = np.linspace(zone.begin, zone.end, 15)
    sides = [np.array([lines.at(side, place) for place in places]) for side in (0, 1)]
    shape = shapely.Polygon(np.concatenate([sides[0], sides[1][::-1]]))
    assert shape.is_valid and zone.end - zone.begin > 3.5
    assert shape.intersection(ground["crosswalk"]).area < 0.01 and shape.intersection(ground["island"]).area < 0.01
    assert shapely.contains_xy(ground["sidewalk"], np.concatenate(sides)).all()
    widths = np.hypot(*(sides[0] - sides[1]).T)
    assert np.ptp(widths) < 0.1, "both kerbs run along the road"
    for lane in network.lanes:
        through = shapely.LineString(lane.line).intersection(shape.buffer(-0.2))
        if through.length > 0.5:
            here = shapely.get_coordinates(through)[0]
            nearest = np.hypot(*(sides[0] - here).T).argmin()
            across = sides[1][nearest] - sides[0][nearest]
            assert abs(heading_at(lane, here) @ across) / np.linalg.norm(across) < 0.2
    length = zone.end - zone.begin  # pieces of a bent zone count as equally long, which they are not quite
    assert abs(along(np.mean(sides, axis=0))[-1] - length) < 0.05 * length
