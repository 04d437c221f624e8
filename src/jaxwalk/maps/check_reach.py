"""Check that people can walk from everywhere to everywhere, and have goals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from jaxwalk.maps.navigation import Graph, goal_choices, shortest_ways


def reach_faults(graph: Graph, names: Sequence[str], goal_spacing: float, *, join: str) -> list[str]:
    """Return a line for each node that is cut off, and for each waypoint without a goal.

    Args:
        graph: at least one waypoint.
        names: of the nodes that may be named, from the first one on, waypoints first.
        goal_spacing: the shortest walk to a goal [m].
        join: what joins two nodes, in words.
    """
    distance, _ = shortest_ways(graph)
    groups, group = scipy.sparse.csgraph.connected_components(np.isfinite(distance), directed=False)
    # The largest connected part counts as the map; the other parts are the mistake.
    connected = group == np.bincount(group, minlength=groups).argmax()
    cut = np.flatnonzero(~connected[: len(names)]).tolist()
    choices = goal_choices(graph, distance, goal_spacing)
    return [f"{names[n]}: cut off from the others; join it by {join}" for n in cut] + [
        f"{names[n]}: no waypoint is {goal_spacing:g} m of walking away; add one farther away"
        for n in np.flatnonzero(connected[: graph.waypoints]).tolist()
        if not len(choices[n])
    ]
