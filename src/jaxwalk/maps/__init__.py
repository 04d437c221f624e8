"""Maps: the file format, the loader with its checks, and the arrays that the simulator uses.

A name is imported when it is first used: what reads and checks maps needs no JAX.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from jaxwalk.lazy import imported_when_used

if TYPE_CHECKING:
    from jaxwalk.maps.file import MapError as MapError
    from jaxwalk.maps.load import build_map as build_map
    from jaxwalk.maps.load import load_map as load_map
    from jaxwalk.maps.map_reading import as_network as as_network
    from jaxwalk.maps.map_reading import bundled_maps as bundled_maps
    from jaxwalk.maps.map_reading import checked as checked
    from jaxwalk.maps.map_reading import each_map as each_map
    from jaxwalk.maps.map_reading import load_network as load_network
    from jaxwalk.maps.map_reading import map_content as map_content
    from jaxwalk.maps.map_reading import map_name as map_name
    from jaxwalk.maps.map_reading import read_map as read_map
    from jaxwalk.maps.map_reading import reference as reference
    from jaxwalk.maps.map_reading import text_of as text_of
    from jaxwalk.maps.map_text import MapText as MapText
    from jaxwalk.maps.map_text import map_labels as map_labels
    from jaxwalk.maps.map_text import text_hash as text_hash
    from jaxwalk.maps.road_map import RoadMap as RoadMap
    from jaxwalk.maps.routes import ROUTE_SPACING as ROUTE_SPACING
    from jaxwalk.maps.tables import stack_maps as stack_maps

_HOMES = {
    "ROUTE_SPACING": "routes",
    "MapError": "file",
    "MapText": "map_text",
    "RoadMap": "road_map",
    "as_network": "map_reading",
    "build_map": "load",
    "bundled_maps": "map_reading",
    "checked": "map_reading",
    "each_map": "map_reading",
    "load_map": "load",
    "load_network": "map_reading",
    "map_content": "map_reading",
    "map_labels": "map_text",
    "map_name": "map_reading",
    "read_map": "map_reading",
    "reference": "map_reading",
    "stack_maps": "tables",
    "text_hash": "map_text",
    "text_of": "map_reading",
}
"""Each public name, and the module of this package that defines it."""

__all__ = [*_HOMES]  # pyright: ignore[reportUnsupportedDunderAll]

__getattr__, __dir__ = imported_when_used(__name__, _HOMES)
