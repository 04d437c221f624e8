"""Roadway and crosswalk of one place, as each clip of it shows them: drawn once, and turned and moved for each clip.

A camera in the air never hangs twice at the same spot, so the same ground has other coordinates in each clip.
"""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Annotated

import numpy as np
import shapely
from pydantic import ConfigDict, Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from jaxwalk.formats.areas import Areas
from jaxwalk.formats.tracks import TracksError
from jaxwalk.maps.file import Number, Point, explain

Outline = Annotated[tuple[Point, ...], Field(min_length=3)]
_EXACT = ConfigDict(extra="forbid")


@dataclass(frozen=True, config=_EXACT)
class CameraPlace:
    """Where a point of the drawing is in a clip: first scaled, then turned about the origin, then moved."""

    turn: Number
    """From the x axis towards the y axis [degrees]."""
    scale: Annotated[Number, Field(gt=0)]
    move: Point
    """[m]"""


@dataclass(frozen=True, config=_EXACT)
class ClipGrounds:
    """The ground of all clips of one place."""

    frame_rate: Annotated[Number, Field(gt=0)]
    """Frames per second of the clips [1/s]."""
    roadway: Outline
    """Corners of the drawing [m]: everything between the kerbs, with the crosswalk."""
    crosswalk: Outline
    clips: dict[str, CameraPlace]
    """By the name of the clip's files up to ``_traj_...``."""

    def areas(self, clip: str) -> Areas:
        """Return roadway and crosswalk in the metres of a clip."""
        place = self.clips[clip]
        cos, sin = (place.scale * turn(math.radians(place.turn)) for turn in (math.cos, math.sin))
        turned = np.array([[cos, sin], [-sin, cos]])
        roadway, crosswalk = (
            shapely.Polygon(np.array(outline) @ turned + place.move) for outline in (self.roadway, self.crosswalk)
        )
        shapely.prepare([roadway, crosswalk])
        return Areas(roadway=roadway, crosswalk=crosswalk)


def read_clip_grounds(path: Path) -> ClipGrounds:
    """Read a file of grounds. Raises TracksError if it isn't one, or an outline crosses itself."""
    try:
        found = TypeAdapter(ClipGrounds).validate_python(tomllib.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise TracksError(f"{path}: can't be read ({error.strerror}); check the path") from None
    except ValidationError as error:
        raise TracksError(f"{path}: {explain(dict(error.errors()[0]))}") from None
    except ValueError as error:
        raise TracksError(f"{path}: not TOML ({error}); correct it (docs: real-recordings)") from None
    for name in ("roadway", "crosswalk"):
        if not shapely.Polygon(getattr(found, name)).is_valid:
            raise TracksError(f"{path}: {name}: the outline crosses itself; give its corners in their order")
    return found
