"""Checks of a network's walk graph, crossings and jaywalk zones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import pairwise, product

import numpy as np
import shapely

from jaxwalk.maps.check_reach import reach_faults
from jaxwalk.maps.navigation import NEARLY, Graph
from jaxwalk.maps.network import Crossing, Network, WalkGraph
from jaxwalk.maps.network_scene import SLACK, NetworkScene
from jaxwalk.maps.network_zones import ZoneLines

UNEVEN = 1.5
"""The longest piece of a zone's kerb is at most this many times as long as the shortest."""
OFF_MIDDLE = 0.1
"""An island's node is as far from one roadway as from the other, within this [m]."""
TRIED = 9
"""A zone is tried at this many places, in each of three directions."""


def graph_of(walk: WalkGraph) -> Graph:
    """Return the walk graph as navigation takes it."""
    edges = np.sort(walk.edges, axis=1)
    return Graph([f"walk.nodes[{n}]" for n in range(len(walk.nodes))], walk.nodes, edges, walk.waypoints)


def walking_faults(network: Network, scene: NetworkScene, goal_spacing: float) -> list[str]:
    """Return the faults of the walk graph and the crossings."""
    faults = [*_edge_faults(network, scene), *_used_faults(network)]
    joined = {frozenset(edge) for edge in network.walk.edges.tolist()}
    for number, crossing in enumerate(network.crossings):
        field = f"crossings[{number}]"
        own = list(_chain_faults(field, crossing, network, scene, joined))
        if not own and crossing.zone is not None:
            own = list(_zone_faults(f"{field}.zone", crossing, network, scene, joined))
        faults += own
    return faults or _reach_faults(network, goal_spacing)


def _edge_faults(network: Network, scene: NetworkScene) -> Iterator[str]:
    """Yield the edges that leave the pavement, but for those of crossings."""
    walk = network.walk
    crossing = {frozenset(pair) for x in network.crossings for pair in pairwise(x.nodes)}
    times = Counter(frozenset(edge) for edge in walk.edges.tolist())
    for n, (a, b) in enumerate(walk.edges.tolist()):
        field, (x, y) = f"walk.edges[{n}] ({a} to {b})", walk.nodes[a]
        line = shapely.LineString(walk.nodes[[a, b]])
        if line.length < NEARLY:
            yield f"{field}: joins two nodes in one place, ({x:g}, {y:g}); remove one"
        elif times[frozenset((a, b))] > 1:
            yield f"{field}: joined {times[frozenset((a, b))]} times; once is enough"
        elif frozenset((a, b)) not in crossing and line.intersection(scene.roadway).length > 2 * SLACK:
            yield f"{field}: crosses a roadway from ({x:.1f}, {y:.1f}); make it part of a crossing, or remove it"
        elif frozenset((a, b)) not in crossing and not scene.pavement.covers(line):
            yield f"{field}: leaves the sidewalks from ({x:.1f}, {y:.1f}); add a sidewalk, or nodes round the bend"


def _used_faults(network: Network) -> Iterator[str]:
    """Yield crosswalks that no crossing leads over, and nodes that belong to several crossings."""
    used = {area for crossing in network.crossings for area in crossing.areas}
    for n, area in enumerate(network.areas):
        if area.kind == "crosswalk" and n not in used:
            x, y = area.outline[0]
            yield f"areas[{n}] (crosswalk at ({x:.1f}, {y:.1f})): no crossing leads over it; add one, or remove it"
    times = Counter(node for crossing in network.crossings for node in crossing.nodes)
    for node, count in times.items():
        if count > 1:
            yield f"walk.nodes[{node}]: {count} crossings use it; give each its own nodes"
    inner = {node: x for x in network.crossings for node in x.nodes[1:-1]}
    both_ways = [pair for a, b in network.walk.edges.tolist() for pair in ((a, b), (b, a))]
    for node, other in both_ways:
        if node in inner and other not in inner[node].nodes:
            yield f"walk.nodes[{node}]: between the landings of a crossing, but joined to {other}; remove that edge"


def _chain_faults(
    field: str, crossing: Crossing, network: Network, scene: NetworkScene, joined: set[frozenset[int]]
) -> Iterator[str]:
    """Yield the faults of a crossing's way."""
    walk, nodes = network.walk, crossing.nodes
    if wrong := [n for n in crossing.areas if network.areas[n].kind != "crosswalk"]:
        yield f"{field}.areas: areas[{wrong[0]}] is a {network.areas[wrong[0]].kind}; name areas of kind crosswalk"
        return
    if len(nodes) < 3 or not crossing.areas:
        yield f"{field}: needs an area and at least three nodes, from landing to landing"
        return
    if any(frozenset(pair) not in joined for pair in pairwise(nodes)):
        yield f"{field}.nodes: not joined one after the other; add the edges to walk.edges"
        return
    if any((node < walk.waypoints) != (n in (0, len(nodes) - 1)) for n, node in enumerate(nodes)):
        yield f"{field}.nodes: only its first and last node may be waypoints (numbers below {walk.waypoints})"
    ground = shapely.union_all([scene.pavement, *(network.areas[n].shape().buffer(SLACK) for n in crossing.areas)])
    line = shapely.LineString(walk.nodes[list(nodes)])
    if not ground.covers(line):
        yield f"{field}.nodes: the way leaves its crosswalk and the sidewalks; let both reach the kerb there"
    landings = shapely.points(walk.nodes[[nodes[0], nodes[-1]]])
    if shapely.intersects(scene.roadway, landings).any() or not shapely.covers(scene.pavement, landings).all():
        yield f"{field}.nodes: unreachable: its landings must lie on sidewalks, off the roadway"
    elif line.intersection(scene.roadway).length < SLACK:
        yield f"{field}.nodes: crosses no roadway"
    yield from _island_faults(field, crossing, network, scene)


def _island_faults(field: str, crossing: Crossing, network: Network, scene: NetworkScene) -> Iterator[str]:
    """Yield nodes between the landings of which it isn't clear whether they are on the roadway."""
    points = network.walk.nodes[list(crossing.nodes)]
    for n in range(1, len(points) - 1):
        node = shapely.Point(points[n])
        before, after = (shapely.LineString([points[n], points[m]]) for m in (n - 1, n + 1))
        away = [node.distance(line.intersection(scene.roadway)) for line in (before, after)]
        if any(metres != 0 for metres in away) and not scene.islands.covers(node):  # NaN: no roadway on that side
            yield f"{field}.nodes: node {crossing.nodes[n]} is neither on the roadway nor on an island; move it"
        elif abs(away[0] - away[1]) > OFF_MIDDLE:
            yield f"{field}.nodes: node {crossing.nodes[n]} isn't in the middle of its island; move it"


def _zone_faults(
    field: str, crossing: Crossing, network: Network, scene: NetworkScene, joined: set[frozenset[int]]
) -> Iterator[str]:
    """Yield the faults of a jaywalk zone."""
    zone = crossing.zone
    assert zone is not None
    one, other = zone.sides
    if len(one) != len(other) or len(one) < 2:
        yield f"{field}.sides: {len(one)} and {len(other)} nodes; both need equally many, two or more"
        return
    if (one[0], other[0]) != (crossing.nodes[0], crossing.nodes[-1]):
        yield f"{field}.sides: must begin at the landings {crossing.nodes[0]} and {crossing.nodes[-1]}"
    if any(frozenset(pair) not in joined for side in zone.sides for pair in pairwise(side)):
        yield f"{field}.sides: not joined one after the other; name the nodes along the kerb"
        return
    lines = ZoneLines.of(network, zone)
    shortest, longest = lines.pieces.min(), lines.pieces.max()
    if longest > UNEVEN * shortest:
        yield f"{field}.sides: pieces of {shortest:.2f} to {longest:.2f} m; make them equally long"
    if not 0 <= zone.begin < zone.end < lines.length:
        yield f"{field}: from {zone.begin:g} to {zone.end:g} m; must lie within the {lines.length:.2f} m of its sides"
        return
    chords = np.array(list(ways_across(lines, zone.begin, zone.end)))
    wrong = chord_faults(chords, scene)
    first = next((n for n, fault in enumerate(wrong) if fault), None)
    if first is not None:
        (x, y), _ = chords[first].coords
        yield f"{field}: a way across from ({x:.1f}, {y:.1f}) {wrong[first]}; shorten the zone"


def ways_across(lines: ZoneLines, begin: float, end: float) -> Iterator[shapely.LineString]:
    """Yield ways across: straight ones, and those with the largest slant, from either side."""
    for near, place, slant in product((0, 1), np.linspace(begin, end, TRIED), (-1, 0, 1)):
        start = lines.at(near, place)
        reach = slant * float(np.linalg.norm(lines.at(1 - near, place) - start))
        yield shapely.LineString([start, lines.at(1 - near, float(np.clip(place + reach, begin, end)))])


def chord_faults(chords: np.ndarray, scene: NetworkScene) -> list[str]:
    """Return for each way across what is wrong with it, or an empty text."""
    single = shapely.get_type_id(shapely.intersection(chords, scene.wide_roadway)) == shapely.GeometryType.LINESTRING
    outside = shapely.length(shapely.difference(chords, scene.ground)) > SLACK
    shapes = np.array([shape for _, shape in scene.crosswalks])
    met = shapely.length(shapely.intersection(chords[:, None], shapes)) > SLACK
    faults = []
    for n in range(len(chords)):
        numbers = [scene.crosswalks[k][0] for k in np.flatnonzero(met[n])]
        fault = f"meets the crosswalk areas[{numbers[0]}]" if numbers else ""
        fault = "leaves the roadway and the sidewalks" if outside[n] else fault
        faults.append(fault if single[n] else "meets an island, or no roadway")
    return faults


def _reach_faults(network: Network, goal_spacing: float) -> list[str]:
    """Check that every waypoint is connected to every other, and has a goal to walk to."""
    names = [f"walk.nodes[{n}] at ({x:.1f}, {y:.1f})" for n, (x, y) in enumerate(network.walk.nodes.tolist())]
    return reach_faults(graph_of(network.walk), names, goal_spacing, join="an edge")
