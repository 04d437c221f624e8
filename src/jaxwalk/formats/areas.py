"""Areas of the roadway and the crosswalks, read from GeoJSON or made from a map."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import numpy as np
import shapely
from jaxtyping import Bool, Float
from shapely.geometry.base import BaseGeometry

from jaxwalk.formats.tracks import TracksError
from jaxwalk.maps.network import AreaKind, Network

KINDS = get_args(AreaKind)
"""Values of a feature's ``kind``. Only the roadway and crosswalks are measured with."""


@dataclass(frozen=True)
class Areas:
    """The roadway and the crosswalks of one place."""

    roadway: BaseGeometry
    """Everything between the kerbs, with the crosswalks [m]."""
    crosswalk: BaseGeometry
    """All crosswalks [m]."""

    def locate(
        self, x: Float[np.ndarray, "..."], y: Float[np.ndarray, "..."]
    ) -> tuple[Bool[np.ndarray, "..."], Bool[np.ndarray, "..."]]:
        """Return which points are on the roadway, and which on a crosswalk. Kerb points and NaN are on neither."""
        return shapely.contains_xy(self.roadway, x, y), shapely.contains_xy(self.crosswalk, x, y)


def areas_of(network: Network) -> dict[str, Any]:
    """Return the areas of a street as GeoJSON: a polygon for each [m]."""
    features = [
        {"type": "Feature", "properties": {"kind": area.kind}, "geometry": json.loads(shapely.to_geojson(area.shape()))}
        for area in network.areas
    ]
    return {"type": "FeatureCollection", "features": features}


def read_areas(path: str | Path) -> Areas:
    """Read the areas of a GeoJSON file. Raises TracksError if it isn't one."""
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise TracksError(f"{path}: not GeoJSON ({error}); correct it (docs: trajectories)") from None
    return parse_areas(document, str(path))


def parse_areas(document: Any, source: str) -> Areas:
    """Return the areas of a GeoJSON document; messages name its ``source``.

    Raises TracksError if it has no roadway, or a feature that isn't a valid polygon of a known kind.
    """
    if not isinstance(document, Mapping) or document.get("type") != "FeatureCollection":
        raise TracksError(f"{source}: the areas must be a GeoJSON FeatureCollection (docs: trajectories)")
    shapes: dict[str, list[BaseGeometry]] = {kind: [] for kind in KINDS}
    features = document.get("features")
    if not isinstance(features, list):
        raise TracksError(f"{source}: its features must be a list (docs: trajectories)")
    for number, feature in enumerate(features):
        kind, shape = _feature(feature, f"{source}: feature {number}")
        shapes[kind].append(shape)
    if not shapes["roadway"]:
        raise TracksError(f'{source}: has no feature with {{"kind": "roadway"}} in its properties; add one')
    roadway, crosswalk = (shapely.union_all(shapes[kind]) for kind in ("roadway", "crosswalk"))
    shapely.prepare([roadway, crosswalk])
    return Areas(roadway=roadway, crosswalk=crosswalk)


def _feature(feature: Any, source: str) -> tuple[str, BaseGeometry]:
    """Return the kind and the shape of one feature. Raises TracksError if it isn't a polygon of a known kind."""
    try:
        kind, shape = feature["properties"]["kind"], shapely.from_geojson(json.dumps(feature["geometry"]))
    except (KeyError, TypeError, shapely.GEOSException) as error:
        raise TracksError(f"{source}: needs properties.kind and a geometry ({error})") from None
    if not isinstance(kind, str) or kind not in KINDS:
        raise TracksError(f"{source}: kind must be one of {', '.join(KINDS)}, not {kind!r}")
    if shape is None or shape.geom_type not in ("Polygon", "MultiPolygon") or not shape.is_valid:
        raise TracksError(f"{source}: must be a polygon that does not cross itself")
    return kind, shape
