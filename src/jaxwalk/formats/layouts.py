"""Files of trajectories, whatever their layout: the name tells."""

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
"""Values of `SimConfig` that the metrics depend on."""


@dataclass(frozen=True)
class Source:
    """An open file of trajectories."""

    recordings: Iterator[Tracks]
    areas: Areas | None
    """The ground, if the file says it."""
    rules: Mapping[str, Any]
    """Values of `SimConfig` that it was recorded with, if the file says them."""


def open_source(path: Path, *, frame_rate: float | None = None, number: int = 0) -> Source:
    """Open a file of trajectories: Parquet, inD, or DUT and CITR.

    Args:
        path: its name ends in .parquet, _tracks.csv, _traj_ped_filtered.csv or _traj_veh_filtered.csv.
        frame_rate: of DUT and CITR, whose files don't say it [1/s].
        number: of a clip of DUT or CITR, for the rows that are measured.

    Raises:
        TracksError: there is no such file, or it is of no known layout.
    """
    if not path.is_file():
        raise TracksError(f"{path}: no such file; check the path")
    if path.suffix == ".parquet":
        file = TrackFile(path)
        return Source(file.recordings(), file.areas, _rules(path, file.about))
    if path.name.endswith(ENDING):
        return Source(iter([read_ind(path)]), None, {})
    if not path.name.endswith((PEOPLE, VEHICLES)):
        endings = ", ".join((".parquet", ENDING, PEOPLE, VEHICLES))
        raise TracksError(f"{path}: of no known layout; the name must end in one of {endings}")
    if frame_rate is None:
        raise TracksError(f"{path}: does not say its frame rate; give it ({RATES})")
    return Source(iter([read_vci(path, frame_rate=frame_rate, number=number)]), None, {})


def _rules(path: Path, about: Mapping[str, Any]) -> dict[str, float]:
    """Those of the rules that a file says. TracksError for one that is no number."""
    rules = {name: about[name] for name in RULES if name in about}
    for name, value in rules.items():
        if type(value) not in (int, float) or not abs(value) <= LARGEST:
            raise TracksError(f"{path}: its {name} must be a number, not {shorten(repr(value), 100)}; write it anew")
    return {name: float(value) for name, value in rules.items()}
