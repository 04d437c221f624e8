"""Polylines that a ``FollowTrajectoryAction`` or a ``TrajectoryPosition`` names."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import pairwise

import numpy as np

from jaxwalk.scenarios.xosc.catalog_entries import CatalogEntries
from jaxwalk.scenarios.xosc.elements import XoscRefusal, number, only, part, word


def vertices(element: ET.Element, catalogs: CatalogEntries) -> list[ET.Element]:
    """Return the vertices of an element's trajectory. Raise XoscRefusal if it has no polyline."""
    holder = element.find("TrajectoryRef")
    inner = element if holder is None else holder
    found = inner.find("Trajectory")
    found = catalogs.resolved(part(inner, "CatalogReference")) if found is None else found
    shape = only(part(found, "Shape"))
    if shape.tag != "Polyline":
        raise XoscRefusal(f"{shape.tag}: isn't supported as the shape of a trajectory; write a Polyline")
    corners = shape.findall("Vertex")
    if len(corners) < 2:
        raise XoscRefusal("Polyline: needs two vertices or more; add one")
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
