"""Maps: the file format, the loader with its checks, and the arrays that the simulator uses."""

from jaxwalk.maps.file import MapError
from jaxwalk.maps.load import build_map, bundled_maps, load_map, map_name, read_map, reference, text_of
from jaxwalk.maps.map_text import MapText, map_labels, text_hash
from jaxwalk.maps.road_map import ROUTE_SPACING, RoadMap
from jaxwalk.maps.tables import stack_maps

__all__ = [
    "ROUTE_SPACING",
    "MapError",
    "MapText",
    "RoadMap",
    "build_map",
    "bundled_maps",
    "load_map",
    "map_labels",
    "map_name",
    "read_map",
    "reference",
    "stack_maps",
    "text_hash",
    "text_of",
]
