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

    Padding never changes a result: a padding rectangle is empty (x0 > x1), a padding node has no way to it, and the
    choice tables count only what is real.
    """

    width: Float[Array, "*map"]
    """Extent to the east [m]."""
    height: Float[Array, "*map"]
    """Extent to the north [m]."""
    roads: Float[Array, "*map road 4"]
    """Road rectangles x0, y0, x1, y1 [m]; padding is (inf, inf, -inf, -inf)."""
    sidewalks: Float[Array, "*map sidewalk 4"]
    """Sidewalk rectangles, in the same form."""
    crosswalks: Float[Array, "*map crosswalk 4"]
    """Crosswalk rectangles, in the same form."""

    node_x: Float[Array, "*map node"]
    """x of the navigation graph's nodes [m]; padding is 0."""
    node_y: Float[Array, "*map node"]
    """y of the navigation graph's nodes [m]."""
    node_is_midpoint: Bool[Array, "*map node"]
    """Whether the node is the middle of a crosswalk (the others are on sidewalks)."""
    edges: Int[Array, "*map edge 2"]
    """Node pairs joined by a straight walkway; padding is (-1, -1)."""
    next_hop: Int[Array, "*map node goal"]
    """First node on the shortest way from a node to a goal; the node itself at the goal."""
    distance: Float[Array, "*map node goal"]
    """Length of the shortest way [m]; inf where there is none."""

    side_landing: Int[Array, "*map side"]
    """The landing node of each side of each crosswalk; sides 2i and 2i + 1 belong to crosswalk i. Padding is -1."""
    side_outer: Int[Array, "*map side"]
    """The neighbour of the landing along the kerb, away from the junction: the zone lies between the two."""
    side_ux: Float[Array, "*map side"]
    """Unit vector along the kerb, from the landing toward ``side_outer``; the same for both sides of a crosswalk."""
    side_uy: Float[Array, "*map side"]
    zone_near: Float[Array, "*map side"]
    """Where the jaywalk zone begins: distance from the landing along the unit vector [m]."""
    zone_far: Float[Array, "*map side"]
    """Where the jaywalk zone ends: distance from the landing along the unit vector [m]."""
    node_side: Int[Array, "*map node"]
    """The side that has this node as its landing, or -1."""

    goal_choices: Int[Array, "*map node choice"]
    """Waypoints far enough from a node to be its next goal: the first ``goal_count`` entries of the row."""
    goal_count: Int[Array, "*map node"]

    route_count: Int[Array, "*map"]
    """Number of routes of the car."""
    route_places: Int[Array, "*map route 2"]
    """Start and goal place of each route: indices into the map file's list of places."""
    route_x: Float[Array, "*map route point"]
    """Points of the lane route, ``ROUTE_SPACING`` metres apart, from the start and straight on beyond the goal [m]."""
    route_y: Float[Array, "*map route point"]
    route_cos: Float[Array, "*map route point"]
    """Unit vector of travel at each point."""
    route_sin: Float[Array, "*map route point"]
    route_length: Float[Array, "*map route"]
    """Length from start to goal [m]."""
    start_choices: Int[Array, "*map route start"]
    """Waypoints where a pedestrian may start, not close to the car: the first ``start_count`` entries of the row."""
    start_count: Int[Array, "*map route"]
