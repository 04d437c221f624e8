"""Polylines that a ``FollowTrajectoryAction`` or a ``TrajectoryPosition`` names."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from jaxwalk.scenarios.xosc.catalog_entries import CatalogEntries
from jaxwalk.scenarios.xosc.elements import XoscRefusal, only, part


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
