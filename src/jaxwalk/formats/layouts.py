"""Files of trajectories in any known layout. The file's name tells the layout."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from textwrap import shorten
from typing import Any

from jaxwalk.formats.areas import Areas
from jaxwalk.formats.ind import ENDING, read_ind
from jaxwalk.formats.track_file import TrackFile
from jaxwalk.formats.tracks import LARGEST, Tracks, TracksError
from jaxwalk.formats.vci import PEOPLE, RATES, VEHICLES, read_vci

RULES = ("dt", "collision_distance", "moving_speed")
"""Fields of `SimConfig` on which the metrics depend."""


@dataclass(frozen=True)
class TrackSource:
    """An open file of trajectories."""

    recordings: Iterator[Tracks]
    """The recordings, read one after the other."""
    areas: Areas | None
    """Roadway and crosswalks, if the file has them."""
    rules: Mapping[str, Any]
    """Values of `SimConfig` with which it was recorded, if the file has them."""


def open_tracks(path: Path, *, frame_rate: float | None = None, number: int = 0) -> TrackSource:
    """Open a file of trajectories: Parquet, inD, or DUT and CITR.

    Args:
        path: its name ends in .parquet, _tracks.csv, _traj_ped_filtered.csv or _traj_veh_filtered.csv.
        frame_rate: frames per second of DUT and CITR, whose files don't state it [1/s].
        number: the episode number to give a clip of DUT or CITR, whose files have none.

    Raises:
        TracksError: there is no such file, its layout is unknown, or its frame rate is missing.
    """
    if not path.is_file():
        raise TracksError(f"{path}: no such file; check the path")
    if path.suffix == ".parquet":
        file = TrackFile(path)
        return TrackSource(file.recordings(), file.areas, _rules(path, file.about))
    if path.name.endswith(ENDING):
        return TrackSource(iter([read_ind(path)]), None, {})
    if not path.name.endswith((PEOPLE, VEHICLES)):
        endings = ", ".join((".parquet", ENDING, PEOPLE, VEHICLES))
        raise TracksError(f"{path}: unknown layout; the name must end in one of {endings}")
    if frame_rate is None:
        raise TracksError(f"{path}: does not state its frame rate; give it ({RATES})")
    return TrackSource(iter([read_vci(path, frame_rate=frame_rate, number=number)]), None, {})


def _rules(path: Path, about: Mapping[str, Any]) -> dict[str, float]:
    """Return the rules that a file states. Raises TracksError if one isn't a number."""
    rules = {name: about[name] for name in RULES if name in about}
    for name, value in rules.items():
        if type(value) not in (int, float) or not abs(value) <= LARGEST:
            raise TracksError(f"{path}: its {name} must be a number, not {shorten(repr(value), 100)}; write it again")
    return {name: float(value) for name, value in rules.items()}
