"""Maps: the file format, the loader with its checks, and the arrays that the simulator uses."""

from jaxwalk.maps.file import MapError
from jaxwalk.maps.load import bundled_maps, load_map
from jaxwalk.maps.road_map import ROUTE_SPACING, RoadMap
from jaxwalk.maps.tables import stack_maps

__all__ = ["ROUTE_SPACING", "MapError", "RoadMap", "bundled_maps", "load_map", "stack_maps"]
