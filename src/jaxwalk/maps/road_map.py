"""A map as the simulator sees it: arrays only, padded so that maps of different sizes can be stacked."""

from __future__ import annotations

import equinox as eqx
from jaxtyping import Array, Bool, Float, Int


class RoadMap(eqx.Module):
    """One map, or several stacked along a leading axis. Positions in metres, x to the east, y to the north.

    Padding never changes a result: a padding rectangle is empty (x0 > x1), a padding node has no way to it, and the
    choice tables count only what is real.
    """

    width: Float[Array, ""]
    """Extent to the east [m]."""
    height: Float[Array, ""]
    """Extent to the north [m]."""
    roads: Float[Array, "road 4"]
    """Road rectangles x0, y0, x1, y1 [m]; padding is (inf, inf, -inf, -inf)."""
    sidewalks: Float[Array, "sidewalk 4"]
    """Sidewalk rectangles, likewise."""
    crosswalks: Float[Array, "crosswalk 4"]
    """Crosswalk rectangles, likewise."""

    node_x: Float[Array, "node"]
    """Waypoints of the navigation graph [m]; padding is 0."""
    node_y: Float[Array, "node"]
    """Waypoints of the navigation graph [m]."""
    node_is_midpoint: Bool[Array, "node"]
    """Whether the node is the middle of a crosswalk (the others are on sidewalks)."""
    edges: Int[Array, "edge 2"]
    """Node pairs joined by a straight walkway; padding is (-1, -1)."""
    next_hop: Int[Array, "node goal"]
    """First node on the shortest way from a node to a goal (itself if there)."""
    distance: Float[Array, "node goal"]
    """Length of the shortest way [m]; inf where there is none."""

    side_landing: Int[Array, "side"]
    """The landing node of each side of each crosswalk; sides 2i and 2i + 1 belong to crosswalk i. Padding is -1."""
    side_outer: Int[Array, "side"]
    """The neighbour of the landing along the kerb, away from the junction: the zone lies between the two."""
    side_ux: Float[Array, "side"]
    """Unit vector along the kerb, from the landing toward ``side_outer``; the same for both sides of a crosswalk."""
    side_uy: Float[Array, "side"]
    zone_near: Float[Array, "side"]
    """The jaywalk zone reaches from this far from the landing, along the unit vector [m] ..."""
    zone_far: Float[Array, "side"]
    """... to this far [m]."""
    node_side: Int[Array, "node"]
    """The side whose landing a node is, else -1."""

    goal_choices: Int[Array, "node choice"]
    """Waypoints far enough from a node to be its next goal, the first ``goal_count`` of the row."""
    goal_count: Int[Array, "node"]

    route_count: Int[Array, ""]
    """How many routes the car can be given."""
    route_places: Int[Array, "route 2"]
    """Start and goal place of each route: indices into the map file's list of places."""
    route_x: Float[Array, "route point"]
    """Lane route every ``ROUTE_SPACING`` metres from the start, continued straight on beyond the goal [m]."""
    route_y: Float[Array, "route point"]
    route_cos: Float[Array, "route point"]
    """Direction of travel at each point."""
    route_sin: Float[Array, "route point"]
    route_length: Float[Array, "route"]
    """Metres from start to goal."""
    start_choices: Int[Array, "route choice"]
    """Waypoints where a pedestrian may start on a route: not close to the car; the first ``start_count``."""
    start_count: Int[Array, "route"]


ROUTE_SPACING = 0.5
"""Distance between the points of a route [m]."""
