"""A map as OpenDRIVE 1.7: straight arms, junctions with their connecting roads, and crosswalks as objects.

Positions are exactly those of the map. Sidewalks are left out: people walk beside the lanes.
"""

from __future__ import annotations

import math
from types import ModuleType

from jaxwalk.formats.road_network import Arm, Connection, Rectangle, RoadNetwork
from jaxwalk.formats.tracks import TracksError

FIRST_CONNECTION, FIRST_JUNCTION = 1000, 2000
"""First ids of connecting roads and of junctions; arms have the ids 0, 1, ..."""


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
    """Return the map as an OpenDRIVE document. Raises TracksError if scenariogeneration is missing."""
    library = load_library()
    xodr = library.xodr
    drive = xodr.OpenDrive(name, revMajor="1", revMinor="7")
    for number, arm in enumerate(network.arms):
        drive.add_road(_arm(xodr, number, arm, network.crosswalks))
    junctions = [
        xodr.Junction(f"junction {number}", FIRST_JUNCTION + number) for number in range(len(network.junctions))
    ]
    for number, connection in enumerate(network.connections):
        road, link = _connection(xodr, number, connection, network)
        drive.add_road(road)
        junctions[connection.junction].add_connection(link)
    for junction in junctions:
        drive.add_junction(junction)
    document = drive.get_element()
    for side, value in zip(("west", "south", "east", "north"), network.bounds(), strict=True):
        document.find("header").set(side, str(value))
    return library.helpers.prettify(document)


def _road(xodr: ModuleType, number: int, start: tuple[float, float, float], line, lanes, junction: int = -1):
    """Return a road with a line that begins at a point and heading."""
    plan = xodr.PlanView(*start)
    plan.add_geometry(line)
    plan.adjust_geometries()
    return xodr.Road(number, plan, lanes, road_type=junction)


def _arm(xodr: ModuleType, number: int, arm: Arm, crosswalks: tuple[Rectangle, ...]):
    """Return an arm as a road: lane -1 leads along the arm, lane 1 in the opposite direction."""
    section = xodr.LaneSection(0, xodr.standard_lane())
    edge = xodr.RoadMark(xodr.RoadMarkType.solid, width=0.12)
    for add in (section.add_right_lane, section.add_left_lane):
        lane = xodr.Lane(a=arm.width / 2)
        lane.add_roadmark(edge)
        add(lane)
    lanes = xodr.Lanes()
    lanes.add_lanesection(section)
    road = _road(xodr, number, (arm.x, arm.y, arm.heading), xodr.Line(arm.length), lanes)
    before, after = arm.ends
    if before is not None:
        road.add_predecessor(xodr.ElementType.junction, FIRST_JUNCTION + before)
    if after is not None:
        road.add_successor(xodr.ElementType.junction, FIRST_JUNCTION + after)
    for id, area in enumerate(crosswalks):
        place = _on_arm(arm, area)
        if place is not None:
            road.add_object(_crosswalk(xodr, str(id), *place))
    return road


def _on_arm(arm: Arm, area: Rectangle) -> tuple[float, float, float, float] | None:
    """Return a rectangle in an arm's frame, or None off the arm: s and t of its middle, length and width [m]."""
    dx, dy = (area[0] + area[2]) / 2 - arm.x, (area[1] + area[3]) / 2 - arm.y
    wide, high = area[2] - area[0], area[3] - area[1]
    if arm.heading:
        dx, dy, wide, high = dy, -dx, high, wide
    return (dx, dy, wide, high) if 0 <= dx <= arm.length and abs(dy) < arm.width / 2 else None


def _crosswalk(xodr: ModuleType, id: str, s: float, t: float, length: float, width: float):
    """Return a crosswalk as an object with an outline."""
    size = {"length": length, "width": width, "height": 0}
    made = xodr.Object(s, t, xodr.ObjectType.crosswalk, subtype="", id=id, name="crosswalk", **size)
    outline = xodr.Outline(closed=True, id=0)
    for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        outline.add_corner(xodr.CornerLocal(u * length / 2, v * width / 2, 0, 0))
    made.add_outline(outline)
    return made


def _connection(xodr: ModuleType, number: int, connection: Connection, network: RoadNetwork):
    """Return a connecting road with one lane, and its link in the junction."""
    id = FIRST_CONNECTION + number
    begin, end = connection.widths
    lane = xodr.Lane(a=begin, b=(end - begin) / connection.length)
    from_lane = -1 if network.arms[connection.incoming].ends[1] == connection.junction else 1
    to_lane = -1 if network.arms[connection.outgoing].ends[0] == connection.junction else 1
    lane.add_link("predecessor", from_lane)
    lane.add_link("successor", to_lane)
    section = xodr.LaneSection(0, xodr.Lane(a=0))
    section.add_right_lane(lane)
    lanes = xodr.Lanes()
    lanes.add_lanesection(section)
    bent = abs(connection.curvature) > 0
    line = xodr.Arc(connection.curvature, length=connection.length) if bent else xodr.Line(connection.length)
    start = connection.x, connection.y, math.remainder(connection.heading, 2 * math.pi)
    road = _road(xodr, id, start, line, lanes, junction=FIRST_JUNCTION + connection.junction)
    ends = xodr.ContactPoint.start, xodr.ContactPoint.end
    road.add_predecessor(xodr.ElementType.road, connection.incoming, ends[from_lane == -1])
    road.add_successor(xodr.ElementType.road, connection.outgoing, ends[to_lane == 1])
    link = xodr.Connection(connection.incoming, id, xodr.ContactPoint.start)
    link.add_lanelink(from_lane, -1)
    return road, link
