"""A street as OpenDRIVE 1.7: roads with lanes side by side, ways through junctions, and what stands or lies beside.

Lanes lie where the street has them, within a centimetre. Sidewalks are left out: people walk beside the lanes.
"""

from __future__ import annotations

from types import ModuleType

import numpy as np
import shapely

from jaxwalk.formats.lane_edges import LaneEdges
from jaxwalk.formats.plan_view import plan_view
from jaxwalk.formats.road_network import Connection, LaneGroup, RoadNetwork
from jaxwalk.formats.tracks import TracksError
from jaxwalk.maps.network import Area

FIRST_CONNECTION, FIRST_JUNCTION = 10_000, 20_000
"""First ids of connecting roads and of junctions; other roads have the ids 0, 1, ..."""
OBJECTS = {
    "crosswalk": "crosswalk", "island": "trafficIsland", "building": "building", "parking": "parkingSpace",
}  # fmt: skip
"""Areas that are written as objects, and their types there."""


def load_library() -> ModuleType:
    """Import ``scenariogeneration``, which is optional. Raises TracksError if it is missing."""
    try:
        import scenariogeneration
    except ImportError:
        raise TracksError(
            "scenarios need scenariogeneration; install it with: pip install 'jaxwalk[scenarios]'"
        ) from None
    return scenariogeneration


def opendrive(network: RoadNetwork, name: str) -> bytes:
    """Return the street as an OpenDRIVE document. Raises TracksError if scenariogeneration is missing."""
    library = load_library()
    xodr = library.xodr
    drive = xodr.OpenDrive(name, revMajor="1", revMinor="7")
    roads = [_road(xodr, network, number) for number in range(len(network.roads))]
    _add_objects(xodr, network, roads)
    junctions = [xodr.Junction(f"junction {n}", FIRST_JUNCTION + n) for n in range(network.junction.max() + 1)]
    for number, connection in enumerate(network.connections):
        road, link = _connection(xodr, FIRST_CONNECTION + number, connection, network)
        roads.append(road)
        junctions[connection.junction].add_connection(link)
    for road in roads:
        drive.add_road(road)
    for junction in junctions:
        drive.add_junction(junction)
    document = drive.get_element()
    width, height = network.network.size
    for side, value in (("west", 0.0), ("south", 0.0), ("east", width), ("north", height)):
        document.find("header").set(side, str(value))
    return library.helpers.prettify(document)


def line_of(network: RoadNetwork, road: LaneGroup) -> LaneEdges:
    """Return the edges of a road's first lane, of which the left one is the road's line."""
    return network.joints.edges(road.along[:1])


def _road(xodr: ModuleType, network: RoadNetwork, number: int):
    """Return a road with its lanes, and what follows and precedes it."""
    road = network.roads[number]
    line = line_of(network, road)
    plan = plan_view(xodr, line.left, line.headings)
    section = xodr.LaneSection(0, xodr.Lane(a=0))
    for lanes, add in ((road.along, section.add_right_lane), (road.against, section.add_left_lane)):
        for lane in lanes:
            add(_lane(xodr, network, road, lane))
    every = xodr.Lanes()
    every.add_lanesection(section)
    made = xodr.Road(number, plan, every)
    limit = max(network.network.lanes[lane].speed_limit for lane in road.along + road.against)
    made.add_type(xodr.RoadType.town, 0, speed=limit)
    for end, add in ((0, made.add_predecessor), (1, made.add_successor)):
        _add_link(xodr, network, road, end, add)
    return made


def _lane(xodr: ModuleType, network: RoadNetwork, road: LaneGroup, lane: int):
    """Return a lane of a road, with links to those that follow directly."""
    begin, end = network.joints.edges((lane,)).widths[:: 1 if lane in road.along else -1]
    made = xodr.Lane(a=begin, b=(end - begin) / network.network.lanes[lane].length())
    made.add_roadmark(xodr.RoadMark(xodr.RoadMarkType.solid, width=0.12))
    for end, name in ((0, "predecessor"), (1, "successor")):
        beyond = network.beyond(lane, end=road.end_of(lane) == end)
        if beyond is not None and beyond[0] < 0:
            made.add_link(name, network.roads[network.road_of(beyond[1])].number(beyond[1]))
    return made


def _add_link(xodr: ModuleType, network: RoadNetwork, road: LaneGroup, end: int, add) -> None:
    """Add what lies beyond one end of a road: a junction, a road, or nothing."""
    beyond = {lane: network.beyond(lane, end=road.end_of(lane) == end) for lane in road.along + road.against}
    found = {(x[0], -1 if x[0] >= 0 else network.road_of(x[1])) for x in beyond.values() if x is not None}
    if len(found) > 1:
        raise TracksError(f"lanes {sorted(beyond)} lead to different roads at one place: cut them at the same places")
    for junction, other in found:
        if junction >= 0:
            add(xodr.ElementType.junction, FIRST_JUNCTION + junction)
            continue
        lane, after = next((lane, x[1]) for lane, x in beyond.items() if x is not None)
        at_end = network.roads[other].end_of(after) == (road.end_of(lane) != end)
        add(xodr.ElementType.road, other, (xodr.ContactPoint.start, xodr.ContactPoint.end)[at_end])


def _connection(xodr: ModuleType, id: int, connection: Connection, network: RoadNetwork):
    """Return a way through a junction as a road with one lane, and its link in the junction."""
    edges = network.joints.edges(connection.lanes)
    begin, end = edges.widths
    ends = network.road_of(connection.incoming), network.road_of(connection.outgoing)
    roads = [network.roads[number] for number in ends]
    from_lane, to_lane = roads[0].number(connection.incoming), roads[1].number(connection.outgoing)
    plan = plan_view(xodr, edges.left, edges.headings)
    lane = xodr.Lane(a=begin, b=(end - begin) / plan.present_s)
    lane.add_link("predecessor", from_lane)
    lane.add_link("successor", to_lane)
    section = xodr.LaneSection(0, xodr.Lane(a=0))
    section.add_right_lane(lane)
    lanes = xodr.Lanes()
    lanes.add_lanesection(section)
    road = xodr.Road(id, plan, lanes, road_type=FIRST_JUNCTION + connection.junction)
    limit = min(network.network.lanes[lane].speed_limit for lane in connection.lanes)
    road.add_type(xodr.RoadType.town, 0, speed=limit)
    contact = xodr.ContactPoint.start, xodr.ContactPoint.end
    road.add_predecessor(xodr.ElementType.road, ends[0], contact[roads[0].end_of(connection.incoming)])
    road.add_successor(xodr.ElementType.road, ends[1], contact[1 - roads[1].end_of(connection.outgoing)])
    link = xodr.Connection(ends[0], id, xodr.ContactPoint.start)
    link.add_lanelink(from_lane, -1)
    return road, link


def _add_objects(xodr: ModuleType, network: RoadNetwork, roads: list) -> None:
    """Add areas as objects to the road that is next to each."""
    lines = np.array([shapely.LineString(line_of(network, road).left) for road in network.roads])
    for number, area in enumerate(network.network.areas):
        if area.kind in OBJECTS:
            nearest = int(np.argmin(shapely.distance(lines, area.shape().centroid)))
            made = _object(xodr, area, lines[nearest])
            roads[nearest].add_object(made)
            made.id = str(number)  # the library's own ids differ from one document to the next


def _object(xodr: ModuleType, area: Area, line: shapely.LineString):
    """Return an area as an object with an outline, in the frame of the nearest point of a road's line."""
    s = float(np.clip(line.project(area.shape().centroid), 1e-3, line.length - 1e-3))
    begin, here, end = (np.array(line.interpolate(at).coords[0]) for at in (s - 1e-3, s, s + 1e-3))
    ahead = (end - begin) / np.linalg.norm(end - begin)
    corners = (area.outline - here) @ np.array([ahead, (-ahead[1], ahead[0])]).T
    t = float(corners[:, 1].mean())
    length, width = np.ptp(corners, axis=0).tolist()
    made = xodr.Object(
        s, t, getattr(xodr.ObjectType, OBJECTS[area.kind]), subtype="", name=area.kind, height=0, length=length,
        width=width,
    )  # fmt: skip
    outline = xodr.Outline(closed=True, id=0)
    for u, v in corners.tolist():
        outline.add_corner(xodr.CornerLocal(u, v - t, 0, 0))
    made.add_outline(outline)
    return made
