"""Loading a map by name or path."""

from __future__ import annotations

from dataclasses import fields
from functools import lru_cache
from pathlib import Path

from jaxwalk.maps.layout import lay_out
from jaxwalk.maps.map_reading import checked, map_content
from jaxwalk.maps.network import Network
from jaxwalk.maps.road_map import RoadMap
from jaxwalk.maps.tables import build

KEPT = 16
"""How many maps are kept: a large one takes 3 MB."""


def load_map(name_or_path: str | Path, *, goal_spacing: float = 20.0, start_clearance: float = 10.0) -> RoadMap:
    """Load a bundled map by name, or a ``.toml`` or ``.json`` file by its path, as numpy arrays (float32, int32, bool).

    ``goal_spacing`` and ``start_clearance`` [m] are those of SimConfig. Raises MapError, with a line for every fault,
    if the map can't be read or is wrong.
    """
    text, source = map_content(name_or_path), str(name_or_path)
    return build_map(text, source, goal_spacing=goal_spacing, start_clearance=start_clearance)


@lru_cache(maxsize=KEPT)
def build_map(text: str, source: str, *, goal_spacing: float, start_clearance: float) -> RoadMap:
    """Return the arrays of a file's text, as `load_map` does. ``source`` names the map in a MapError.

    They are kept, because worlds of the same map are made several times, and so can't be written to.
    """
    found = checked(text, source, goal_spacing=goal_spacing, start_clearance=start_clearance)
    if isinstance(found, Network):
        arrays = lay_out(found, goal_spacing=goal_spacing, start_clearance=start_clearance)
    else:
        arrays = build(found, goal_spacing=goal_spacing, start_clearance=start_clearance)
    for field in fields(arrays):
        getattr(arrays, field.name).flags.writeable = False
    return arrays
