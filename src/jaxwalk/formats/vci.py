"""Clips of the DUT and CITR datasets: Yang et al. (2019), *Top-view Trajectories: A Pedestrian Dataset of
Vehicle-Crowd Interaction from Controlled Experiments and Crowded Campus*, IEEE Intelligent Vehicles Symposium.

The layout is that of the datasets' descriptions (github.com/dongfang-steven-yang/vci-dataset-dut and -citr, 2019): a
clip is ``NAME_traj_ped_filtered.csv`` (id, frame, label, x_est, y_est, vx_est, vy_est) and
``NAME_traj_veh_filtered.csv`` (id, frame, label, x_est, y_est, psi_est, vel_est). Units are metres and radians; y
points down, as in the image. No file states the frame rate: 23.976 /s in DUT, 29.97 /s in CITR.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from jaxwalk.formats.csv_columns import read_columns, seconds
from jaxwalk.formats.tracks import CAR, PEDESTRIAN, Tracks, TracksError

PEOPLE, VEHICLES = "_traj_ped_filtered.csv", "_traj_veh_filtered.csv"
"""Endings of the names of a clip's two files."""
RATES = "23.976 for DUT, 29.97 for CITR"
PLACE = ("id", "frame", "x_est", "y_est")


def read_vci(path: str | Path, *, frame_rate: float, number: int = 0) -> Tracks:
    """Read a clip by one of its two files; the other one must lie beside it. Sizes are NaN: no file states them.

    Args:
        path: either file.
        frame_rate: frames per second of the clip [1/s].
        number: value of ``Tracks.episode``, because the files have no number.

    Raises:
        TracksError: a file or column is missing, or the frame rate isn't above 0.
    """
    if not 0 < frame_rate < float("inf"):
        raise TracksError(f"the frame rate must be above 0 ({RATES}), not {frame_rate}")
    path = Path(path)
    stem = path.name.removesuffix(PEOPLE).removesuffix(VEHICLES)
    people = read_columns(path.with_name(stem + PEOPLE), (*PLACE, "vx_est", "vy_est"))
    cars = read_columns(path.with_name(stem + VEHICLES), (*PLACE, "psi_est", "vel_est"))
    cars["vx_est"] = cars["vel_est"] * np.cos(cars["psi_est"])
    cars["vy_est"] = cars["vel_est"] * np.sin(cars["psi_est"])
    people["psi_est"] = np.arctan2(people["vy_est"], people["vx_est"])
    both = {name: np.concatenate([cars[name], people[name]]) for name in (*PLACE, "vx_est", "vy_est", "psi_est")}
    rows = len(cars["id"]), len(people["id"])
    first = cars["id"].max(initial=-1) + 1  # both files count from 0, so pedestrians get the numbers after the vehicles
    return Tracks(
        episode=number,
        t=seconds(path, both["frame"], frame_rate),
        id=(both["id"] + np.repeat([0, first], rows)).astype(np.int64),
        type=np.repeat([CAR, PEDESTRIAN], rows),
        x=both["x_est"],
        y=both["y_est"],
        vx=both["vx_est"],
        vy=both["vy_est"],
        heading=both["psi_est"],
        length=np.full(sum(rows), np.nan),
        width=np.full(sum(rows), np.nan),
        known={},
    )
