"""Recordings in which the car doesn't perceive everybody."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from jaxwalk.sim.trajectory import Trajectory


def with_sight(recorded: Trajectory, hidden: Mapping[int, Sequence[tuple[int, int]]], *, delay: int = 0) -> Trajectory:
    """The recording where the car doesn't perceive people, by number, from one frame up to another."""
    perceived = np.ones(recorded.ped_x.shape, bool)
    for ped, times in hidden.items():
        for begin, end in times:
            perceived[begin:end, :, ped] = False
    x, y = np.zeros_like(recorded.ped_x), np.zeros_like(recorded.ped_y)
    age = np.full(x.shape, 1e6)
    for frame, now in enumerate(perceived):
        of = max(frame - delay, 0)
        before = max(frame - 1, 0)
        x[frame] = np.where(now, recorded.ped_x[of], x[before])
        y[frame] = np.where(now, recorded.ped_y[of], y[before])
        age[frame] = np.where(now, delay * recorded.dt, age[before] + recorded.dt)
    return replace(recorded, perceived=perceived, last_seen_x=x, last_seen_y=y, last_seen_age=age)
