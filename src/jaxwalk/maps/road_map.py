"""A map for the simulator: arrays only, padded so that maps of different sizes can be stacked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Bool, Float, Int

if TYPE_CHECKING:
    Array = jax.Array
else:
    Array = jax.Array | np.ndarray  # maps are built with numpy; the simulator gets JAX arrays


class RoadMap(eqx.Module):
    """One map, or several stacked along a leading axis (``*map``). Positions in metres, x to the east, y to the north.

    Padding never changes a result: a padding node has no way to it, and the choice tables count only what is real.
    """

    width: Float[Array, "*map"]
    """Extent to the east [m]."""
    height: Float[Array, "*map"]
    """Extent to the north [m]."""
    field: Int[Array, "*map row column"]
    """How far it is to the roadway's edge (`jaxwalk.maps.road_field`); padding is far off the roadway."""
    half_width: Float[Array, "*map"]
    """Half the width of the narrowest road of a map file, or lane of a network [m]."""

    slots: Float[Array, "*map slot 6"]
    """The boxes of vehicles that may park (`jaxwalk.maps.parking_slots`): the first ``slot_count``. Padding is 0."""
    slot_count: Int[Array, "*map"]
    walls: Float[Array, "*map wall 6"]
    """Boxes, with the same columns, that hide what buildings hide (`jaxwalk.maps.walls`): the first ``wall_count``."""
    wall_count: Int[Array, "*map"]

    node_x: Float[Array, "*map node"]
    """x of the navigation graph's nodes [m]; padding is 0."""
    node_y: Float[Array, "*map node"]
    """y of the navigation graph's nodes [m]."""
    node_is_midpoint: Bool[Array, "*map node"]
    """Whether the node lies between the landings of a crossing: in the middle of a crosswalk, or on an island."""
    node_clear: Float[Array, "*map node"]
    """How far it is from the node along its crossing to the roadway [m]; 0 on the roadway and for other nodes."""
    edges: Int[Array, "*map edge 2"]
    """Node pairs joined by a straight walkway; padding is (-1, -1)."""
    next_hop: Int[Array, "*map node goal"]
    """First node on the shortest way from a node to a goal; the node itself at the goal."""
    distance: Float[Array, "*map node goal"]
    """Length of the shortest way [m]; inf where there is none."""

    side_landing: Int[Array, "*map side"]
    """The landing node of each side of each crosswalk; sides 2i and 2i + 1 belong to crosswalk i. Padding is -1."""
    zone_node: Int[Array, "*map side place"]
    """The nodes along the kerb beside each side's jaywalk zone, from its landing on. The last one is repeated, padding
    is -1."""
    zone_piece: Float[Array, "*map side"]
    """Distance between two of them, half-way between the two sides of a crossing [m]; of a straight zone, on this side.
    Padding is 1."""
    zone_kerb: Float[Array, "*map side piece"]
    """Distance from the line between two of them to the roadway [m]."""
    zone_near: Float[Array, "*map side"]
    """Where the jaywalk zone begins: distance from the landing, half-way between the two sides [m]."""
    zone_far: Float[Array, "*map side"]
    """Where the jaywalk zone ends [m]; below ``zone_near`` without a zone."""
    node_side: Int[Array, "*map node"]
    """The side that has this node as its landing, or -1."""

    goal_choices: Int[Array, "*map node choice"]
    """Waypoints far enough from a node to be its next goal: the first ``goal_count`` entries of the row."""
    goal_count: Int[Array, "*map node"]

    route_count: Int[Array, "*map"]
    """Number of routes of the car."""
    route_places: Int[Array, "*map route 2"]
    """Start and goal place of each route: indices into the map file's list of places; -1 for a network."""
    route_x: Float[Array, "*map route point"]
    """Points of the lane route, ``ROUTE_SPACING`` metres apart, from the start and straight on beyond the goal [m]."""
    route_y: Float[Array, "*map route point"]
    route_cos: Float[Array, "*map route point"]
    """Unit vector of travel at each point."""
    route_sin: Float[Array, "*map route point"]
    route_limit: Float[Array, "*map route point"]
    """Speed limit of the lane at each point [m/s]; inf on map files, which have none."""
    route_length: Float[Array, "*map route"]
    """Length from start to goal [m]."""
    start_choices: Int[Array, "*map route start"]
    """Waypoints where a pedestrian may start, not close to the car: the first ``start_count`` entries of the row."""
    start_count: Int[Array, "*map route"]
