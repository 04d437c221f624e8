"""The track of crash tests: a straight street of two lanes with a place to park beside it, and a junction to turn at.

The car of most tests drives to the east. The turns are those that the car-to-pedestrian turning tests of Euro NCAP
prescribe for each speed: a clothoid, an arc and a clothoid, on lanes 3.5 m wide with kerbs of 8 m radius.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from jaxwalk.maps.network import Area, Crossing, Lane, LaneRoute, Network, WalkGraph, corners

TEST_TRACK = "test-track"
"""Its name as a map."""
SIZE = (260.0, 140.0)
"""Extent to the east and to the north [m]."""
STREET_Y, ROAD_X = 70.0, 200.0
"""Where the lines between the two lanes lie: of the street, and of the road that crosses it [m]."""
LANE, STRIP = 3.5, 2.0
"""Width of a lane, and of the strip beside the eastbound one, where vehicles park [m]."""
PAVEMENT, KERB_RADIUS = 3.0, 8.0
"""Width of the sidewalks, and radius of the kerbs at the junction [m]."""
START, GOAL = 5.0, 160.0
"""All routes begin, and the one straight on ends, this far from the street's western end [m]."""
SHORT_OF_END = 30.0
"""A turn's route ends this far short of the end of its lane [m]."""
CROSSWALKS = (10.0, 250.0, 130.0)
"""The middles of the crosswalks over the western, the eastern and the northern arm [m], and half their width."""
HALF_CROSSWALK = 2.0
SPACING = 0.25
"""Distance between the points of a turn [m]."""
LIMIT = 40.0
"""Speed limit [m/s]: so high that tests set the speed."""


class ClothoidTurn(NamedTuple):
    """A turn by 90 degrees: curvature rises evenly to an arc, and falls as it rose."""

    radius: float
    """Radius of the arc [m]."""
    clothoid: float
    """Angle of each clothoid [degrees]; the arc has the rest of 90 degrees."""
    side: int
    """1 for a left turn, -1 for a right one."""

    def line(self) -> np.ndarray:
        """Return its points (point, 2) [m], from (0, 0), to the east at first."""
        clothoid, arc = np.radians(self.clothoid), np.radians(90 - 2 * self.clothoid)
        lengths = np.array([2 * clothoid, arc, 2 * clothoid]) * self.radius
        ends = np.concatenate([[0.0], lengths.cumsum()])
        steps = int(np.ceil(ends[-1] / SPACING))
        fine = np.linspace(0, ends[-1], 40 * steps + 1)
        curvature = self.side * np.interp(fine, ends, [0, 1 / self.radius, 1 / self.radius, 0])
        heading = np.concatenate([[0.0], ((curvature[1:] + curvature[:-1]) / 2 * np.diff(fine)).cumsum()])
        between = (heading[1:] + heading[:-1]) / 2
        moves = np.stack([np.cos(between), np.sin(between)], axis=1) * np.diff(fine)[:, None]
        return np.concatenate([np.zeros((1, 2)), moves.cumsum(axis=0)])[::40]


TURNS = {
    "left-10": ClothoidTurn(9.0, 20.62, 1),
    "left-15": ClothoidTurn(11.75, 20.93, 1),
    "left-20": ClothoidTurn(14.75, 21.79, 1),
    "right-10": ClothoidTurn(8.0, 22.85, -1),
}
"""The turns of the track's routes, by side and speed [km/h]."""
ROUTES = ("straight", *TURNS)
"""The names of its routes, in their order."""


def track_network() -> Network:
    """Return the track."""
    roadway = _roadway()
    whole = shapely.box(0, 0, *SIZE)
    pavement = roadway.buffer(PAVEMENT).difference(roadway).intersection(whole)
    crosswalks = [Area("crosswalk", corners(box)) for box in _crosswalks()]
    areas = (
        Area("roadway", _outline(roadway.intersection(whole))),
        *(Area("sidewalk", _outline(part)) for part in shapely.get_parts(pavement)),
        *crosswalks,
    )
    lanes, routes = _lanes()
    walk, ways = _walking()
    first = len(areas) - len(crosswalks)
    crossings = tuple(Crossing("zebra", (first + number,), way) for number, way in enumerate(ways))
    return Network(size=SIZE, lanes=lanes, areas=areas, walk=walk, crossings=crossings, routes=routes)


def _roadway() -> shapely.Polygon:
    """Return the roadway, also beyond the map."""
    width, height = SIZE
    street = shapely.box(-width, STREET_Y - LANE - STRIP, 2 * width, STREET_Y + LANE)
    road = shapely.box(ROAD_X - LANE, -height, ROAD_X + LANE, 2 * height)
    rounded = street.union(road).buffer(KERB_RADIUS, join_style="mitre").buffer(-KERB_RADIUS, quad_segs=32)
    assert isinstance(rounded, shapely.Polygon)
    return rounded


def _outline(shape: shapely.geometry.base.BaseGeometry) -> np.ndarray:
    return np.round(shapely.get_coordinates(shape)[:-1], 4)


def _crosswalks() -> tuple[tuple[float, float, float, float], ...]:
    """Return the boxes of the crosswalks, x0, y0, x1, y1 [m]."""
    (west, east, north), half = CROSSWALKS, HALF_CROSSWALK
    south_kerb, north_kerb = STREET_Y - LANE - STRIP, STREET_Y + LANE
    return (
        (west - half, south_kerb, west + half, north_kerb),
        (east - half, south_kerb, east + half, north_kerb),
        (ROAD_X - LANE, north - half, ROAD_X + LANE, north + half),
    )


class _Road(NamedTuple):
    """A straight lane in pieces, between the places where turns leave or join it."""

    first: int
    """The number of its first piece."""
    points: list[tuple[float, float]]
    """Where pieces begin and end [m]."""

    def pieces(self, begin: int = 0, end: int | None = None) -> tuple[int, ...]:
        """Return the numbers of its pieces, from one point (by its place in ``points``) to another."""
        return tuple(range(self.first, self.first + len(self.points) - 1))[begin:end]


def _lanes() -> tuple[tuple[Lane, ...], tuple[LaneRoute, ...]]:
    """Return the lanes, pieces of straight lanes first and then the turns, and the routes."""
    lines = {name: _placed(turn) for name, turn in TURNS.items()}
    roads, count = {}, 0
    for name, points in _cuts(lines).items():
        roads[name] = _Road(count, points)
        count += len(points) - 1
    east = roads["east"]
    leaves = {name: east.points.index(tuple(line[0])) for name, line in lines.items()}
    lanes, routes = [], [LaneRoute(lanes=(0,), start=START, goal=GOAL)]
    for road in roads.values():
        for place, piece in enumerate(pairwise(road.points), 1):
            turns = [count + n for n, at in enumerate(leaves.values()) if road is east and at == place]
            lanes.append(_lane(np.array(piece), (*road.pieces(place)[:1], *turns)))
    for number, (name, line) in enumerate(lines.items(), count):
        road = roads["north" if TURNS[name].side > 0 else "south"]
        onward = road.pieces(road.points.index(tuple(line[-1])))
        lanes.append(_lane(line, onward[:1]))
        goal = lanes[onward[-1]].length() - SHORT_OF_END
        routes.append(LaneRoute(lanes=(*east.pieces(0, leaves[name]), number, *onward), start=START, goal=goal))
    return tuple(lanes), tuple(routes)


def _cuts(lines: dict[str, np.ndarray]) -> dict[str, list[tuple[float, float]]]:
    """Return where the pieces of each straight lane begin and end [m]; ``lines`` are the turns'."""
    (width, height), half = SIZE, LANE / 2
    forks = sorted(tuple(line[0]) for line in lines.values())
    lefts = sorted(tuple(line[-1]) for name, line in lines.items() if TURNS[name].side > 0)
    rights = sorted((tuple(line[-1]) for name, line in lines.items() if TURNS[name].side < 0), reverse=True)
    return {
        "east": [(0.0, STREET_Y - half), *forks, (width, STREET_Y - half)],
        "north": [(ROAD_X + half, 0.0), *lefts, (ROAD_X + half, height)],
        "south": [(ROAD_X - half, height), *rights, (ROAD_X - half, 0.0)],
        "west": [(width, STREET_Y + half), (0.0, STREET_Y + half)],
    }


def _placed(turn: ClothoidTurn) -> np.ndarray:
    """Return the points of a turn (point, 2) [m] where it leads from the eastbound lane to its lane of the road."""
    line, half = turn.line(), LANE / 2
    placed = line + np.array([ROAD_X + turn.side * half - line[-1, 0], STREET_Y - half])
    placed[-1, 0] = ROAD_X + turn.side * half
    return np.round(placed, 6)


def _lane(line: np.ndarray, successors: tuple[int, ...]) -> Lane:
    return Lane(line=line, width=LANE, speed_limit=LIMIT, successors=successors)


def _walking() -> tuple[WalkGraph, list[tuple[int, ...]]]:
    """Return where people walk, and the nodes of the three crossings.

    A chain of nodes leads along the sidewalk of each of the four blocks: three along the street, those round the
    corner, and two along the road. All but those round the corner are waypoints.
    """
    blocks = ((-1, 1), (-1, -1), (1, 1), (1, -1))
    chains = [_chain(*block) for block in blocks]
    bent = len(chains[0]) - 5
    waypoints = [point for chain in chains for point in (*chain[:3], *chain[-2:])]
    others = [point for chain in chains for point in chain[3:-2]]
    edges = []
    for number in range(len(blocks)):
        straight = [5 * number + n for n in range(5)]
        bend = [len(waypoints) + bent * number + n for n in range(bent)]
        edges += pairwise([*straight[:3], *bend, *straight[3:]])
    on_street, on_road = ({block: 5 * n + at for n, block in enumerate(blocks)} for at in (1, 3))
    middles = [((x0 + x1) / 2, (y0 + y1) / 2) for x0, y0, x1, y1 in _crosswalks()]
    ends = [(table[one], table[other]) for table, one, other in (
        (on_street, (-1, -1), (-1, 1)), (on_street, (1, -1), (1, 1)), (on_road, (-1, 1), (1, 1)))]  # fmt: skip
    ways = [(one, len(waypoints) + len(others) + n, other) for n, (one, other) in enumerate(ends)]
    edges += [pair for way in ways for pair in pairwise(way)]
    nodes = np.round(np.array([*waypoints, *others, *middles]), 4)
    return WalkGraph(nodes=nodes, edges=np.array(edges), waypoints=len(waypoints)), ways


def _chain(right: int, up: int) -> list[tuple[float, float]]:
    """Return the nodes of a block, from the end of the street to the end of the road; `_corner` says which block."""
    (width, height), (west, east, north) = SIZE, CROSSWALKS
    arc = _corner(right, up)
    (first_x, y), (x, last_y) = arc[0], arc[-1]
    outer_x, crossing_x = (1.0, west) if right < 0 else (width - 1, east)
    outer_y = height - 1 if up > 0 else 1.0
    inner_y = north if up > 0 else (last_y + outer_y) / 2
    return [(outer_x, y), (crossing_x, y), ((first_x + crossing_x) / 2, y), *arc, (x, inner_y), (x, outer_y)]


def _corner(right: int, up: int) -> list[tuple[float, float]]:
    """Return the nodes round a corner of the junction, from the street to the road.

    ``right`` is 1 east of the road, -1 west of it; ``up`` is 1 north of the street, -1 south of it.
    """
    kerb_y = STREET_Y + LANE if up > 0 else STREET_Y - LANE - STRIP
    x, y = ROAD_X + right * (LANE + KERB_RADIUS), kerb_y + up * KERB_RADIUS
    radius = KERB_RADIUS - PAVEMENT / 2
    turned = np.radians(np.linspace(0, 90, 7))
    return [(x - right * radius * np.sin(a), y - up * radius * np.cos(a)) for a in turned.tolist()]
