"""The bundled map is the world of the specification; what is expected here was computed by hand."""

import numpy as np
import pytest

from jaxwalk.maps import ROUTE_SPACING, bundled_maps, load_map
from sim.maps import rectangles


@pytest.fixture(scope="module")
def world():
    return load_map("paper")


def node_at(world, x, y):
    """The index of the node at a point."""
    (found,) = np.flatnonzero((world.node_x == x) & (world.node_y == y))
    return found


def route_between(world, start, goal):
    """The index of the route between two places of the file's list."""
    (found,) = np.flatnonzero((world.route_places == [start, goal]).all(axis=1))
    return found


def point_at(world, route, metres):
    """x, y and direction of travel at some metres along a route, from the sample before."""
    k = int(metres / ROUTE_SPACING)
    cos, sin = world.route_cos[route, k], world.route_sin[route, k]
    rest = metres - k * ROUTE_SPACING
    return np.array([world.route_x[route, k] + rest * cos, world.route_y[route, k] + rest * sin]), np.array([cos, sin])


def contains(rectangles, points, margin=0.0):
    """Which of (point, 2) lie in any rectangle, at least ``margin`` inside; a touched edge counts as inside."""
    low, high = rectangles[:, None, :2] + margin, rectangles[:, None, 2:] - margin
    return ((points >= low) & (points <= high)).all(axis=-1).any(axis=0)


def along_edges(world, step=0.1):
    """Points (point, 2) on every edge of the graph."""
    nodes = np.stack([world.node_x, world.node_y], axis=1).astype(float)
    for a, b in nodes[world.edges]:
        share = np.linspace(0, 1, int(np.linalg.norm(b - a) / step) + 1)[:, None]
        yield np.round(a + share * (b - a), 6)


def test_it_is_bundled_and_of_the_agreed_types(world):
    assert "paper" in bundled_maps()
    for name, value in vars(world).items():
        assert isinstance(value, np.ndarray), name
        assert value.dtype in (np.float32, np.int32, np.bool_), name
        assert np.isfinite(value).all() or name == "route_limit", name
    assert np.isinf(world.route_limit).all(), "map files have no speed limits"


def test_of_equally_long_ways_people_take_the_same_with_every_scipy(world):
    """SciPy chooses, and 1.15 chose others here; scenarios of one seed should stay the same."""
    assert world.next_hop[17, [0, 6, 12, 18, 24, 34]].tolist() == [11] * 6
    assert world.next_hop[[34, 35, 36, 37], [35, 34, 37, 36]].tolist() == [1, 3, 5, 7]
    assert world.next_hop[6, 17] == 10


def test_it_has_the_specified_counts(world):
    assert (world.width, world.height) == (120, 120)
    assert (len(rectangles("roads")), len(rectangles("sidewalks")), len(rectangles("crosswalks"))) == (3, 20, 6)
    assert (len(world.node_x), (~world.node_is_midpoint).sum()) == (40, 34)
    assert world.route_count == 90
    assert len({tuple(pair) for pair in world.route_places}) == 90


def test_its_crosswalks_lie_over_the_arms():
    expected = {
        (46, 52, 50, 60),
        (62, 52, 66, 60),
        (52, 46, 60, 50),
        (52, 62, 60, 66),
        (62, 82, 66, 90),
        (52, 92, 60, 96),
    }
    assert {tuple(area) for area in rectangles("crosswalks")} == expected


def test_its_sidewalks_line_every_kerb_once():
    grid = np.stack(np.meshgrid(np.arange(0.5, 120), np.arange(0.5, 120)), axis=-1).reshape(-1, 2)
    times = sum(contains(area[None], grid).astype(int) for area in rectangles("sidewalks"))
    on_road = contains(rectangles("roads"), grid)
    grown = rectangles("roads") + np.array([-2, -2, 2, 2])
    assert np.array_equal(times, contains(grown, grid) & ~on_road)


def test_its_edges_enter_a_roadway_only_on_crosswalks(world):
    for points in along_edges(world):
        assert (contains(rectangles("sidewalks"), points) | contains(rectangles("crosswalks"), points)).all()
        on_road = contains(rectangles("roads"), points, margin=1e-3)
        assert contains(rectangles("crosswalks"), points[on_road]).all()


@pytest.mark.parametrize(
    ("start", "goal", "metres"),
    [
        ((48, 51), (48, 61), 10),  # over a crosswalk
        ((1, 51), (1, 61), 47 + 10 + 47),
        ((51, 51), (61, 61), 3 + 10 + 3 + 3 + 10 + 3),
        ((61, 81), (61, 91), 3 + 10 + 3),  # around the mouth of the branch, not across it
        ((51, 94), (61, 81), 10 + 3 + 3 + 10 + 3),
        ((51, 64), (61, 81), 10 + 17),
        ((119, 91), (61, 119), 55 + 3 + 3 + 25),
        ((48, 56), (64, 56), 5 + 3 + 3 + 10 + 3 + 3 + 5),  # from midpoint to midpoint
    ],
)
def test_shortest_ways(world, start, goal, metres):
    a, b = node_at(world, *start), node_at(world, *goal)
    assert world.distance[a, b] == metres
    assert world.distance[b, a] == metres
    walked, here = 0.0, a
    while here != b:
        after = world.next_hop[here, b]
        assert sorted((here, after)) in world.edges.tolist()
        walked += np.hypot(world.node_x[after] - world.node_x[here], world.node_y[after] - world.node_y[here])
        here = after
    assert walked == metres


def test_at_the_goal_the_next_hop_is_the_goal(world):
    assert np.array_equal(np.diag(world.next_hop), np.arange(40))


def test_zones_lie_beside_their_crosswalk_within_one_edge(world):
    edges = {tuple(edge) for edge in world.edges}
    far = dict.fromkeys(range(12), 27.0) | {6: 15.0, 7: 15.0, 10: 24.0, 11: 24.0}
    assert world.zone_node.shape == (12, 2)
    for side, (landing, outer) in enumerate(world.zone_node):
        assert landing == world.side_landing[side]
        assert tuple(sorted((landing, outer))) in edges
        assert world.node_side[landing] == side
        assert (world.zone_near[side], world.zone_far[side]) == (3.0, far[side])
        assert world.zone_far[side] < world.zone_piece[side] == world.distance[landing, outer]
    ahead = [np.diff(at[world.zone_node])[:, 0] / world.zone_piece for at in (world.node_x, world.node_y)]
    assert all(np.array_equal(x[::2], x[1::2]) for x in ahead)  # both sides lead the same way
    assert (world.zone_kerb == 1).all()
    assert (world.node_side >= 0).sum() == 12


def test_landings_are_a_metre_from_the_roadway(world):
    assert (world.node_clear[world.side_landing] == 1).all()
    assert np.count_nonzero(world.node_clear) == 12


def test_the_two_landings_of_a_crosswalk_face_each_other(world):
    x, y = world.node_x[world.side_landing].reshape(6, 2), world.node_y[world.side_landing].reshape(6, 2)
    middle = np.stack([world.node_x, world.node_y], axis=1)[world.node_is_midpoint]
    assert np.array_equal(np.stack([x.mean(axis=1), y.mean(axis=1)], axis=1), middle)
    assert np.array_equal(np.hypot(np.diff(x), np.diff(y))[:, 0], np.full(6, 10))


def test_goals_are_the_waypoints_at_least_20_m_of_walking_away(world):
    for node in range(40):
        chosen = world.goal_choices[node, : world.goal_count[node]]
        expected = {other for other in range(34) if world.distance[node, other] >= 20}
        assert len(chosen) == len(expected) > 0
        assert set(chosen) == expected
    assert 34 - len(expected) > 0


def test_pedestrians_start_at_least_10_m_from_the_car(world):
    for route in range(90):
        chosen = world.start_choices[route, : world.start_count[route]]
        away = np.hypot(world.node_x - world.route_x[route, 0], world.node_y - world.route_y[route, 0])
        assert set(chosen) == set(np.flatnonzero((away >= 10) & ~world.node_is_midpoint))
        assert len(chosen) == len(set(chosen)) > 0


PLACES = np.array(
    [(10, 56), (30, 56), (90, 56), (110, 56), (56, 10), (56, 30), (56, 100), (56, 110), (80, 86), (100, 86)], float
)


def test_every_route_starts_and_ends_in_the_right_hand_lane_along_its_road(world):
    for route in range(90):
        start, goal = world.route_places[route]
        for metres, place in ((0.0, start), (float(world.route_length[route]), goal)):
            point, (cos, sin) = point_at(world, route, metres)
            assert point == pytest.approx(PLACES[place] + 2 * np.array([sin, -cos]), abs=1e-4)
            along_x = place not in (4, 5, 6, 7)
            assert abs(cos if along_x else sin) == 1


@pytest.mark.parametrize(
    ("start", "goal", "length", "first", "last"),
    [
        (0, 3, 100, (10, 54), (110, 54)),  # straight on, to the east
        (3, 0, 100, (110, 58), (10, 58)),
        (1, 5, 19 + 5 * np.pi / 2 + 19, (30, 54), (54, 30)),  # right at the four-way intersection
        (1, 6, 20 + 8 * np.pi / 2 + 38, (30, 54), (58, 100)),  # left there
        (9, 2, 38 + 4 * np.pi + 18 + 4 * np.pi + 28, (100, 88), (90, 54)),  # left twice
        (9, 6, 37 + 2.5 * np.pi + 7, (100, 88), (58, 100)),  # right at the T-junction
    ],
)
def test_routes_by_hand(world, start, goal, length, first, last):
    route = route_between(world, start, goal)
    assert world.route_length[route] == pytest.approx(length, abs=1e-4)
    assert (world.route_x[route, 0], world.route_y[route, 0]) == first
    assert point_at(world, route, length)[0] == pytest.approx(last, abs=1e-4)


def test_a_turn_by_hand(world):
    route = route_between(world, 1, 5)
    half = 19 + 5 * np.pi / 4  # in the middle of the arc about (49, 49)
    k = round(half / ROUTE_SPACING)
    angle = (k * ROUTE_SPACING - 19) / 5
    assert world.route_x[route, k] == pytest.approx(49 + 5 * np.sin(angle), abs=1e-4)
    assert world.route_y[route, k] == pytest.approx(49 + 5 * np.cos(angle), abs=1e-4)
    assert world.route_cos[route, k] == pytest.approx(np.cos(angle), abs=1e-6)
    assert world.route_sin[route, k] == pytest.approx(-np.sin(angle), abs=1e-6)


def test_routes_are_evenly_sampled_smooth_and_on_the_road(world):
    x, y = world.route_x.astype(float), world.route_y.astype(float)
    step = np.stack([np.diff(x), np.diff(y)])
    chord = np.hypot(*step)
    assert chord.max() < ROUTE_SPACING + 1e-4
    assert chord.min() > 2 * 5 * np.sin(ROUTE_SPACING / 10) - 1e-4  # the chord of the tightest arc
    heading = np.stack([world.route_cos, world.route_sin])
    assert np.hypot(*heading) == pytest.approx(1.0, abs=1e-6)
    turned = np.arccos(np.clip((heading[..., 1:] * heading[..., :-1]).sum(axis=0), -1, 1))
    assert turned.max() < ROUTE_SPACING / 4.37
    between = heading[..., 1:] + heading[..., :-1]
    assert (step / chord * between / np.hypot(*between)).sum(axis=0).min() > 0.9999
    for route in range(90):
        driven = np.arange(x.shape[1]) * ROUTE_SPACING <= world.route_length[route]
        assert contains(rectangles("roads"), np.stack([x[route], y[route]], axis=1)[driven]).all()


def test_routes_continue_straight_at_least_30_m_past_the_goal(world):
    end = (world.route_x.shape[1] - 1) * ROUTE_SPACING
    assert end - world.route_length.max() >= 30
    for route in range(90):
        beyond = np.arange(world.route_x.shape[1]) * ROUTE_SPACING >= world.route_length[route]
        assert np.unique(world.route_cos[route, beyond]).size == 1
        assert np.unique(world.route_sin[route, beyond]).size == 1


def test_loading_twice_gives_the_same_numbers(world):
    again = load_map("paper")
    assert all(np.array_equal(value, getattr(again, name)) for name, value in vars(world).items())
