"""Recordings of the inD dataset: Bock et al. (2020), *The inD Dataset*, IEEE Intelligent Vehicles Symposium.

The layout is that of the dataset's own reader (github.com/ika-rwth-aachen/drone-dataset-tools, ``tracks_import.py``).
rounD and uniD have the same columns. ``XX_tracks.csv`` has a row for each track and frame, ``XX_tracksMeta.csv`` a row
for each track, ``XX_recordingMeta.csv`` one row. Units are metres and degrees. The data needs registration.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from jaxwalk.formats.csv_columns import read_columns, seconds
from jaxwalk.formats.tracks import CAR, PEDESTRIAN, Tracks, TracksError

ENDING = "_tracks.csv"
"""Ending of the name of a recording's main file."""
COLUMNS = ("trackId", "frame", "xCenter", "yCenter", "heading", "width", "length", "xVelocity", "yVelocity")
TYPES = {"car": CAR, "pedestrian": PEDESTRIAN}
"""Names of the dataset's classes in `Tracks.type`; other classes keep their names."""


def read_ind(path: str | Path) -> Tracks:
    """Read the recording of a ``XX_tracks.csv``. Its two other files must lie beside it.

    Raises:
        TracksError: a file or column is missing, or a track has no class.
    """
    path = Path(path)
    stem = path.name.removesuffix(ENDING)
    columns = read_columns(path, COLUMNS)
    tracks = read_columns(path.with_name(f"{stem}_tracksMeta.csv"), ("trackId",), ("class",))
    recording = read_columns(path.with_name(f"{stem}_recordingMeta.csv"), ("recordingId", "frameRate"))
    if len(recording["frameRate"]) != 1 or not recording["frameRate"][0] > 0:
        raise TracksError(f"{stem}_recordingMeta.csv: must have one row with a frameRate above 0; restore it")
    classes = dict(zip(tracks["trackId"].tolist(), tracks["class"].tolist(), strict=True))
    ids = columns["trackId"]
    if strange := set(ids.tolist()) - classes.keys():
        raise TracksError(f"{stem}_tracksMeta.csv: has no track {min(strange):g}; restore it")
    return Tracks(
        episode=int(recording["recordingId"][0]),
        t=seconds(path, columns["frame"], float(recording["frameRate"][0])),
        id=ids.astype(np.int64),
        type=np.array([TYPES.get(classes[track], classes[track]) for track in ids.tolist()], object),
        x=columns["xCenter"],
        y=columns["yCenter"],
        vx=columns["xVelocity"],
        vy=columns["yVelocity"],
        heading=np.radians(columns["heading"]),
        length=columns["length"],
        width=columns["width"],
        known={},
    )
