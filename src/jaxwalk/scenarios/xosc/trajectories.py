"""Polylines that a ``FollowTrajectoryAction`` or a ``TrajectoryPosition`` names, and waypoints of routes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import pairwise

import numpy as np

from jaxwalk.scenarios.xosc.catalog_entries import CatalogEntries
from jaxwalk.scenarios.xosc.elements import XoscRefusal, called, number, only, part, word

MOST_VERTICES = 5000
"""Most vertices of a polyline, and waypoints of a route."""


def waypoints(action: ET.Element, catalogs: CatalogEntries) -> list[ET.Element]:
    """Return the waypoints of an ``AssignRouteAction``. Raise XoscRefusal if it has none."""
    route = catalogs.resolved(only(action))
    found = route.findall("Waypoint")
    if not found:
        raise XoscRefusal(f"{called(route)}: has no Waypoint; add one")
    _check_count(found)
    return found


def _check_count(places: list[ET.Element]) -> None:
    """Raise XoscRefusal for more places of a way than are read in seconds."""
    if len(places) > MOST_VERTICES:
        raise XoscRefusal(
            f"{places[0].tag}: {len(places):,} in one way; at most {MOST_VERTICES:,} are read, leave some out"
        )


def vertices(element: ET.Element, catalogs: CatalogEntries) -> list[ET.Element]:
    """Return the vertices of an element's trajectory. Raise XoscRefusal if it has no polyline."""
    if number(element, "initialDistanceOffset", 0.0) != 0:
        raise XoscRefusal(f"{element.tag}: initialDistanceOffset isn't supported; begin the trajectory there")
    holder = element.find("TrajectoryRef")
    inner = element if holder is None else holder
    own = inner.find("Trajectory")
    found = part(inner, "CatalogReference") if own is None else own
    with catalogs.naming(found):
        return _corners(catalogs.resolved(found))


def _corners(trajectory: ET.Element) -> list[ET.Element]:
    """Return the vertices of a ``Trajectory``. Raise XoscRefusal if it isn't an open polyline."""
    shape = only(part(trajectory, "Shape"))
    if shape.tag != "Polyline":
        raise XoscRefusal(f"{shape.tag}: isn't supported as the shape of a trajectory; write a Polyline")
    if trajectory.get("closed") == "true":
        raise XoscRefusal("Trajectory: closed ones aren't supported; write its vertices once more")
    corners = shape.findall("Vertex")
    if len(corners) < 2:
        raise XoscRefusal("Polyline: needs two vertices or more; add one")
    _check_count(corners)
    return corners


def timing_of(action: ET.Element) -> ET.Element | None:
    """Return the ``Timing`` of a ``FollowTrajectoryAction``; None where the road user's own speed counts.

    Raise XoscRefusal if it changes the times of the vertices: the standard says only that the scale is a factor of time
    values, and esmini takes its inverse.
    """
    timing = action.find("TimeReference/Timing")
    if timing is None:
        return None
    for name, plain in (("scale", 1.0), ("offset", 0.0)):
        if number(timing, name, plain) != plain:
            raise XoscRefusal(
                f"Timing: simulators differ on what {name} {word(timing, name)} is; write {plain:g}, and the times of "
                "the vertices as they shall be"
            )
    return timing


def times_of(corners: list[ET.Element]) -> np.ndarray:
    """Return the times of vertices, float64 (vertex,) [s]. Raise XoscRefusal if they don't rise."""
    times = np.array([number(one, "time") for one in corners])
    if any(late <= early for early, late in pairwise(times.tolist())):
        raise XoscRefusal("Polyline: the times of its vertices don't rise; correct them, or write TimeReference None")
    return times
