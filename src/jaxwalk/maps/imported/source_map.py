"""What every format is read into: lanes, ground, crossings, and what the source says of sidewalks. All in metres."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from jaxwalk.maps.network import CrossingType, Lane

Origin = Literal["mapped", "inferred", "invented"]
"""``mapped``: the source has the element itself; ``inferred``: it follows from an attribute of another element, by a
rule of ``docs/real-streets.md``; ``invented``: the source says nothing of it."""


Box = tuple[float, float, float, float]
"""West, south, east and north end [m]."""


class StreetFrame(NamedTuple):
    """Where a street lies in a source map."""

    box: Box
    mirrored: bool = False
    """Whether the source map is mirrored, and the street isn't."""

    def placed(self, points: np.ndarray, digits: int = 3) -> np.ndarray:
        """Return points of the source map (..., 2) in the street, rounded [m]."""
        west, south, east, _ = self.box
        x = east - points[..., 0] if self.mirrored else points[..., 0] - west
        return np.round(np.stack([x, points[..., 1] - south], axis=-1), digits)


@dataclass(frozen=True)
class SourceCrossing:
    """A place where people cross a roadway."""

    name: str
    """The element in the source, such as ``node 123``."""
    kind: CrossingType
    point: np.ndarray
    """A point of the roadway on its way (2,) [m]."""
    across: np.ndarray | None = None
    """Unit vector of the way over the roadway; None: straight over it."""
    kind_origin: Origin = "mapped"
    """Where the kind is from."""
    width: float = 4.0
    """Along the road [m]."""
    island: bool = False
    """Whether the source says that it has an island."""


@dataclass(frozen=True)
class WalkEvidence:
    """A line along which the source says something of a sidewalk."""

    line: np.ndarray
    """(point, 2) [m]."""
    origin: Literal["mapped", "inferred"]
    reach: float
    """It speaks of kerbs that are nearer than this [m]."""


@dataclass(frozen=True)
class SourceMap:
    """A part of the world as a source has it. Traffic drives on the right."""

    format: str
    attribution: str
    """Whose data it is, to be shown wherever the streets are drawn."""
    extent: Box
    """West, south, east and north end of what is to be imported [m]."""
    lanes: tuple[Lane, ...]
    in_junction: np.ndarray
    """Which lanes lead through junctions, bool (lane,)."""
    roadway: BaseGeometry
    junctions: tuple[BaseGeometry, ...]
    """Regions that no street's edge may cut."""
    open_ends: tuple[BaseGeometry, ...]
    """Where roads go on beyond what is imported: streets end before these regions."""
    crossings: tuple[SourceCrossing, ...]
    evidence: tuple[WalkEvidence, ...]
    parking: tuple[shapely.Polygon, ...] = ()
    """Strips at kerbs where vehicles park."""
    buildings: tuple[shapely.Polygon, ...] = ()
    elements: tuple[dict[str, Any], ...] = ()
    """For the report: roads with the facts about them, and where each fact is from."""
    left_out: tuple[str, ...] = ()
    """What isn't imported, and why, in sentences."""
    notes: tuple[str, ...] = ()
    """What else a reader of the report should know of the source, in sentences."""
    elsewhere: dict[str, int] = field(default_factory=dict)
    """Number of crossings of what isn't imported, such as tracks and cycleways."""
    mirrored: bool = False
    """Whether x counts to the west, because traffic keeps left: streets are turned back at the end."""
